"""Evidence on any column: constant, a copy of another, held between updates, at its limits; and what is not known."""

import numpy as np

from sym2real.logs.assignment import speaks_of_joints
from sym2real.logs.draft import Draft
from sym2real.logs.extremes import at_extremes
from sym2real.trajectory import Array

HELD = 0.5  # share of rows that repeat the one before
SATURATED = 0.01  # share of rows that stay at the extreme value; at zero a robot rests
FEW = 3


def inspect_columns(draft: Draft, *, of_model: bool) -> None:
    """Remarks on every numeric column, and on those that nothing was made of; whether a model's were looked for."""
    tables = draft.tables
    known = {finding.column for finding in draft.findings}
    pooled = {name: np.concatenate([table.columns[name] for table in tables]) for name in tables[0].columns}
    seen: dict[bytes, str] = {}
    for name, values in pooled.items():
        remark = _remark([table.columns[name] for table in tables])
        if name not in known:  # in one row: a message has dozens of them, covariances and frames
            _unknown(draft, name, remark, of_model=of_model)
        elif remark:
            draft.add(name, "remark", "", remark, "certain")
        first = seen.setdefault(values.tobytes(), name)
        if first != name and np.ptp(values) > 0:
            draft.add(name, "remark", "", f"the same numbers as {first!r}", "certain")
    for name in tables[0].texts:
        draft.add(name, "?", "", "text, left out", "unknown")


def _unknown(draft: Draft, name: str, remark: str, *, of_model: bool) -> None:
    also = f"; {remark}" if remark else ""
    standard = next((key for key, column in draft.assignment.columns.items() if column == name), "")
    if standard:
        draft.add(name, standard, "", f"by its name{also}", "likely")
        return
    if rival := draft.assignment.rivals.get(name):
        draft.add(name, "?", "?", f"looks like the same as {rival!r}, the first of them{also}", "unknown")
        return
    named = draft.assignment.named.get(name)
    says = f"named like {named.role} {named.quantity} {named.axis}".strip() if named else "the name says nothing"
    if not of_model and any(map(str.isdigit, name)) and speaks_of_joints(list(draft.tables[0].columns)):
        says = "it may be a joint's: --model says of which robot"
    draft.add(name, "?", "?", f"{says}; kept as an extra column{also}", "unknown")


def _remark(pieces: list[Array]) -> str:
    values = np.concatenate(pieces)
    finite = values[np.isfinite(values)]
    if len(finite) < len(values):
        return f"{len(values) - len(finite)} of {len(values)} cells hold no number"
    if np.ptp(finite) == 0:
        return f"constant at {finite[0]:g}"
    if _are_few(finite):
        return ""
    # A value that stays at a limit is clipped, one that stays elsewhere waits for its next update.
    between = (values[1:] > finite.min()) & (values[1:] < finite.max())
    repeats = float(np.sum((np.diff(values) == 0) & between)) / max(1, int(between.sum()))
    if repeats > HELD:
        return f"held: {100 * repeats:.0f} % of the rows repeat the one before"
    edges = zip((finite.min(), finite.max()), at_extremes(pieces), strict=True)
    limits = [
        f"{edge:g} ({100 * share:.1f} % of the rows)" for edge, share in edges if share > SATURATED and edge != 0.0
    ]
    return f"saturates at {' and '.join(limits)}" if limits else ""


def _are_few(values: Array) -> bool:
    """Whether there are at most :data:`FEW` different values; sorting a million to count them takes long."""
    for _ in range(FEW):
        values = values[values != values[0]] if len(values) else values
    return not len(values)
