"""The answer of a diagnosis in one sentence."""

from collections.abc import Mapping, Sequence

from sym2real.diagnosis.conclusion import Parts, Verdict, of_another_form
from sym2real.diagnosis.data.segments import BLOCK_SECONDS
from sym2real.diagnosis.data.windows import JUDGED_AT, judged
from sym2real.diagnosis.errors.rungs import Rung
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.score.held_out import Gate
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.explaining import beyond_times, disturbed_most, judged_at
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.effects.few_words import in_few_words
from sym2real.effects.steering import SHARE
from sym2real.report.leftover import measure, statement


def summary(answer: Verdict, parts: Parts, interrupted: str = "") -> str:
    """One sentence a person reads, the verdict first.

    Args:
        answer: of :func:`verdict`.
        parts: what it is made of.
        interrupted: what was, search or scoring, if anything.
    """
    findings, leftovers, gate = parts.findings, parts.leftovers, parts.gate
    # What is too small to matter stands below the answer alone.
    mattering = [(statement(leftover), measure(leftover)) for leftover in leftovers if leftover.matters]
    left = [f"{what} ({much})" for what, much in mattering]
    rest = [f"{what} is left ({much})" for what, much in mattering]
    doubt = [_doubt(parts)] if left and findings else []
    clauses = ["the data show " + ", ".join(fault.name for fault in parts.faults)] if parts.faults else []
    if answer == "EFFECT":
        # Where predictions do not bear out what was found, the faults are the answer.
        # Announced are those without which an error is larger by a tenth, or all, where they are needed together alone.
        clear = [finding for finding in findings if not finding.doubtful]
        needed = [finding for finding in clear if not finding.small] or clear
        small = [finding for finding in clear if finding not in needed]
        announced = [finding for finding in needed if _likely(finding)] or needed
        unlikely = [finding for finding in needed if finding not in announced]
        unclear = _beside([finding for finding in findings if finding.doubtful], gate)
        stays = doubt or _nameless(parts)
        missing = [*_missing(announced, parts.ladder), *_unlikely(unlikely)]
        established = [*missing, *rest, *stays, *_disturbed(parts), *_small(small), *unclear]
        clauses += established if gate.passed else [*_beside(findings, gate), *rest]
        clauses += [] if findings or left else [f"beside that {_nothing(parts)}"]
    elif answer == "UNEXPLAINED":
        alike = " in all of the logs alike" if any(leftover.instead for leftover in leftovers) else ""
        clauses.append(f"something is missing that none of the tested effects explains{alike}: {' and '.join(left)}")
        clauses += _beside(findings, gate, leftovers)
    elif answer == "NOTHING_MISSING":
        clauses += [_nothing(parts), *rest, *_small(findings)]
    elif parts.suspects:
        clauses += [_suspected(parts.suspects), *rest]
    else:
        clauses += [*_no_answer(findings, gate, interrupted), *rest]
    if interrupted and answer != "CANNOT_TELL":
        clauses.append(f"{interrupted} was interrupted before it ended")
    sentence = "; ".join(clauses)
    return sentence[:1].upper() + sentence[1:] + "."


def _doubt(parts: Parts) -> str:
    """That an effect outside the catalogue pulls at those inside, and how far from noise it leaves the errors."""
    doubt, (times, name) = "what was found may stand for a part of that", _above_floor(parts)
    stays = f"the {name} error stays {times:.1f} times what noise and disturbances make"
    if times <= SETTINGS.gap:
        return doubt
    return f"{stays}, and {doubt}" if name in parts.gate.falling else stays


def _nameless(parts: Parts) -> list[str]:
    """That errors surely stay above what noise and disturbances make, though nothing says by what."""
    (times, name), sure = _above_floor(parts), beyond_times(parts.ladder, parts.floor, SETTINGS.above_noise)
    if times <= SETTINGS.gap or not any(name == other for _, other in sure):
        return []
    return [f"the {name} error stays {times:.1f} times what noise and disturbances make, and no test says by what"]


def _above_floor(parts: Parts) -> tuple[float, str]:
    """The judged error that is furthest above noise and disturbances: how many times, and its name."""
    if not (parts.ladder and parts.ladder[-1].horizons and parts.floor):
        return 0.0, ""
    errors, level = parts.ladder[-1].horizons[parts.ladder[-1].nearest(JUDGED_AT)], judged_at(parts.floor)
    return max((errors[name].value / max(level.errors[name][0], 1e-12), name) for name in judged(errors))


def _disturbed(parts: Parts) -> list[str]:
    """That disturbances which follow nothing measured are large: what has no name may be among them."""
    words = "disturbances that nothing explains make the {} error {:.1f} times that of noise alone"
    return [words.format(*most)] if (most := _tripled(parts)) else []


def _tripled(parts: Parts) -> tuple[str, float] | None:
    """The error that disturbances raise most, and how many times, where they triple it."""
    most = disturbed_most(parts.floor)
    return most if most is not None and most[1] >= SETTINGS.far else None


def _nothing(parts: Parts) -> str:
    """That nothing is missing, beside disturbances that are small, or as large as they are."""
    if (most := _tripled(parts)) is None:
        return "nothing is missing beyond noise and small disturbances"
    return "nothing is missing beyond noise, and disturbances that make the {} error {:.1f} times as large".format(
        *most
    )


