"""Evidence on any column: constant, or without numbers; and what is not known."""

import numpy as np

from sym2real.logs.assignment import speaks_of_joints
from sym2real.logs.draft import Draft
from sym2real.trajectory import Array


def inspect_columns(draft: Draft, *, of_model: bool) -> None:
    """Remarks on every numeric column, and on those that nothing was made of; whether a model's were looked for."""
    known = {finding.column for finding in draft.findings}
    for name in draft.tables[0].columns:
        remark = _remark(np.concatenate([table.columns[name] for table in draft.tables]))
        if name not in known:  # in one row: a message has dozens of them, covariances and frames
            _unknown(draft, name, remark, of_model=of_model)
        elif remark:
            draft.add(name, "remark", "", remark, "certain")
    for name in draft.tables[0].texts:
        draft.add(name, "?", "", "text, left out", "unknown")


def _unknown(draft: Draft, name: str, remark: str, *, of_model: bool) -> None:
    also = f"; {remark}" if remark else ""
    standard = next((key for key, column in draft.assignment.columns.items() if column == name), "")
    if standard:
        draft.add(name, standard, "", f"by its name{also}", "likely")
        return
    if first := draft.assignment.duplicates.get(name):
        draft.add(name, "?", "?", f"looks like the same as {first!r}, the first of them{also}", "unknown")
        return
    named = draft.assignment.named.get(name)
    says = f"named like {named.role} {named.quantity} {named.axis}".strip() if named else "the name says nothing"
    if not of_model and any(map(str.isdigit, name)) and speaks_of_joints(list(draft.tables[0].columns)):
        says = "it may be a joint's: --model says of which robot"
    draft.add(name, "?", "?", f"{says}; kept as an extra column{also}", "unknown")


def _remark(values: Array) -> str:
    missing = int(np.isnan(values).sum())
    if missing:
        return f"{missing} of {len(values)} cells hold no number"
    return "" if np.ptp(values) else f"constant at {values[0]:g}"
