"""Beside ``mujoco.sysid``: the same logs, the same plain plant, and all of its parameters free (sysid_parameters.py).

It fits masses, inertias, the centre of mass, gains, offset and friction to stretches of half a second from measured
starts; what it names is the parameter of the largest relative change. Cases are effects that one of these parameters
is. The last two logs take no part in its fit; ours is scored there too. Needs the extra ``bench``.

    pip install ".[bench]"
    python tools/bench/beside_sysid.py --cases 1
    python tools/bench/beside_sysid.py --cases 10 --sealed --json build/beside_sysid.json
"""

import time
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from functools import partial
from io import StringIO
from typing import Any

import mujoco
import numpy as np
import tyro
from answers import Record, answer_of, error_ahead, first, parameter_error, same_group
from bases import Base, as_read, base_of
from figures import Figure, report
from repeated import Asked, Settings, print_table, share
from standard_cases import standard_cases
from standard_set import Case, simulate_case
from sysid_parameters import FREE

from sym2real.cli.results import plain_simulator
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, diagnose
from sym2real.effects import effect
from sym2real.errors import MissingDependencyError, ModelError
from sym2real.experiments.study.sweep import Tell
from sym2real.plants.mujoco_plant import edited
from sym2real.robots import ROBOTS, Robot
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Trajectory

BENCH, SECONDS, ITERATIONS = "mujoco.sysid", 0.5, 30
SKIPPED, HELD_OUT = 10, 2  # rows at the start of a log; logs at the end
SENSORS = {"position": "FRAMEPOS", "attitude": "FRAMEQUAT", "velocity": "FRAMELINVEL", "rate": "GYRO"}
STILL = 1e-9  # of a column that nothing moves, or that no log holds


def chosen(robot: str, seeds: Sequence[int]) -> list[Case]:
    """Single effects that one of its parameters is, in turn, with these seeds."""
    keys = {free.key for free in FREE[robot].values() if free.key}
    known = [one for one in standard_cases(robot, quick=True) if len(one.keys) == 1 and one.keys[0] in keys]
    different = list({case.keys: case for case in known}.values())
    return [replace(different[number % len(different)], seed=seed) for number, seed in enumerate(seeds)]


def spec_of(robot: Robot) -> Any:
    """The plain robot with sensors of what its logs hold."""
    spec = edited(robot)
    for name, kind in SENSORS.items():
        sensor = spec.add_sensor(name=name, type=getattr(mujoco.mjtSensor, f"mjSENS_{kind}"))
        sensor.objtype, sensor.objname = mujoco.mjtObj.mjOBJ_SITE, "origin"
    return spec


def measured(log: Trajectory, rows: slice) -> Array:
    """What these sensors would have reported ``# (rows, 13)``: m, quaternion, m/s, rad/s; zero where no log tells."""
    layout, part = log.layouts.state, log.rows(rows.start, rows.stop)
    known = {name: part.column(name) for name in layout}
    if "qw" not in known:
        half = 0.5 * np.unwrap(np.arctan2(known["sin_yaw"], known["cos_yaw"]))
        known |= {"qw": np.cos(half), "qz": np.sin(half)}
    columns = ("x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz")
    return np.stack([known.get(name, np.zeros(len(part))) for name in columns], axis=1)


def moving_residual(_: Any, predicted: Any, told: Any, model: Any, *__: Any, **___: Any) -> tuple[Array, Any, Any]:
    """Its own residual, normalised as it does it, of the columns that logs hold: it divides by what others measure."""
    from mujoco import sysid

    at_rows = predicted.resample(told.times)
    seen = np.linalg.norm(told.data, axis=0) > STILL
    missed = sysid.weighted_diff(predicted_data=at_rows.data, measured_data=told.data, model=model)
    missed = np.where(seen, missed, 0.0)
    missed[:, seen] = sysid.normalize_residual(missed[:, seen], told.data[:, seen])
    return missed, at_rows, sysid.TimeSeries(told.times, told.data, at_rows.signal_mapping)


def stretches(robot: Robot, logs: Sequence[Trajectory]) -> list[tuple[Trajectory, slice]]:
    """Half seconds of logs, one after the other."""
    rows = round(SECONDS / robot.dt)
    return [(log, slice(row, row + rows + 1)) for log in logs for row in range(SKIPPED, len(log) - rows, rows)]


def identified(robot: Robot, logs: Sequence[Trajectory]) -> dict[str, float]:
    """Every free parameter's value.

    Raises:
        MissingDependencyError: without the extra.
        ModelError: when a parameter has not moved: what it was given is wrong then, and it is not to be scored by that.
    """
    try:
        from mujoco import sysid

        optimise = sysid.optimize
    except (ImportError, AttributeError) as error:
        raise MissingDependencyError("mujoco.sysid needs its extra: pip install '.[bench]'") from error
    spec, parts = spec_of(robot), list[tuple[Any, Any, Any]]()
    model = spec.compile()
    for log, rows in stretches(robot, logs):
        sensors, controls = measured(log, rows), robot.description.to_control(log.action[rows])
        times = robot.dt * np.arange(len(sensors))
        start = sysid.create_initial_state(
            model, *robot.description.to_coordinates(log.state[rows][0]), np.zeros(model.na)
        )
        control = sysid.TimeSeries.from_control_names(times, controls, model)
        parts.append((start, control, sysid.TimeSeries.from_names(times, sensors, model, list(SENSORS))))
    starts, controls, sensors = (list(part) for part in zip(*parts, strict=True))
    titles = [f"part_{number}" for number in range(len(parts))]
    sequences = sysid.ModelSequences(robot.name, spec, titles, starts, controls, sensors)
    parameters = sysid.ParameterDict()
    for name, free in FREE[robot.name].items():

        def write(changed: Any, own: Any, free: Any = free) -> None:
            free.write(changed, float(own.value[0]))

        parameters.add(sysid.Parameter(name, free.nominal + free.off, free.low, free.high, modifier=write))
    residual = sysid.build_residual_fn(models_sequences=[sequences], modify_residual=moving_residual, n_threads=1)
    with redirect_stdout(StringIO()):  # of its own solver, which prints every step
        found, _ = optimise(parameters, residual, verbose=False, max_iters=ITERATIONS)
    values = {name: float(found[name].value[0]) for name in FREE[robot.name]}
    still = [name for name, free in FREE[robot.name].items() if values[name] == free.nominal + free.off]
    if still:
        raise ModelError(f"mujoco.sysid: expected a fit that moves every parameter, found {', '.join(still)} unmoved")
    return values


