"""The package's face: what it shows, that all of it has an example that runs, and what equations and answers offer."""

import doctest
import importlib
import inspect
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import pytest
import torch

import sym2real
from sym2real import (
    Equations,
    Layouts,
    Trajectory,
    add,
    car,
    compare,
    diagnose,
    example_flight,
    plan,
    quadrotor,
    read_log,
    try_effect,
)
from sym2real.errors import DataError, ModelError, ShapeError
from sym2real.registry import Registry
from sym2real.report.style import save
from sym2real.robots import ROBOTS, Motors, fit_thrust_per_unit
from sym2real.symbolic.native_choice import torch_alone
from sym2real.upward import OWNERS, upward

SPEC = "crazyflie_battery_drag"


@pytest.fixture(scope="module")
def flight() -> Trajectory:
    """Eight seconds of the real flight, for equations per unit of mass."""
    layouts = quadrotor(interface="motors", attitude="measured").layouts
    return read_log(example_flight(), SPEC, layouts, 0.02).rows(0, 400)


@pytest.fixture(scope="module")
def equations(flight: Trajectory) -> Equations:
    return quadrotor(interface="motors", attitude="measured", motors=Motors(thrust=fit_thrust_per_unit(flight)))


def documented(name: str) -> object:
    """What holds the example of a public name: a registry has its package's text."""
    value = getattr(sym2real, name)
    if isinstance(value, Registry):
        return importlib.import_module(sym2real._OWNERS[name])
    return value


def test_the_package_shows_what_is_public_and_nothing_else() -> None:
    assert set(dir(sym2real)) == {*sym2real.__all__, "__version__"}
    for name in sym2real.__all__:
        assert getattr(sym2real, name) is not None


@pytest.mark.parametrize("name", sym2real.__all__)
def test_every_public_name_has_an_example_that_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = inspect.getdoc(documented(name)) or ""
    public: dict[str, Any] = {known: getattr(sym2real, known) for known in sym2real.__all__}
    example = doctest.DocTestParser().get_doctest(text, {**public, "np": np, "torch": torch}, name, None, 0)
    assert any(name in one.source for one in example.examples), f"{name} has no example of its own"
    out: list[str] = []
    failed = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=out.append).failed
    assert not failed, "".join(out)


def test_work_of_rooms_above_is_where_it_is_listed() -> None:
    for name in OWNERS:
        assert callable(upward(name))


@pytest.mark.parametrize("robot", ["cart_pole", "mushr", "crazyflie"])
def test_inputs_that_are_not_given_are_zero(robot: str) -> None:
    model, start = ROBOTS[robot].nominal(), np.asarray(ROBOTS[robot].start)
    action, none = np.zeros(len(model.layouts.action)), np.zeros(model.layouts.inputs.size)
    np.testing.assert_array_equal(model.predict(start, action), model.predict(start, action, none))
    rows = model.predict(np.stack([start] * 3), np.stack([action] * 3))
    np.testing.assert_allclose(rows[2], model.predict(start, action))


def test_numpy_gives_numpy_and_tensors_give_tensors(flight: Trajectory, equations: Equations) -> None:
    """One step is the same whatever it is asked with, in any batch shape."""
    rows = [flight.state[:20], flight.action[:20], flight.inputs[:20]]
    following = equations.predict(*rows)
    assert isinstance(following, np.ndarray)
    tensors = equations.predict(*(torch.as_tensor(part) for part in rows))
    assert isinstance(tensors, torch.Tensor)
    np.testing.assert_allclose(tensors.numpy(), following)
    single = equations.predict(*(part[3] for part in rows))
    np.testing.assert_allclose(single, following[3])
    # Position follows velocity and half the acceleration, whatever pushes.
    moved, change = following[:, :3] - rows[0][:, :3], following[:, 3:] + rows[0][:, 3:]
    np.testing.assert_allclose(moved, 0.01 * change, atol=1e-12)


def test_a_simulated_log_is_a_log_that_its_equations_predict(flight: Trajectory, equations: Equations) -> None:
    """Equations predict their own simulation without error, and with a drag they predict the flight better."""
    simulated = equations.simulate(flight)
    assert len(simulated) == len(flight)
    assert min(equations.score(simulated, horizon=0.4).values()) > 99.0
    again = equations.simulate(simulated, horizon=0.1)
    np.testing.assert_allclose(again.state, simulated.state, atol=1e-3)
    slowed = add(equations, "linear_drag", {"cx": 0.45, "cy": 0.45})
    plain, better = (model.score(flight, horizon=0.8)["velocity"] for model in (equations, slowed))
    assert better > plain + 10.0
    near, far = (np.abs(equations.simulate(flight, horizon=one).state - flight.state).max() for one in (0.1, 1.0))
    assert near < far


