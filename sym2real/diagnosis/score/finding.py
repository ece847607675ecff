"""What a diagnosis says of one effect: values with intervals, share, alternatives that the data cannot exclude."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise
from typing import Any

from sym2real.dataset import Dataset
from sym2real.diagnosis.errors.floor import Floor, floor_of_explained, no_higher_than_reached
from sym2real.diagnosis.errors.rungs import Rung
from sym2real.diagnosis.estimate.calibrate import Calibration, cleaned
from sym2real.diagnosis.estimate.preparation import Prepared
from sym2real.diagnosis.estimate.swing import Swing
from sym2real.diagnosis.faults.units import factors
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.score.held_out import Gate, LadderModels
from sym2real.diagnosis.score.importance import by_importance
from sym2real.diagnosis.search.beam import SearchResult
from sym2real.diagnosis.search.intervals import Estimate, about, attenuated, estimates, spread_over_logs
from sym2real.diagnosis.search.near import Near, groups_of
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import Effect, compose, effect
from sym2real.effects.voltage import REFERENCE, VOLTAGE, with_voltage
from sym2real.json_objects import fields_of
from sym2real.symbolic import Equations

AS_SENT = "log commands as often as they are sent: those that change between rows look the same"


@dataclass(frozen=True)
class Finding:
    """One effect that is there.

    Args:
        effect: its key.
        parameters: by name.
        share: part of the base's excess whitened loss that it removes in its order.
        group: itself and the effects that this data cannot tell from it.
        separate_by: the manoeuvre that would.
        provisional: too few independent pieces of data for a test.
        fix: what to change on the robot or in the model.
        log_spread: standard deviation of each parameter over logs that are fitted one by one.
        voltage: of the battery where the thrust map holds (V), when the effect goes by the voltage.
        probability: its weight, and that of its group, against none and any other effect in its place; None where
            no weights were computed.
        small: whether no error that is judged is larger by a tenth without it.
        doubtful: whether commands that changed between the rows of the logs look the same.
    """

    effect: str
    parameters: dict[str, Estimate]
    share: float
    group: tuple[str, ...] = ()
    separate_by: str = ""
    provisional: bool = False
    fix: str = ""
    log_spread: dict[str, float] = field(default_factory=dict)
    voltage: float | None = None
    probability: float | None = None
    small: bool = False
    doubtful: bool = False

    def to_dict(self) -> dict[str, Any]:
        """The entry of ``findings`` in docs/method.md, "Answers as files"."""
        battery = {} if self.voltage is None else {"full_battery": self.voltage}
        return {**fields_of(self, without=("log_spread", "voltage")), "spread_over_logs": self.log_spread, **battery}

    @property
    def alternatives(self) -> list[str]:
        """The others of its group."""
        return [key for key in self.group if key != self.effect]

    @property
    def values(self) -> dict[str, float]:
        """Values alone, by parameter."""
        return {name: estimate.value for name, estimate in self.parameters.items()}

    def at(self, values: Mapping[str, float]) -> Finding:
        """The finding with other values of some parameters."""
        known = {name: replace(own, value=values.get(name, own.value)) for name, own in self.parameters.items()}
        return replace(self, parameters=known)

    def bound(self, equations: Equations) -> Equations:
        """The equations with the inputs that the effect's values refer to."""
        return equations if self.voltage is None else with_voltage(equations, self.voltage)


def applied(equations: Equations, findings: Sequence[Finding]) -> Equations:
    """The equations with effects at their fitted values, and with the inputs that these refer to."""
    for finding in findings:
        equations = finding.bound(equations)
    return compose(equations, [(effect(finding.effect, equations), finding.values) for finding in findings])


def findings(
    selection: Selection, near: Near | None, groups: Mapping[str, tuple[str, ...]], own: Calibration | None
) -> list[Finding]:
    """All chosen effects, in order of importance, each with its share in that order.

    Args:
        selection: what was found.
        near: the sets around it, where they have weights.
        groups: by name of a candidate, effects that the data cannot tell from it.
        own: the base against the plain simulator, if there is one.
    """
    library, problems = selection.problems.library, selection.problems
    probabilities = {} if near is None else near.probabilities(groups)
    fit = cleaned(problems, selection.fit, own)
    ordered = by_importance(selection)
    base = float(problems.whitening.loss(problems.problem.residuals(selection.origin[None])).sum())
    shares = shares_of([base, *(stage.total for _, stage in ordered)], problems.whitening.freedom)
    findings = []
    for (candidate, _), share in zip(ordered, shares, strict=True):
        of, key = library.effects[candidate.name], candidate.name
        group, values = tuple(dict.fromkeys((key, *groups.get(key, ())))), estimates(selection, candidate, fit, near)
        doubtful = attenuated(selection, candidate, fit)
        by_voltage = VOLTAGE in of.of.reads and VOLTAGE in of.body.layouts.inputs
        finding = Finding(
            effect=key,
            parameters=values,
            share=share,
            group=group,
            separate_by=of.shown_by if len(group) > 1 else "",
            provisional=problems.block_count < SETTINGS.fewest_pieces,
            fix=AS_SENT if doubtful else _fix(of, values),
            log_spread=spread_over_logs(selection, candidate, fit),
            voltage=of.body.numbers.get(REFERENCE) if by_voltage else None,
            probability=probabilities.get(key),
            small=candidate in selection.small,
            doubtful=doubtful,
        )
        findings.append(finding)
    return findings


