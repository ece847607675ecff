"""Every threshold that decides what the diagnosis says, and where its number comes from.

A source is *theory* (a level or a count of statistics, a convention of what is worth saying), *sensor* (what honest
sensors and loggers are) or *tuned*: set by looking at development data, which are then named. What makes a computation
exact or quick stays where it is used.
"""

from __future__ import annotations

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
    fewest_pieces: int = _of(10, "theory", "blocks of a second, or windows, without which no test is made")
    fewest_logs: int = _of(6, "theory", "logs from which whole logs are tested as well, each with a trim of its own")
    residual_chance: float = _of(0.05, "theory", "chance of calling white residuals correlated, shared among the lags")
    error_fall: float = _of(0.10, "theory", "part of an error whose coming or going matters to a user")
    floor_known: float = _of(
        4 / 3, "theory", "times the floor, an estimate that is good to a third, beyond which an error is above it"
    )
    gain: float = _of(0.005, "tuned", "part of the held-out loss that an effect must save: null sets show 0.002")
    gain_beside: float = _of(0.01, "tuned", "the same beside another effect, whose form may be wrong: simulated logs")
    gain_few: float = _of(0.03, "tuned", "the same beside another where logs are few, or of a constant: real logs")
    most_findings: int = _of(8, "theory", "effects in one set: more have no test left on the logs of a day")
    odds: float = _of(0.05, "theory", "weight beside a finding from which another may be what is there")
    worth_a_line: float = _of(0.5, "theory", "part of a hypothesis's gain from which a rival of it is listed")
    nearly_as_good: float = _of(
        0.9, "tuned", "part of the best gain that makes a simpler explanation do: simulated logs"
    )

    agreeing: float = _of(
        0.5, "sensor", "correlation of a rate with its derivative that agrees; its negative is reversed"
    )
    feedback: float = _of(0.5, "tuned", "R² of a command by the state from which a loop is closed: simulated flights")
    missed_horizon: float = _of(0.1, "sensor", "part of a horizon by which whole rows may miss it")
    time_step: float = _of(0.02, "sensor", "relative difference of a log's and the model's time step")
    jitter: float = _of(0.05, "sensor", "relative spread of the time step that is worth a remark")
    gap: float = _of(1.5, "sensor", "steps without a row that are a gap, or that a row behind repeated ones catches up")
    saturated: float = _of(0.05, "sensor", "part of the rows that a command stays at one extreme")
    still: float = _of(0.01, "sensor", "variation of a command, of its largest size, that shows little about it")
    frozen: float = _of(0.3, "sensor", "part of a segment's rows in which no bit moves: frozen measurements")
    exact: float = _of(1e-6, "sensor", "m; no sensor of position has less noise")
    of_positions: float = _of(0.02, "sensor", "part of a velocity's spread by which it may miss its position's slope")
    adequate_start: float = _of(1.3, "tuned", "times the noise that a smoothed start may leave: simulated flights")

    heavy_tails: float = _of(10.8, "theory", "χ² with one degree of freedom, 99.9 %: from here on tails are heavy")
    started: float = _of(
        0.02, "tuned", "part of the loss that starts an effect of the over-fitted model: simulated logs"
    )
    own_motion: float = _of(3.0, "tuned", "times a free body's motion near a controller's resonance: simulated flights")
    good_base: float = _of(
        0.1, "theory", "squared error of a base, in units of the noise, below which it stays as it is"
    )
    base_gain: float = _of(0.001, "tuned", "part of the loss that an effect of the base's own must save: learned bases")
    base_rows: int = _of(100, "theory", "rows of a flight that a base is calibrated by")
    interval_floor: float = _of(0.03, "tuned", "relative half-width that a wrong form leaves: real logs, simulators")
    stiffness: float = _of(0.1, "tuned", "what the loop's stiffness adds to it where torques act: simulated flights")

    inseparable: float = _of(0.96, "theory", "part of the Fisher information shared: a correlation of 0.98")
    largest: float = _of(0.9, "theory", "of a parameter's bounds: an effect that must be larger is not seen")
    clear: float = _of(0.3, "theory", "part of a finding that a rival may explain on a manoeuvre that parts them")

    sensor_deviations: float = _of(5.0, "theory", "standard deviations beyond which a sensor's value is no chance")
    sensor_stretches: int = _of(20, "theory", "stretches of 0.4 s that a sensor is judged by")
    sensor_scale: float = _of(0.05, "sensor", "logarithm of a scale that honest sensors have")
    sensor_bias: float = _of(0.02, "sensor", "rad/s or m/s of bias that honest sensors have")
    sensor_shift: float = _of(1.0, "sensor", "rows that honest sensors are late")
    unit_correlation: float = _of(0.9, "tuned", "from which a ratio of sizes is one of units: the list of mistakes")
    unit_near: float = _of(1.25, "tuned", "times that a ratio may be off the unit that is named: the list of mistakes")
    unit_large: float = _of(3.0, "tuned", "times: a smaller ratio is no other unit: the list of mistakes")
    unit_unheard_of: float = _of(30.0, "sensor", "times: a larger ratio is another unit even if it has no name")
    scalar_last: float = _of(0.8, "tuned", "correlation of attitudes whose scalar is last: the list of mistakes")
    command_unit: float = _of(10.0, "tuned", "times: a command's other unit, and what it mends: the list of mistakes")
    command_sides: float = _of(2.0, "tuned", "times more that far factors of that unit must miss: the list of mistakes")
    mistake_fewer: float = _of(3.0, "tuned", "times fewer squares without a user's mistake: the list of mistakes")
    mistake_left: float = _of(0.5, "tuned", "part of a quantity's change that may be missed then: the list of mistakes")
    others_worse: float = _of(
        0.25, "tuned", "of what a mistake mends, what another quantity may lose: the list of mistakes"
    )
    frame_turn: float = _of(float(np.deg2rad(25.0)), "sensor", "a smaller turn is a sensor that is mounted askew")
    repeated_rows: float = _of(0.01, "sensor", "part of the rows that repeat the one before")
    jump_deviations: float = _of(30.0, "sensor", "standard deviations of usual changes by which a value jumps")
    jump_beyond: float = _of(4.0, "sensor", "times the 95th percentile of changes by which a value jumps")
    jump_metres: float = _of(0.1, "sensor", "m; estimators of position correct themselves by centimetres")
    jump_back: float = _of(0.5, "tuned", "part of a jump that may be left by the one back: the list of mistakes")
    jump_rows: int = _of(15, "sensor", "rows after which a position that jumped is back")
    spike_rows: int = _of(2, "sensor", "rows after which any other value that jumped is back")
    bridged_rows: int = _of(3, "sensor", "bad rows that are bridged, as the reader of logs does; more part a log")

    misfit: float = _of(
        1.2, "tuned", "whitened squares per degree of freedom that leave something out: null sets, 1.06"
    )
    depends: float = _of(0.10, "tuned", "R² on unseen pieces of a disturbance that depends on something: null sets")
    suspect: float = _of(0.03, "tuned", "R² on unseen pieces from which a disturbance is looked at: null sets")
    disturbance_pieces: int = _of(60, "theory", "pieces that a dependence is looked for in")
    negligible: float = _of(0.01, "tuned", "part of a disturbance's size that noise of its feature makes: null sets")
    of_the_base: float = _of(0.5, "tuned", "part of a dependence that the base itself may have: learned bases")
    answered: float = _of(
        0.5, "tuned", "of the R² of what follows a disturbance, that of what it depends on before: simulated flights"
    )
    term_gain: float = _of(
        0.015, "tuned", "fall of the loss by a term of whole logs: null sets 0.008, grip leaves 0.012"
    )
    term_by_logs: float = _of(0.05, "theory", "chance of a false alarm of a term by whole logs: few degrees of freedom")
    motion: float = _of(0.01, "theory", "part of the motion that what is left must make to matter: a fit of 99 %")
    statement_r2: float = _of(0.15, "tuned", "R² on unseen logs of a statement where errors are large: simulated logs")
    statement_alike: float = _of(0.05, "tuned", "R² by which a plainer feature may be worse: simulated logs")
    statement_ratio: float = _of(1.5, "theory", "times that an error must be larger to be worth a statement")

    def gain_of(self, effects: int) -> float:
        """Part of the held-out loss that an effect must save in a set of so many."""
        return self.gain_beside if effects > 1 else self.gain


SETTINGS = Settings()