def test_delays_are_in_a_simulation() -> None:
    """A car whose speed arrives two steps late starts to move two steps later."""
    model = car(wheelbase=0.3)
    state = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (12, 1))
    action = np.column_stack([np.zeros(12), np.where(np.arange(12) < 3, 0.0, 1.0)])
    log = Trajectory.from_arrays(state, action, model.layouts, dt=model.dt)
    prompt, late = (one.simulate(log).column("x") for one in (model, add(model, "delay:speed", {"value": 0.1})))
    np.testing.assert_allclose(late[2:], prompt[:-2], atol=1e-9)
    assert prompt[-1] > 0.1


def test_horizons_and_columns_that_do_not_fit_are_refused(flight: Trajectory, equations: Equations) -> None:
    for wrong in (lambda: equations.simulate(flight, horizon=0.001), lambda: equations.score(flight, horizon=0.001)):
        with pytest.raises(ShapeError, match=r"0\.02 s"):
            wrong()
    with pytest.raises(ShapeError, match="columns"):
        car(wheelbase=0.3).simulate(flight)


def test_a_frame_holds_a_log_without_loss(flight: Trajectory) -> None:
    back = Trajectory.from_pandas(flight.to_pandas())
    assert back.layouts == flight.layouts
    assert back.name == flight.name
    for part in ("time", "state", "action", "inputs"):
        np.testing.assert_array_equal(getattr(back, part), getattr(flight, part))


def test_a_frame_opens_as_the_file_does() -> None:
    """The flight's own columns, in their units and under their names, by the specification of its file."""
    frame = pd.read_csv(example_flight())
    log, wanted = Trajectory.from_pandas(frame, SPEC), read_log(example_flight(), SPEC)
    np.testing.assert_allclose(log.state, wanted.state)
    np.testing.assert_allclose(log.action, wanted.action)


@pytest.mark.parametrize(
    ("frame", "told"),
    [
        (pd.DataFrame({"time": [0.0, 0.1], "x": [0.0, 1.0], "speed": [1, np.nan]}), "row 1, column 'speed'"),
        (pd.DataFrame({"time": [0.0, 0.1], "place": [0.0, 1.0]}), "standard state columns"),
        (pd.DataFrame({"time": ["a", "b"]}), "a column of numbers"),
        (pd.DataFrame({"time": []}), "rows of numbers"),
        (pd.DataFrame([[0.0, 1.0, 2.0]], columns=["time", "x", "x"]), "column 'x': expected every column name once"),
    ],
)
def test_a_frame_that_is_no_log_is_refused(frame: pd.DataFrame, told: str) -> None:
    with pytest.raises(DataError, match=told):
        Trajectory.from_pandas(frame)


def test_arrays_need_stamps_or_a_step() -> None:
    layouts = Layouts.of(["x", "y", "vx", "vy", "steer", "speed"])
    for given in ({}, {"time": [0.0, 0.1], "dt": 0.1}):
        with pytest.raises(ShapeError, match="either time or dt"):
            Trajectory.from_arrays(np.zeros((2, 4)), np.zeros((2, 2)), layouts, **given)
    with pytest.raises(ShapeError, match="state must have shape"):
        Trajectory.from_arrays(np.zeros((2, 3)), np.zeros((2, 2)), layouts, dt=0.1)


@pytest.mark.slow
def test_a_notebook_shows_answers(flight: Trajectory, equations: Equations, tmp_path: Path) -> None:
    """One line, a table and a picture of each; nothing is a heap of arrays."""
    gap = compare(equations, flight)
    found = diagnose(equations, flight, exclude=["sensor_*", "*:*", "wind"])
    tried = try_effect(equations, "linear_drag", flight, exclude=["*"])
    for answer in (gap, found, tried):
        assert "\n" not in repr(answer)
        assert len(repr(answer)) < 1000
        assert answer.plot()._repr_png_().startswith(b"\x89PNG")
        assert answer._repr_html_().startswith("<pre")
    assert "position" in gap._repr_html_()
    page = found.report(equations, flight, tmp_path / "report.html").read_text()
    assert page.count("<section") == 5
    assert found.verdict in found._repr_html_()
    assert repr(equations).startswith("<Equations: x y z vx vy vz")
    shown = equations._repr_latex_()
    assert shown.count("&=") == len(equations.latex())
    assert shown.count("{") == shown.count("}")
    assert "linear_drag" in plan(equations, flight)._repr_html_()


