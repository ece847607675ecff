"""Every threshold that decides what the diagnosis says, and where its number comes from.

A source is *theory* (a level or a count of statistics, a convention of what is worth saying), *sensor* (what honest
sensors and loggers are) or *tuned*: set by looking at development data, which are then named. What makes a computation
exact or quick (lengths of segments and windows, how many sets are looked at) stays where it is used.
"""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

Source = Literal["theory", "sensor", "tuned"]


def _of(value: float, source: Source, why: str) -> Any:
    return field(default=value, metadata={"source": source, "why": why})


@dataclass(frozen=True)
class Settings:
    """Thresholds of the diagnosis; lengths in rows or pieces, times in s, angles in rad, others as they say."""

    false_alarms: float = _of(0.002, "theory", "chance of a false alarm per data set, shared among all that compete")
    false_alarms_by_logs: float = _of(0.01, "theory", "chance of a false alarm of an effect by whole logs")
    level: float = _of(0.05, "theory", "chance or weight from which a thing may be so, shared among all asked")
    fewest_pieces: int = _of(10, "theory", "blocks of 1.5 s, or windows, without which no test is made")
    fewest_logs: int = _of(6, "theory", "logs from which whole logs are tested as well, each with a trim of its own")
    most_findings: int = _of(8, "theory", "effects in one set: more have no test left on the logs of a day")
    worth_saying: float = _of(0.1, "theory", "part of an error, a variance or a noise that matters to a user")
    negligible: float = _of(0.01, "theory", "part of a size, of the rows or of the motion that does not matter")
    mostly: float = _of(0.5, "theory", "part, R² or correlation: from here on it is more so than not")
    nearly: float = _of(0.9, "theory", "part, or correlation, from which one thing does as well as another")
    far: float = _of(3.0, "theory", "times: what is so much larger is something else")

    gain: float = _of(0.005, "tuned", "part of the held-out loss that an effect must save: null sets show 0.002")
    gain_beside: float = _of(0.01, "tuned", "the same beside another effect, whose form may be wrong: simulated logs")
    gain_few: float = _of(0.03, "tuned", "the same beside another where logs are few: real logs")
    heavy_tails: float = _of(10.8, "theory", "χ² with one degree of freedom, 99.9 %: from here on tails are heavy")
    another_effect: float = _of(0.02, "tuned", "loss that one effect more must take: simulated")
    base_gain: float = _of(0.001, "tuned", "part of the loss that an effect of the base's own must save: learned bases")
    base_rows: int = _of(100, "theory", "rows of a flight that a base is calibrated by")
    interval_floor: float = _of(0.03, "tuned", "relative half-width that a wrong form leaves: real logs, simulators")
    stiffness: float = _of(0.1, "tuned", "what the loop's stiffness adds to it where torques act: simulated flights")
    inseparable: float = _of(0.96, "theory", "part of the Fisher information shared: a correlation of 0.98")
    clear: float = _of(0.3, "theory", "part of a finding that an alternative explains on a manoeuvre that parts them")

    same: float = _of(0.02, "sensor", "relative difference of two numbers that a log or a model has for one thing")
    gap: float = _of(1.5, "sensor", "times: a step so long is two, an error so much larger worth a statement")
    uneven: float = _of(0.05, "sensor", "scale off 1, spread of the time step, rows at one extreme: more is not usual")
    frozen: float = _of(0.3, "sensor", "part of a segment's rows in which no bit moves: frozen measurements")
    exact: float = _of(1e-6, "sensor", "m; no sensor of position has less noise")
    above_noise: float = _of(1.3, "tuned", "times a noise, known to a third, that may still be it: simulated flights")

    sensor_deviations: float = _of(5.0, "theory", "standard deviations beyond which a sensor's value is no chance")
    sensor_stretches: int = _of(20, "theory", "stretches of 0.4 s that a sensor is judged by")
    sensor_bias: float = _of(0.02, "sensor", "rad/s or m/s of bias that honest sensors have")
    unit_near: float = _of(1.25, "tuned", "times that a ratio may be off the unit that is named: the list of mistakes")
    unheard_of: float = _of(30.0, "sensor", "times what is meant, or the usual scatter, that no robot does")
    scalar_last: float = _of(0.8, "tuned", "correlation of attitudes whose scalar is last: the list of mistakes")
    command_unit: float = _of(9.5, "tuned", "times: a command's other unit, and what it mends: the list of mistakes")
    command_sides: float = _of(2.0, "tuned", "times more that far factors of that unit must miss: the list of mistakes")
    others_worse: float = _of(0.25, "tuned", "part of what is mended that another may lose: the list of mistakes")
    frame_turn: float = _of(float(np.deg2rad(25.0)), "sensor", "a smaller turn is a sensor that is mounted askew")
    part_of_a_row: float = _of(0.5, "sensor", "resolution of a sensor's delay")
    jump_beyond: float = _of(4.0, "sensor", "times the 95th percentile of changes by which a value jumps")
    jump_metres: float = _of(0.1, "sensor", "m; estimators of position correct themselves by centimetres")
    jump_rows: int = _of(15, "sensor", "rows after which a position that jumped is back")
    spike_rows: int = _of(2, "sensor", "rows after which any other value that jumped is back")
    bridged_rows: int = _of(3, "sensor", "bad rows that are bridged, as the reader of logs does; more part a log")

    misfit: float = _of(1.2, "tuned", "reduced χ² that leaves something out: null sets, 1.07")
    term_gain: float = _of(0.015, "tuned", "fall of the loss by a term of whole logs: null sets 0.008, grip 0.012")
    statement_r2: float = _of(0.15, "tuned", "R² on unseen logs of a statement where errors are large: simulated logs")
    statement_alike: float = _of(0.05, "tuned", "R² by which a plainer feature may be worse: simulated logs")

    def false_alarms_of_each(self, tested: int) -> float:
        """Chance of a false alarm of each of so many that compete in a data set (Bonferroni)."""
        return self.false_alarms / max(1, tested)

    def gain_of(self, effects: int) -> float:
        """Part of the held-out loss that an effect must save in a set of so many."""
        return self.gain_beside if effects > 1 else self.gain


SETTINGS = Settings()