def error_of(robot: Robot, values: dict[str, float], logs: Sequence[Trajectory]) -> float:
    """Root mean square position error in m after half a second from measured starts."""
    spec = spec_of(robot)
    for name, value in values.items():
        FREE[robot.name][name].write(spec, value)
    model, errors, axes = spec.compile(), list[Array](), robot.layouts.state.slice("position")
    for log, rows in stretches(robot, logs):
        states, data = log.state[rows], mujoco.MjData(model)
        robot.write_state(data, states[0])
        for control in robot.description.to_control(log.action[rows])[:-1]:
            data.ctrl[:] = control
            mujoco.mj_step(model, data, robot.substeps)
        errors.append((robot.read_state(data) - states[-1])[axes])
    return float(np.sqrt(np.mean(np.sum(np.square(errors), axis=1))))


def named(robot: str, values: dict[str, float]) -> str:
    """The parameter of the largest relative change."""
    return max(values, key=lambda name: FREE[robot][name].change(values[name]))


def beside(case: Case, base: Base) -> Asked:
    """One case, by both."""
    return Asked(f"{case.robot} {case.keys[0]} {case.seed}", {"case": case.name}, partial(answer, case, base))


def answer(case: Case, base: Base, tell: Tell) -> Record:
    """Name, error of the parameter, held-out error and time of both."""
    robot, ((key, truth),) = ROBOTS[case.robot], case.effects
    data, null = simulate_case(case), effect(key, robot).null
    fit, rest = list(data)[:-HELD_OUT], list(data)[-HELD_OUT:]
    tell("mujoco.sysid")
    began = time.perf_counter()
    values = identified(robot, fit)
    seconds, free = time.perf_counter() - began, FREE[robot.name]
    own = {one.parameter: one.of_effect(values[name]) for name, one in free.items() if one.key == key}
    theirs = {"name": named(robot.name, values), "values": values, "seconds": seconds}
    theirs |= {"error": error_of(robot, values, rest), "parameter": parameter_error(dict(truth), null, own)}
    tell("diagnosing")
    found, error = ours(base.equations, fit, rest)
    values = next((one.values for one in found.findings if one.effect == key), {})
    own = {"name": first(answer_of(found)), "seconds": found.seconds, "error": error}
    own |= {"parameter": parameter_error(dict(truth), null, values)}
    return {"robot": robot.name, "truth": key, "theirs": theirs, "ours": own}


def ours(equations: Equations, fit: Sequence[Trajectory], rest: Sequence[Trajectory]) -> tuple[Diagnosis, float]:
    """A diagnosis, and the position error in m after half a second on other logs of what it leaves."""
    logs, held_out = as_read(equations, Dataset(fit)), as_read(equations, Dataset(rest))
    found = diagnose(equations, logs, plain_simulator(equations))
    return found, error_ahead(found.apply(equations), held_out, SECONDS)


def right(record: Record, whose: str) -> bool:
    """Whether the name is the true effect's, or of its group."""
    name = record[whose]["name"]
    key = FREE[record["robot"]][name].key if whose == "theirs" else name
    return bool(key) and same_group(key, record["truth"])


def figures(records: Sequence[Record]) -> list[Figure]:
    """Both, beside each other."""
    found: list[Figure] = []
    rows = {"parameter error": ("parameter", ""), "held-out position error 0.5 s ahead": ("error", "m")}
    rows["time"] = ("seconds", "s")
    for whose, title in (("theirs", "mujoco.sysid"), ("ours", "diagnose")):
        found += share(f"{title}: right name", (right(one, whose) for one in records))
        for said, (key, unit) in rows.items():
            value = float(np.median([one[whose][key] for one in records]))
            found.append(Figure(f"{title}: {said}, median", value, unit))
    return found


def main(settings: Settings) -> None:
    """Simulate, fit, diagnose, print, write."""
    seeds, jobs = settings.seeds_of(BENCH), list[Asked]()
    for robot in FREE:
        base = base_of(robot, "simulator", settings.place(BENCH))
        jobs += [beside(case, base) for case in chosen(robot, seeds)]
    records = settings.answers(BENCH, jobs)
    said = ((one["asked"]["case"], one["theirs"]["name"], one["ours"]["name"]) for one in records)
    print_table("what was named", ("case", "mujoco.sysid", "diagnose"), said)
    report(BENCH, figures(records), seeds, settings.json)


if __name__ == "__main__":
    main(tyro.cli(Settings, description=__doc__))
