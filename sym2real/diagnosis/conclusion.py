"""The answer in one word."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from sym2real.diagnosis.errors.floor import Floor
from sym2real.diagnosis.errors.rungs import Rung
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.faults.fault import Fault
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.score.held_out import Gate
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.explaining import beyond_times
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.effects import EFFECTS

Verdict = Literal["EFFECT", "NOTHING_MISSING", "UNEXPLAINED", "CANNOT_TELL"]


@dataclass(frozen=True)
class Parts:
    """What an answer is made of, as :class:`~sym2real.diagnosis.Diagnosis` holds it under the same names."""

    faults: tuple[Fault, ...] = ()
    findings: tuple[Finding, ...] = ()
    leftovers: tuple[Leftover, ...] = ()
    gate: Gate = field(default_factory=Gate)
    ladder: tuple[Rung, ...] = ()
    floor: tuple[Floor, ...] = ()
    suspects: Mapping[str, float] = field(default_factory=dict)


def verdict(
    parts: Parts, problems: Problems, *, finished: bool = True, misfit: tuple[float, float] = (1.0, 1.0)
) -> Verdict:
    """Which of the four answers the parts make; findings that do not improve long predictions are no answer.

    Fewer than ten independent blocks leave no test, and an unfinished search cannot say that nothing is missing, or
    that no effect explains what is left; nor can one that leaves out an effect which would, and of which too few pieces
    tell. A fault alone is the answer only where nothing is left once it is undone.
    Where predictions judge nothing, an effect is the answer if errors fall all the same and no tenth of a large misfit
    stays, or if nothing else is missing.
    Nor is it one where something is left and errors that fall with the findings stay far from what noise and
    disturbances make and more than a hundredth of the misfit stays, or most of it or of every judged error.
    Beside a finding that is :func:`of_another_form` a small one is no answer.
    What is left where no error is surely larger than noise alone makes it is no reason for another answer.
    Nothing is missing where no error is larger by a tenth without any of the findings, nor without all of them. What
    commands between the rows may have done is no effect, nor is a threshold that leaves something of its command.

    Args:
        parts: of the answer.
        problems: that were searched.
        finished: whether nobody interrupted the search.
        misfit: whitened squares per degree of freedom of the base and of the result, every piece trusted alike.
    """
    findings, leftovers, gate = parts.findings, parts.leftovers, parts.gate
    shown = [times > 1.0 for times, _ in beyond_times(parts.ladder, parts.floor, 0.0)]
    unexplained = any(leftover.matters for leftover in leftovers) and (any(shown) or not shown)
    formed = [finding for finding in findings if not of_another_form(finding, leftovers)]
    clear = any(not (finding.doubtful or (finding.small and len(formed) < len(findings))) for finding in formed)
    removed, falls = sum(finding.share for finding in findings), 1.0 if gate.best is None else gate.best.part
    before, after = misfit
    left = (after - 1.0) / max(before - 1.0, 1e-12) if after > SETTINGS.far else 0.0
    borne_out = gate.before is None or gate.beats_hold or (gate.fallen and left <= SETTINGS.worth_saying)
    stays = left > SETTINGS.mostly or min(removed, falls) < SETTINGS.mostly
    beyond = any(name in gate.falling for _, name in beyond_times(parts.ladder, parts.floor, SETTINGS.far))
    far = stays or (beyond and after - 1.0 >= SETTINGS.negligible * (before - 1.0))
    established = clear and gate.passed and not (unexplained and (far or not borne_out))
    if problems.block_count < SETTINGS.fewest_pieces or not (finished or established):
        return "CANNOT_TELL"
    if established:
        return "EFFECT"
    if parts.suspects:
        return "CANNOT_TELL"
    if unexplained:
        return "UNEXPLAINED"
    if parts.faults:
        return "EFFECT"
    return "NOTHING_MISSING" if all(finding.small for finding in findings) and not gate.worse else "CANNOT_TELL"


def of_another_form(finding: Finding, leftovers: Sequence[Leftover]) -> bool:
    """Whether another effect in a part of the logs explains more, or what a threshold of a command should explain is
    left, or it is another one from place to place: another mass in some of the logs looks like a limit of the thrust.
    """
    kind, _, command = finding.effect.partition(":")
    left = [leftover for leftover in leftovers if leftover.matters]
    if any(leftover.instead and leftover.channel == finding.effect for leftover in left):
        return True
    if kind not in EFFECTS or EFFECTS[kind].columns != "action" or EFFECTS[kind].searching.from_null:
        return False
    elsewhere = any(leftover.channel == finding.effect and leftover.r2 >= SETTINGS.nearly for leftover in left)
    return elsewhere or any(leftover.explained_by == command for leftover in left)