def test_a_log_is_drawn_with_and_without_models(flight: Trajectory, equations: Equations) -> None:
    path, both = flight.plot(), flight.plot(before=equations, after=equations)
    assert len(path.axes) == 2
    assert [one.get_text() for one in both.legends[0].get_texts()] == ["measured", "before", "after"]
    assert len([one for one in both.axes if one.get_visible()]) == len(flight.layouts.state.columns)
    with pytest.raises(ShapeError, match="found 5"):
        flight.rows(0, 5).plot(model=equations)


def test_legends_cover_no_data(flight: Trajectory, equations: Equations) -> None:
    """Outside of every axis, once the figure is laid out."""
    for figure in (flight.plot(), flight.plot(model=equations), compare(equations, flight).plot()):
        figure.canvas.draw()
        legend = figure.legends[0].get_window_extent()
        assert not any(legend.overlaps(axis.get_window_extent()) for axis in figure.axes if axis.get_visible())


@pytest.mark.parametrize(("form", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_figures_have_the_format_that_matplotlib_is_told(
    form: str, begins: bytes, flight: Trajectory, tmp_path: Path
) -> None:
    with matplotlib.rc_context({"savefig.format": form}):
        written = save(flight.plot(), tmp_path, "flight.v2")
    assert written.name == f"flight.v2.{form}"
    assert written.read_bytes().startswith(begins)


def test_what_was_not_scored_has_no_picture() -> None:
    from sym2real.diagnosis import Diagnosis

    with pytest.raises(ModelError, match="nothing was scored"):
        Diagnosis("CANNOT_TELL", "Nothing.").plot()


def test_a_data_frame_is_read_as_its_file_is(tmp_path: Path) -> None:
    """Blanks around the names of columns are no part of them, and advice is about a frame."""
    (tmp_path / "log.csv").write_text("t, x, y\n" + "".join(f"{0.1 * row},{row},{-row}\n" for row in range(20)))
    frame = pd.read_csv(tmp_path / "log.csv")
    assert " x" in frame
    np.testing.assert_array_equal(Trajectory.from_pandas(frame).state, read_log(tmp_path / "log.csv").state)
    with pytest.raises(DataError, match="inspect_logs proposes one for the same log as a file") as refused:
        Trajectory.from_pandas(frame.rename(columns={"t": "when"}))
    assert "'data frame'" not in str(refused.value)
    with pytest.raises(DataError, match=r"expected a data frame of pandas \(read_log reads files\), found 'log.csv'"):
        Trajectory.from_pandas("log.csv")  # type: ignore[arg-type]


NO_LOGS = ["flight.csv", Path("flight.csv"), np.zeros((50, 13)), pd.DataFrame({"x": [0.0]}), ["a.csv", "b.csv"], 3]


@pytest.mark.parametrize("given", NO_LOGS, ids=lambda given: type(given).__name__)
def test_what_is_no_log_is_refused_with_what_makes_one(given: Any, equations: Equations) -> None:
    for ask in (compare, diagnose, plan, Equations.score, Equations.simulate):
        with pytest.raises(ShapeError, match=r"expected logs \(a Trajectory.*, found .*read_log.*from_pandas"):
            ask(equations, given)
    with pytest.raises(ShapeError, match="no log"):
        compare(equations, [])


@pytest.mark.slow
def test_a_log_may_have_more_columns_than_the_model_but_none_less(flight: Trajectory, equations: Equations) -> None:
    """Read without a model a flight has rates as well: equations without them take of it what they know."""
    whole = read_log(example_flight(), SPEC, dt=0.02).rows(0, 400)
    assert {*whole.layouts.state} > {*flight.layouts.state}
    assert str(compare(equations, whole)) == str(compare(equations, flight))
    assert equations.score(whole) == equations.score(flight)
    with torch_alone():  # equations go to C once they have worked enough, which rounds otherwise
        found, expected = (diagnose(equations, log, exclude=["*"]) for log in (whole, flight))
    assert replace(found, seconds=0.0).to_dict() == replace(expected, seconds=0.0).to_dict()
    with pytest.raises(ShapeError, match="found none called thrust wx_cmd wy_cmd wz_cmd among"):
        compare(quadrotor(), whole)


def test_the_path_of_a_model_is_no_model_and_of_a_log_no_state(equations: Equations, flight: Trajectory) -> None:
    for ask in (compare, diagnose, plan):
        with pytest.raises(ModelError, match=r"expected a model, found 'm_crane'; load_model\(folder\)"):
            ask("m_crane", flight)  # type: ignore[operator]
    with pytest.raises(ShapeError, match=r"expected arrays of states and actions .* found 'flight.csv'"):
        equations.predict("flight.csv", flight.action)  # type: ignore[type-var]
