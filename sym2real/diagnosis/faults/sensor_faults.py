"""What is wrong with clocks and sensors of rates and velocities, in words, and undone."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.windows import simulate
from sym2real.diagnosis.faults.fault import Fault, Settled
from sym2real.diagnosis.faults.sensor_readings import OfWheel, Reading, readings
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import EFFECTS
from sym2real.effects.readings import SENSOR_BIAS, SENSOR_SCALE, TIME_SHIFT
from sym2real.errors import Sym2RealError
from sym2real.logs.agreement import RATES
from sym2real.logs.equal_steps import resampled
from sym2real.logs.sources import AsRead
from sym2real.symbolic import Equations
from sym2real.vocabulary import ATTITUDE, POSITION

PREDICTED, TWO_SIDED = 2.0, 1.96  # s; standard deviations of a 95 % interval
EVIDENCE = {
    SENSOR_SCALE.name: "the logged {column} is {0:.3g} times what the {other} changes by",
    SENSOR_BIAS.name: "the logged {column} is off by {0:.3g} ± {2:.1g} from what the {other} changes by",
    TIME_SHIFT.name: "the logged {column} is {1:.0f} ms behind the {other}",
}
# What a specification says, or what is done before a log is read, behind what a kind's own fix says.
MENDED = {
    SENSOR_SCALE.name: ", or give {0} {number} in a specification of the log",
    SENSOR_BIAS.name: "{loop}",
    TIME_SHIFT.name: ": {0} by {ms:.0f} ms earlier",
}
IN_A_LOOP = "; a rate loop on board that sees it turns the robot, as a torque about that axis does"


def clock_of(step: float, data: Dataset) -> Settled:
    """Stamps of a clock that is too fast or too slow: velocities and rates are one multiple of what they are of.

    Rows that are then nearer than a step, in s, are resampled to it.
    """
    scaled = [reading for reading in readings(data) if reading.scale != 1.0]
    if not {reading.of for reading in scaled} >= {POSITION.name, ATTITUDE.name}:
        return (), data
    by, names = float(np.median([reading.scale for reading in scaled])), ", ".join(reading.column for reading in scaled)
    mended = Dataset(replace(log, time=log.time[0] + (log.time - log.time[0]) / by) for log in data)
    if any(reading.scale != 1.0 for reading in readings(mended)):
        return (), data
    text = f"the clock: {names} are all {by:.3g} times what the logs change by in the time of their stamps"
    fix = f"multiply the stamps by {1 / by:.4g}, or give the rows a second as `rate` under [time] of a specification"
    return [Fault("", text, fix)], Dataset(resampled(log, max(step, mended.dt)) for log in mended)


def sensors_of(model: Equations | None, data: Dataset) -> Settled:
    """Scales, biases and time shifts of rates and velocities, but for scales that a model has without any fault."""
    faults, read, sensors = [], AsRead(data[0].sources), readings(data)
    scaled = any(reading.scale != 1.0 for reading in sensors)
    predicted = predictions(model, data, PREDICTED) if model and scaled else None
    # Of a servo that answers a command within a row the rates at rows are not those in between.
    own = {reading.column: reading.scale for reading in readings(predicted, noisy=False)} if predicted else {}
    for reading in (_beside(own, reading) for reading in sensors):
        data = Dataset(reading.undone(log) for log in data)
        for kind, value in reading.faulty.items():
            half = TWO_SIDED * reading.unsure
            evidence = EVIDENCE[kind].format(value, 1e3 * value, half, column=reading.column, other=reading.of)
            known = {"number": read.scale(1.0 / value), "ms": 1e3 * value}
            loop = IN_A_LOOP if reading.column in RATES and data.layouts.state.has_field(ATTITUDE.name) else ""
            fix = EFFECTS[kind].fix + MENDED[kind].format(read.column(reading.column), **known, loop=loop)
            effect = "" if isinstance(reading, OfWheel) else f"{kind}:{reading.column}"
            # A model can have a scale or a bias, and a controller undo it; a time shift is neither.
            faults.append(Fault(effect, evidence, fix, value, bool(effect) and kind != TIME_SHIFT.name))
    return faults, data


def predictions(model: Equations, data: Dataset, horizon: float | None = None) -> Dataset | None:
    """A model's own predictions of what its sensors measure, along logs; None without a number."""
    try:
        predicted = Dataset(simulate(replace(model, output={}), log, horizon) for log in data)
    except Sym2RealError:  # of other columns, or of rows nearer than the model's steps
        return None
    return predicted if all(np.isfinite(log.state).all() for log in predicted) else None


def _beside(own: Mapping[str, float], reading: Reading) -> Reading:
    """A reading whose scale is one beside that of the model's predictions; none is left where they say the same."""
    scale = 1.0 if reading.scale == 1.0 else reading.scale / own.get(reading.column, 1.0)
    return replace(reading, scale=scale if abs(np.log(scale)) > SETTINGS.uneven else 1.0)
