"""What logs are like, in sentences."""

from sym2real.diagnosis.faults.report import DataReport
from sym2real.diagnosis.faults.variation import exactness
from sym2real.diagnosis.settings import SETTINGS


def data_remarks(data: DataReport) -> list[str]:
    """How much data there are, and what is not as it should be and no fault."""
    remarks = [f"{data.logs} log{'s' if data.logs > 1 else ''}, {data.rows} rows, time step {data.dt:.4g} s"]
    if data.jitter > SETTINGS.uneven:
        remarks.append(f"the time step varies by {100 * data.jitter:.0f} %")
    if data.gaps:
        remarks.append(f"{data.gaps} gaps, the longest {data.longest_gap:.3g} s")
    remarks += [*data.spacing, *exactness(data.exact, data.logs)]
    for name, varied in data.commands.items():
        weak = f"{name} hardly varies (±{varied.deviation:.2g} {varied.unit}): effects on it cannot be seen"
        remarks += [*([weak] if varied.weak else []), *varied.limit_notes(name)]
        if varied.reversal < -SETTINGS.nearly:
            chatters = "as of a controller that chatters, and what it does between the rows is not in the log"
            remarks.append(f"{name} goes up and down from row to row, {chatters}")
    for name, own in data.agreements.items():
        if own.verdict == "unclear":
            remarks.append(f"{name} and the derivative of the {own.of} correlate by {own.correlation:.2f}")
    return remarks
