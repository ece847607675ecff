"""The error ladder for the terminal: the base, then one effect after the other, down to noise and disturbances."""

import math
from collections.abc import Sequence
from itertools import pairwise

from rich.markup import escape
from rich.table import Table

from sym2real.diagnosis import Floor
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.report.tables import compact_table, number, sparkline

# What a model that misses nothing would leave; a comparison's lowest error is that of the sensors alone.
LOWEST = "noise and\ndisturbances"
# Said where a step of the ladder leads up, beyond the interval of the one before.
TOGETHER = "Where the error rises, that effect helps only together with one below it."

# Said where a dash stands for an error.
DIVERGED = "–: predictions there are no numbers; that model diverges, or its commands are in another unit."


def ladder_table(
    stages: Sequence[Stage], floor: Sequence[Floor], held_out: Sequence[str], *, apart: bool = False
) -> Table:
    """Held-out errors near 0.8 s ahead, root mean square per channel.

    The first channel is followed by its 95 % interval, and by how it grows with the horizon.

    Args:
        stages, floor: what is shown.
        held_out: names of the logs that are scored.
        apart: whether they took no part in any fit; else each is scored by the fit of the others.
    """
    horizon = stages[0].nearest(JUDGED_AT)
    channels = stages[0].horizons[horizon]
    main = next(iter(channels))
    title = f"the ladder: error {horizon:.3g} s ahead on {_names(held_out, apart)}"
    table = compact_table(title)
    table.padding = (0, 0)  # the box parts columns by one space: four channels and long intervals stay within 80
    table.add_column("model", overflow="fold", min_width=13)
    tall = 1 + max(len(channel.split()) for channel in channels)  # a word a line: "joint displacement" is wide
    for channel, error in channels.items():
        table.add_column(_heading([*channel.split(), error.unit], tall), justify="right", no_wrap=True)
        if channel == main:
            table.add_column(_heading(["95 %"], tall), justify="right", no_wrap=True, style="dim")
            table.add_column(_heading([f"to {max(stages[0].horizons):g} s"], tall), no_wrap=True)
    top = max(errors[main].value for errors in stages[0].horizons.values())
    for stage in stages:
        here = stage.horizons[horizon]
        over = [stage.horizons[at][main].value for at in sorted(stage.horizons)]
        interval = f"{number(here[main].low, 2)}…{number(here[main].high, 2)}"
        first, *others = [number(error.value) for error in here.values()]
        table.add_row(escape(stage.model), first, interval, sparkline(over, highest=top), *others)
    errors = [stage.horizons[horizon][main] for stage in stages]
    rises = any(after.value > before.high for before, after in pairwise(errors))
    diverged = any(math.isnan(error.value) for stage in stages for error in stage.horizons[horizon].values())
    remarks = [remark for remark, holds in ((TOGETHER, rises), (DIVERGED, diverged)) if holds]
    if remarks:
        table.caption, table.caption_justify = "\n".join(remarks), "left"
    lowest = {at.horizon: at.errors for at in floor}
    if horizon in lowest:
        first, *others = [number(lowest[horizon].get(channel, (float("nan"), ""))[0], 2) for channel in channels]
        over = [lowest[at][main][0] for at in sorted(lowest)]
        table.add_row(LOWEST, first, "", sparkline(over, highest=top), *others, style="dim")
    return table


def _heading(lines: Sequence[str], tall: int) -> str:
    """Lines at the foot of a heading of so many."""
    return "\n".join([""] * (tall - len(lines)) + [*lines])


def _names(held_out: Sequence[str], apart: bool) -> str:
    if not held_out:
        return "held-out pieces"
    if len(held_out) <= 3:
        return ", ".join(held_out)
    return f"{len(held_out)} logs, {'kept aside' if apart else 'each left out once'}"
