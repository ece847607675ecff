"""What the findings do not explain: disturbances, constants, dependences, a misfit; and a term for the strongest."""

from collections.abc import Sequence
from dataclasses import replace

from sym2real.diagnosis.data.windows import JUDGED_AT, judged
from sym2real.diagnosis.errors.floor import Floor, SensorNoise, floor_of_explained
from sym2real.diagnosis.errors.rungs import Rung
from sym2real.diagnosis.score.finding import Scored, applied
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.constant import find_differing
from sym2real.diagnosis.unexplained.dependence import Terms, find_dependences
from sym2real.diagnosis.unexplained.features import part_of_changes
from sym2real.diagnosis.unexplained.leftover import MISFIT, Leftover, find_misfit
from sym2real.diagnosis.unexplained.odd_pieces import find_where_odd, odd_pieces
from sym2real.diagnosis.unexplained.part_of_logs import find_part
from sym2real.diagnosis.unexplained.term import Term, propose


def explain_rest(scored: Scored) -> tuple[tuple[Leftover, ...], Term | None]:
    """What no effect explains, the strongest of what matters first, and an unverified term that would some of that."""
    prepared = scored.result.prepared
    # Commands that no row holds move the robot, and what they did goes with what it then did.
    commands_lost = prepared.checked.commands_lost or any(finding.doubtful for finding in scored.findings)
    leftovers = () if commands_lost else _leftovers(scored)
    if not (commands_lost or (scored.findings and scored.gate.beats_hold) or any(left.matters for left in leftovers)):
        leftovers = (*worse_than_nothing(scored), *leftovers)
    if not any(leftover.matters for leftover in leftovers):
        return leftovers, None
    informed = applied(prepared.model, scored.findings)
    return leftovers, propose(informed, prepared.checked.data, leftovers[0], prepared.whitening)


def _leftovers(scored: Scored) -> tuple[Leftover, ...]:
    """What no effect explains, the strongest of what matters first."""
    selection, prepared = scored.result.selection, scored.result.prepared
    own, problems = prepared.calibration, selection.problems
    astray = beyond_floor(scored.stages, scored.floor)
    leftovers = tuple[Leftover, ...]()
    if problems.block_count >= SETTINGS.fewest_pieces and problems.spread is not None:
        terms = Terms.of(selection, problems.spread, own)
        leftovers = find_dependences(terms)
        if astray and scored.stages and scored.floor:
            leftovers += find_differing(terms)
        leftovers += find_part(selection)
    left = problems.problem.residuals(selection.fit.values[None])[0]
    leftovers += find_where_odd(problems, left)
    misfit = problems.whitening.misfit(left)
    many_odd = misfit > SETTINGS.far and len(odd_pieces(problems)) > SETTINGS.worth_saying * len(left)
    if not any(leftover.matters for leftover in leftovers) and (astray or many_odd):
        motion = part_of_changes(problems.problem.segments, left)
        leftovers += find_misfit(misfit, motion)
        # Where a simulator has shown the base's own errors, these may be as large.
        if own is None and not any(leftover.matters for leftover in leftovers):
            leftovers += find_far(scored.stages, scored.floor, motion)
    return tuple(sorted(leftovers, key=lambda leftover: (not leftover.matters, -(leftover.motion or 0.0))))


def beyond_floor(stages: Sequence[Rung], floor: Sequence[Floor]) -> bool:
    """Whether predictions over a controller's horizon are surely worse than noise and disturbances make them.

    Rows that were lost or repeated make errors that no prediction shows. What is not predicted is not asked.

    Args:
        stages: errors on held-out logs.
        floor: of a model that misses nothing.
    """
    return not (stages and floor) or bool(beyond_times(stages, floor, SETTINGS.above_noise))


def find_far(
    stages: Sequence[Rung], floor: Sequence[Floor], motion: float | None = None, beyond: float = SETTINGS.gap
) -> tuple[Leftover, ...]:
    """Predictions beyond the floor that are far from what noise alone makes: disturbances may explain every residual.

    Args:
        stages: errors on held-out logs.
        floor: of a model that misses nothing.
        motion: part of the robot's motion that all errors make.
        beyond: times the floor that they must surely be.
    """
    far = [error for error in beyond_times(stages, floor, beyond) if error[0] > SETTINGS.far]
    return _worst(far, f"{judged_at(floor).horizon:.3g} s ahead" if far else "", motion)