def _fix(of: Effect, values: Mapping[str, Estimate]) -> str:
    """What to change; of a number that it multiplies, with what was given and what the logs say in its place.

    Of a gain also the unit in which a command would be logged to look the same.
    """
    if of.scaled is None:
        unit = _other_unit(of, values)
        return f"{of.fix}; {of.column} in {unit} looks the same" if unit else of.fix
    (name, given), (factor,) = of.scaled, values.values()
    estimate, *ends = (given * part for part in (factor.value, factor.low, factor.high))
    return f"{name} = {estimate:.4g} (95 % {min(ends):.4g} … {max(ends):.4g}) in place of {given:g}; {of.fix}"


def _other_unit(of: Effect, values: Mapping[str, Estimate]) -> str:
    if of.stage != "command" or [parameter.null for parameter in of.parameters] != [1.0]:
        return ""
    ((gain, times),) = ((value, factors(of.body.unit)) for value in values.values())
    return next((unit for unit, by in times.items() if by != 1.0 and gain.low <= 1.0 / by <= gain.high), "")


def shares_of(losses: Sequence[float], freedom: float) -> list[float]:
    """Part of the excess loss that each finding removes in its order: how far it lowers the lowest so far.

    Args:
        losses: whitened squares without findings, then with one more each.
        freedom: squares that nobody can explain.
    """
    lowest = list(accumulate(losses, min))
    excess = max(losses[0] - min(freedom, lowest[-1]), 1e-9)
    return [(before - after) / excess for before, after in pairwise(lowest)]


def with_details(given: Sequence[Finding], library: Library, swing: Swing | None, logs: Dataset) -> tuple[Finding, ...]:
    """The findings under the keys that a user types, with what was settled before the search.

    That is which rotor lost thrust, and how fast a force swings; also its phase where there is one log, which at the
    start of a log of length T is known to T/√3 times the frequency's deviation (both from one line through the angle).
    """
    known: dict[str, Estimate] = {}
    if swing is not None:
        known["omega"] = about(swing.omega, swing.deviation, "rad/s")
        if len(logs) == 1:
            known["phase"] = about(swing.phases[0], swing.deviation * len(logs[0]) * logs[0].dt / 3**0.5, "rad")
    result = []
    for finding in given:
        chosen = {name: Estimate(value, value, value, "1") for name, value in library.choice(finding.effect).items()}
        of = library.effects.get(finding.effect)
        group = tuple(dict.fromkeys(library.key(name) for name in finding.group))
        parameters = chosen | (known if of is not None and of.searching.swings else {}) | finding.parameters
        result.append(replace(finding, effect=library.key(finding.effect), group=group, parameters=parameters))
    return tuple(result)


@dataclass(frozen=True, eq=False)
class Scored:
    """Findings and how they do on data that took no part in their fit.

    Args:
        result: of the search.
        steps: the models of the ladder.
        stages: the ladder.
        gate: free runs of the first and the last of them.
        findings: effects that are there, in order of importance.
        horizons: of the ladder (s).
        floor: errors of a fully explained model.
    """

    result: SearchResult
    steps: LadderModels
    stages: tuple[Rung, ...]
    gate: Gate
    findings: tuple[Finding, ...]
    horizons: tuple[float, ...]
    floor: tuple[Floor, ...]


def score(result: SearchResult) -> Scored:
    """Errors of the base and of what was found, on logs that were kept aside or that each fit left out."""
    prepared, selection = result.prepared, result.selection
    steps, horizons, stages, floor = laddered(prepared, selection)
    gate, near = steps.gate(), Near.of(selection).with_elsewhere()
    return Scored(result, steps, stages, gate, findings_of(result, near), horizons, floor)


def laddered(
    prepared: Prepared, selection: Selection
) -> tuple[LadderModels, tuple[float, ...], tuple[Rung, ...], tuple[Floor, ...]]:
    """The models of a ladder, its horizons (s), their errors on held-out data, and those of a fully explained model."""
    question = prepared.question
    steps = LadderModels.of(prepared.library, prepared.scored, selection, same=question.held_out is None)
    horizons = steps.held.horizons(question.horizon)
    stages = steps.held.ladder(steps.models, horizons)
    floor = floor_of_explained(steps.held, selection.fit.values, prepared.whitening, horizons)
    return steps, horizons, stages, no_higher_than_reached(floor, stages)


def findings_of(result: SearchResult, near: Near | None = None) -> tuple[Finding, ...]:
    """Values of what was found, with what else would do in its place where that is known."""
    prepared = result.prepared
    groups = {} if near is None else groups_of(near)
    values = findings(result.selection, near, groups, prepared.calibration) if result.selection.chosen else []
    return with_details(values, prepared.library, prepared.swing, prepared.checked.data)