def _missing(announced: Sequence[Finding], stages: Sequence[Rung]) -> list[str]:
    """What is announced, and the error that falls most with all that was found."""
    if not announced:
        return []
    fall, parts = fall_of_error(stages), ["missing: " + "; ".join(map(_with_alternatives, announced))]
    if fall is not None:
        parts.append(f"with it the {fall[0]} error on held-out pieces changes from {fall[1]:.3g} to {fall[2]:.3g}")
    return parts


def _likely(finding: Finding) -> bool:
    return finding.probability is None or finding.probability >= SETTINGS.mostly


def _unlikely(findings: Sequence[Finding]) -> list[str]:
    names = "; ".join(map(_with_alternatives, findings))
    return [f"less likely than not: {names}, as other effects beside the rest are likelier"] if names else []


def _small(findings: Sequence[Finding]) -> list[str]:
    names = ", ".join(map(_alone, findings))
    return [f"small: {names}, beyond chance, and no error is larger by a tenth without it"] if names else []


def _beside(findings: Sequence[Finding], gate: Gate, leftovers: Sequence[Leftover] = ()) -> list[str]:
    """What was found where the answer is another one, and why it is none."""
    others = [finding for finding in findings if of_another_form(finding, leftovers)]
    rest = [finding for finding in findings if finding not in others]
    form = "what is left stands in its place, or still depends on the same command: the robot lacks another form"
    parts = [f"beside it {_beyond_chance(others)}, but {form}"] if others else []
    if others and all(finding.small for finding in rest):
        return [*parts, *_small(rest)]
    return [*parts, f"beside it {_beyond_chance(rest)}, but {_not_borne_out(rest, gate)}"] if rest else parts


def _no_answer(findings: Sequence[Finding], gate: Gate, interrupted: str) -> list[str]:
    """Why nothing can be told, and what was found all the same."""
    provisional, named = any(finding.provisional for finding in findings), "; ".join(map(_with_alternatives, findings))
    if provisional or not (findings or interrupted):
        tested = ", so that no finding can be tested" if findings else ""
        pieces = f"{SETTINGS.fewest_pieces} independent pieces of at least {BLOCK_SECONDS:g} s"
        parts = [f"too little data: fewer than {pieces}{tested}"]
        parts += [f"{interrupted} was interrupted before it ended"] if interrupted else []
        return [*parts, f"perhaps missing: {named}"] if findings else parts
    if interrupted:
        parts = [f"no answer: {interrupted} was interrupted before it ended"]
        return [*parts, f"found by then: {named}"] if findings else parts
    return [f"no answer: {_beyond_chance(findings)}, but {_not_borne_out(findings, gate)}"]


def _suspected(suspects: Mapping[str, float]) -> str:
    would = " or ".join(f"{effect} ({100 * part:.0f} %)" for effect, part in [*suspects.items()][:3])
    few = f"no answer: {would} would explain what is missing, but too few independent pieces of these logs tell of it"
    first = next(iter(suspects))
    return f"{few}: `sym2real add MODEL {first} --fit LOGS` says how well it fits, more logs of such motions decide"


def _beyond_chance(findings: Sequence[Finding]) -> str:
    names = " and ".join(_alone(finding) for finding in findings)
    return f"{names} {'is' if len(findings) == 1 else 'are'} beyond chance"


def _not_borne_out(findings: Sequence[Finding], gate: Gate) -> str:
    """Why findings are not the answer."""
    if gate.passed and all(finding.doubtful for finding in findings):
        return "commands that change between the rows of the logs look the same"
    if gate.worse:
        return f"the held-out error {gate.worse[0].text}"
    if gate.best is None or not gate.beats_hold:
        return "no prediction of these logs is good enough to decide"
    if gate.fallen:
        times = f"errors more than {SETTINGS.far:g} times what noise and disturbances make"
        return f"most of the misfit or of every error stays, or {times}"
    return f"no held-out error surely falls by {100 * SETTINGS.worth_saying:.0f} %: that {gate.best.text}"


def _alone(finding: Finding) -> str:
    """An effect with its values, without those that it cannot be told from, and without a share of nothing."""
    shown = {name: own for name, own in finding.parameters.items() if name != SHARE or own.low > 0.0}
    values = ", ".join(f"{name} {estimate.with_half_width}" for name, estimate in shown.items())
    return f"{finding.effect} ({values})"


def _with_alternatives(finding: Finding) -> str:
    others = in_few_words(finding.alternatives)[:3]
    return _alone(finding) + (f", or {' or '.join(others)}" if others else "")


def fall_of_error(stages: Sequence[Rung]) -> tuple[str, float, float] | None:
    """Channel, first and last error at the horizon that is judged of the channel that falls most."""
    if len(stages) < 2 or not stages[0].horizons or not any(stage.beats_hold for stage in stages):
        return None
    horizon = stages[0].nearest(JUDGED_AT)
    first, last = stages[0].horizons[horizon], stages[-1].horizons[horizon]
    channels = judged(first)
    best = min(channels, key=lambda channel: last[channel].value / max(first[channel].value, 1e-12))
    return f"{best} ({horizon:.3g} s)", first[best].value, last[best].value
