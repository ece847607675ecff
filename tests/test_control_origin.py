"""What a kernel's text follows from stands for the text in the cache: whatever changes the one changes the other."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
import sympy
from reference_models import late, motor_lagged

from sym2real.control.fused_filters import FilterLines
from sym2real.control.fused_problem import Fused, Sampling
from sym2real.control.fused_residual import Network
from sym2real.control.fused_text import fused_text, origin_of
from sym2real.effects.filters import FilterState
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import Equations, origin, symbol
from sym2real.symbolic.origin import origin_of_expression
from sym2real.tasks import make_task


def step() -> Fused:
    equations = motor_lagged()
    values = {**equations.parameters, "k": 0.1}
    moved = {**equations.next, "x": equations.next["x"] + symbol("k") * sympy.sin(0.1 * symbol("wx_cmd"))}
    equations = replace(equations, next=moved, parameters=values)
    task = make_task("circle", CRAZYFLIE)
    return Fused(equations, CRAZYFLIE, task.cost, Sampling(0, True), FilterLines(None, ("thrust",), 0.02))


def with_equations(one: Fused, **changed: object) -> Fused:
    return replace(one, equations=replace(one.equations, **changed))


def nudged(one: Fused) -> Fused:
    """One number of one equation, in its last bit but a few: as close as two float32 numbers are."""
    number = max(one.equations.next["vz"].atoms(sympy.Float))
    other = sympy.Float(float(number) * (1.0 + 2.0**-22))
    return with_equations(one, next={**one.equations.next, "vz": one.equations.next["vz"].xreplace({number: other})})


CHANGES: dict[str, Callable[[Fused], Fused]] = {
    "a number": nudged,
    "a parameter's value": lambda one: with_equations(one, parameters={**one.equations.parameters, "k": 0.2}),
    "an equation": lambda one: with_equations(
        one, next={**one.equations.next, "y": one.equations.next["y"] + sympy.sin(symbol("vx"))}
    ),
    "a start": lambda one: with_equations(
        one, start={column: 0.5 * value for column, value in one.equations.start.items()}
    ),
    "a limit": lambda one: replace(one, robot=replace(one.robot, high=one.robot.high * 3.0)),
    "the cost": lambda one: replace(one, cost=one.cost + symbol("vx") ** 2),
    "the colour": lambda one: replace(one, sampling=Sampling(1, True)),
    "the covariance": lambda one: replace(one, sampling=Sampling(0, False)),
    "a residual": lambda one: replace(one, residual=Network((17, 8, 13), 0, 0)),
    "a residual with memory": lambda one: replace(one, residual=Network((33, 8, 13), 4, 0)),
    "a filter": lambda one: replace(one, filters=filters(late(CRAZYFLIE))),
}


def filters(equations: Equations) -> FilterLines:
    return FilterLines(FilterState(equations), CRAZYFLIE.layouts.action.columns, equations.dt)


@pytest.mark.parametrize("what", CHANGES)
def test_whatever_changes_the_text_changes_the_origin(what: str) -> None:
    before, after = step(), CHANGES[what](step())
    assert fused_text(before) != fused_text(after)
    assert origin_of(before) != origin_of(after)
    assert origin_of(after) == origin_of(CHANGES[what](step()))


def test_values_of_filters_count() -> None:
    task = make_task("circle", MUSHR)
    found = set()
    for period in (1.0, 1.5):
        equations = replace(late(), filters=(("delay", {"value": sympy.Float(period * MUSHR.dt)}),))
        lines = FilterLines(FilterState(equations), MUSHR.layouts.action.columns, MUSHR.dt)
        found.add(origin_of(Fused(equations, MUSHR, task.cost, Sampling(0, True), lines)))
    assert len(found) == 2


def test_expressions_that_differ_are_written_differently() -> None:
    x, y = symbol("x"), symbol("y")
    expressions = [
        x + y, x * y, x - y, x / y, x**2, x**3, sympy.sqrt(x), sympy.Min(x, y), sympy.Max(x, y), 2 * x, 2.0 * x,
        sympy.Float(1 / 3) * x, sympy.Rational(1, 3) * x, math.nextafter(1 / 3, 1) * x, sympy.pi * x, sympy.E * x,
        sympy.Piecewise((x, x < y), (y, True)), sympy.Piecewise((x, x <= y), (y, True)), sympy.atan2(x, y),
        sympy.atan2(y, x), sympy.Piecewise((x, sympy.Ne(x, y)), (y, True)), sympy.Abs(x),
    ]  # fmt: skip
    assert len({origin_of_expression(one) for one in expressions}) == len(expressions)


def test_every_process_finds_the_same_origin() -> None:
    """Hashes of strings differ from process to process, and with them the order of sets."""
    code = (
        "import sys, hashlib; sys.path.insert(0, sys.argv[1])\n"
        "from test_control_origin import step, origin_of\n"
        "print(hashlib.sha256(origin_of(step()).encode()).hexdigest())"
    )
    command = [sys.executable, "-c", code, str(Path(__file__).parent)]
    found = {subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(2)}
    assert len(found) == 1


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], str]:
    """Gives one file a content of one size and one date, and says who writes texts after an import."""
    for room in origin.ROOMS:
        (tmp_path / room).mkdir(exist_ok=True)
        (tmp_path / room / "module.py").write_text("1")
    monkeypatch.setattr(origin, "PACKAGE", tmp_path)

    def imported(content: str) -> str:
        file = tmp_path / "control" / "module.py"
        file.write_text(content)
        os.utime(file, (1.0, 1.0))
        monkeypatch.setattr(origin, "_DATES", origin._dates())
        origin._content.cache_clear()
        return origin.generators()

    yield imported
    origin._content.cache_clear()


def test_files_of_one_size_and_date_differ_by_their_content(package: Callable[[str], str]) -> None:
    """So they stand in an image that was built to be reproducible, or after an upgrade that keeps dates."""
    assert package("REACH = 16.0") != package("REACH = 32.0")
    assert package("REACH = 16.0") == package("REACH = 16.0")


def test_a_file_edited_after_the_import_shares_nothing(package: Callable[[str], str]) -> None:
    """A notebook that imported the old file must not leave its kernel where those with the new one look."""
    before = package("REACH = 16.0")
    (origin.PACKAGE / "control" / "module.py").write_text("REACH = 32.0")
    during = {origin.generators(), origin.generators()}
    assert len(during) == 2
    assert not during & {before, package("REACH = 32.0")}