def beyond_times(stages: Sequence[Rung], floor: Sequence[Floor], beyond: float) -> list[tuple[float, str]]:
    """Of errors over a controller's horizon, surely so many times the floor: how many times noise alone, and name."""
    if not (stages and floor):
        return []
    errors, level = stages[-1].horizons[stages[-1].nearest(JUDGED_AT)], judged_at(floor)
    lowest = [(errors[name].low, level.errors[name][0], name) for name in judged(errors)]
    far = ((error, level.noise.get(name, least), name) for error, least, name in lowest if error > beyond * least)
    return [(error / max(noise, 1e-12), name) for error, noise, name in far]


def _worst(times_noise: Sequence[tuple[float, str]], words: str, motion: float | None = None) -> tuple[Leftover, ...]:
    worst = sorted(times_noise)[-1:]
    return tuple(Leftover(MISFIT, channel, 1.0 - times**-2, words, motion=motion) for times, channel in worst)


def judged_at(floor: Sequence[Floor]) -> Floor:
    """The level of a controller's horizon."""
    return min(floor, key=lambda level: abs(level.horizon - JUDGED_AT))


def disturbed_most(floor: Sequence[Floor]) -> tuple[str, float] | None:
    """The judged error that disturbances which follow nothing measured raise most, and how often it is that of noise
    alone; None where they do not make most of the floor's squares.
    """
    times = judged_at(floor).disturbed if floor else {}
    worst = max(judged(times), key=times.__getitem__, default="")
    return (worst, times[worst]) if worst and 1.0 - times[worst] ** -2 >= SETTINGS.mostly else None


def disturbance_notes(floor: Sequence[Floor]) -> tuple[str, ...]:
    """What disturbances that follow nothing measured do to predictions, where that is most of the floor's squares."""
    if (most := disturbed_most(floor)) is None:
        return ()
    words = "make the {} error {:.1f} times that of noise alone".format(*most)
    instance = "gusts, an estimator's errors, which go on from row to row, or what moves by itself, as a hanging load"
    return (f"disturbances that follow nothing measured {words}: {instance}",)


def worse_than_nothing(scored: Scored) -> tuple[Leftover, ...]:
    """Predictions that are worse than none, held against the noise that the logs themselves show.

    Where something was found all the same, noise alone must make them so: a pole that falls, not a rotor that sticks.
    """
    if scored.findings:
        return find_far(scored.stages, scored.floor, beyond=0.0)
    nearest = min(scored.horizons, default=0.0)
    if not scored.stages or not scored.stages[-1].worse.get(nearest):
        return ()
    prepared, values = scored.result.prepared, scored.result.selection.fit.values
    still = replace(prepared.whitening, disturbances=dict.fromkeys(prepared.whitening.disturbances, 0.0))
    noise = floor_of_explained(scored.steps.held, values, still, (nearest,), noise=SensorNoise.of(prepared.scored))
    return find_astray(scored.stages[-1], noise[0]) if noise else ()


def find_astray(stage: Rung, noise: Floor) -> tuple[Leftover, ...]:
    """What is left of a model that is surely worse than that nothing changes, and not by the sensors' noise.

    Disturbances that are as large as all that a model gets wrong explain every residual, and hide what is wrong.

    Args:
        stage: errors on held-out logs.
        noise: the floor that the sensors' noise alone makes, at the shortest horizon: there disturbances did least.
    """
    nearest = stage.nearest(noise.horizon)
    errors = ((stage.horizons[nearest][name], noise.errors[name][0], name) for name in stage.worse.get(nearest, ()))
    far = ((error, lowest, name) for error, lowest, name in errors if error.low > SETTINGS.above_noise * lowest)
    ratios = [(error.value / max(lowest, 1e-12), name) for error, lowest, name in far]
    return _worst(ratios, f"{noise.horizon:.3g} s ahead, which is worse than if nothing changed")
