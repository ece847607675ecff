"""PySR's engine: its settings against the installed source, its worker against a stub."""

from __future__ import annotations

import ast
import importlib.util
import json
from pathlib import Path
from typing import Any

import pytest
import sympy
from regression_data import QUADROTOR, concatenated, drawn, flights

from sym2real.errors import MissingDependencyError, ModelError, UnknownNameError
from sym2real.regression import PySR
from sym2real.regression.pysr import SETTINGS, expression_of
from sym2real.symbolic import symbol

TESTS = Path(__file__).parent
PYSR = importlib.util.find_spec("pysr") is not None


def linear(seed: int = 0):  # type: ignore[no-untyped-def]
    return drawn("ab", "u", lambda v: {"a": 0.1 * v["b"], "b": -0.3 * v["a"] + 0.5 * v["u"]}, seed=seed)


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PYTHONPATH", str(TESTS))
    monkeypatch.setenv("STUB_LOG", str(tmp_path / "fits.jsonl"))
    return tmp_path / "fits.jsonl"


def fits(log: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]


def test_every_setting_is_an_argument_of_the_installed_pysr() -> None:
    found = importlib.util.find_spec("pysr")
    if found is None or found.origin is None:
        pytest.skip("PySR is not installed: pip install 'sym2real[pysr]'")
    tree = ast.parse((Path(found.origin).parent / "sr.py").read_text(encoding="utf-8"))
    (regressor,) = [n for n in tree.body if isinstance(n, ast.ClassDef) and n.name == "PySRRegressor"]
    methods = {node.name: node.args for node in regressor.body if isinstance(node, ast.FunctionDef)}
    made = {argument.arg for argument in (*methods["__init__"].args, *methods["__init__"].kwonlyargs)}
    assert {*SETTINGS, "random_state"} <= made
    fitted = {argument.arg for argument in (*methods["fit"].args, *methods["fit"].kwonlyargs)}
    assert "variable_names" in fitted
    assert "get_best" in methods


def test_the_settings_are_the_papers() -> None:
    assert set(SETTINGS["binary_operators"]) == {"+", "-", "*"}
    assert set(SETTINGS["unary_operators"]) == {"cos", "sin"}
    assert (SETTINGS["maxsize"], SETTINGS["niterations"], SETTINGS["warm_start"]) == (85, 5, True)
    assert SETTINGS["elementwise_loss"] == "L1DistLoss()"


def test_one_process_keeps_one_regressor_per_column_for_the_whole_loop(log: Path) -> None:
    engine = PySR(factory="stub_regressor:Logged")
    first = engine.fit(linear(1))
    second = engine.fit(concatenated(linear(1), linear(2)), first)
    engine.fit(linear(3), second)
    engine.close()
    lines = fits(log)
    assert [line["number"] for line in lines] == [1, 2, 1, 2, 1, 2]
    assert [line["fits"] for line in lines] == [1, 1, 2, 2, 3, 3]
    assert len({line["process"] for line in lines}) == 1
    assert all(line["settings"] == {**SETTINGS, "random_state": 0} for line in lines)


def test_a_fit_without_start_begins_afresh(log: Path) -> None:
    engine = PySR(factory="stub_regressor:Logged")
    engine.fit(linear(1))
    engine.fit(linear(2))
    engine.close()
    assert [(line["number"], line["fits"]) for line in fits(log)] == [(1, 1), (2, 1), (3, 1), (4, 1)]


def test_torch_never_enters_the_worker(log: Path) -> None:
    engine = PySR(factory="stub_regressor:Logged")
    engine.fit(linear())
    engine.close()
    assert not any(line["torch"] for line in fits(log))


def test_equations_come_back_as_the_stub_found_them(log: Path) -> None:
    engine = PySR(factory="stub_regressor:Logged")
    equations = engine.fit(linear())
    engine.close()
    difference = sympy.expand(equations.next["b"] - (symbol("b") - 0.3 * symbol("a") + 0.5 * symbol("u")))
    assert all(abs(float(number)) < 1e-9 for number in difference.as_coefficients_dict().values())


def test_pushed_rows_add_wrench_terms(log: Path) -> None:
    engine = PySR(factory="stub_regressor:Logged")
    equations = engine.fit(concatenated(flights(1, count=2, steps=60), flights(2, count=2, steps=60, pushed=True)))
    engine.close()
    assert equations.depends("vx", "fx")
    assert not any(set(line["names"]) & set(QUADROTOR.inputs) for line in fits(log))
    assert all({"vx", "thrust", "qw"} <= set(line["names"]) for line in fits(log))
    assert max(equations.complexity().values()) <= 85


def test_a_failing_search_is_told_and_the_worker_lives(log: Path) -> None:
    engine = PySR(factory="stub_regressor:Failing")
    for _ in range(2):
        with pytest.raises(ModelError, match="ArithmeticError: the search diverged"):
            engine.fit(linear())
    engine.close()


def test_a_dead_worker_leaves_its_last_words(log: Path, capfd: pytest.CaptureFixture[str]) -> None:
    engine = PySR(factory="stub_regressor:Dying")
    with pytest.raises(ModelError, match="exit code 3"):
        engine.fit(linear())
    assert "segmentation fault in libjulia" in capfd.readouterr().err
    engine.close()


def test_a_worker_that_was_killed_is_one_clear_error_and_is_closed(log: Path) -> None:
    engine = PySR(factory="stub_regressor:Logged")
    engine.fit(linear())
    assert engine._worker is not None
    engine._worker.kill()
    engine._worker.wait()
    with pytest.raises(ModelError, match="exit code -9"):
        engine.fit(linear())
    engine.close()


def test_a_factory_that_cannot_be_imported_is_one_clear_error(log: Path) -> None:
    with pytest.raises(ModelError, match="No module named 'no_such_module'"):
        PySR(factory="no_such_module:Regressor").fit(linear())


@pytest.mark.skipif(PYSR, reason="PySR is installed")
def test_without_pysr_one_message_says_what_to_install() -> None:
    with pytest.raises(MissingDependencyError, match=r"pip install(.|\n)*import pysr"):
        PySR()


@pytest.mark.skipif(not PYSR, reason="needs PySR: pip install 'sym2real[pysr]', python -c 'import pysr'")
def test_pysr_itself_finds_a_line() -> None:
    engine = PySR()
    equations = engine.fit(linear())
    engine.close()
    assert equations.depends("b", "u")


def test_julias_single_precision_is_read() -> None:
    found = expression_of("a + (b * 1.0f-1) + sin(b)^2", ["a", "b"], 85)
    assert sympy.expand(found - symbol("a") - 0.1 * symbol("b") - sympy.sin(symbol("b")) ** 2) == 0


@pytest.mark.parametrize("text", ["__import__('os').getcwd()", "a + nonsense"])
def test_an_equation_of_anything_else_is_refused(text: str) -> None:
    with pytest.raises((ModelError, UnknownNameError)):
        expression_of(text, ["a", "b"], 85)


def test_an_equation_that_is_too_large_is_refused() -> None:
    with pytest.raises(ModelError, match="at most 3 nodes"):
        expression_of("a + (b * 2.0)", ["a", "b"], 3)
