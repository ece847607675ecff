"""The error ladder for the terminal: the base, then one effect after the other, down to noise and disturbances."""

import math
from collections.abc import Sequence
from itertools import pairwise

from rich.markup import escape
from rich.table import Table

from sym2real.diagnosis import Floor
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.diagnosis.errors.rungs import Rung
from sym2real.report.tables import compact_table, number

# What a model that misses nothing would leave; a comparison's lowest error is that of the sensors alone.
LOWEST, NOISE = "noise and\ndisturbances", "noise alone"
# Shown where a step of the ladder leads up, beyond the interval of the one before.
TOGETHER = "Where the error rises, that effect helps only together with one below it."

# Shown where a dash stands for an error.
DIVERGED = "–: predictions there are no numbers; that model diverges, or its commands are in another unit."


def ladder_table(
    stages: Sequence[Rung], floor: Sequence[Floor], held_out: Sequence[str], *, apart: bool = False
) -> Table:
    """Held-out errors near 0.8 s ahead, root mean square per channel.

    The first channel is followed by its 95 % interval.

    Args:
        stages, floor: what is shown.
        held_out: names of the logs that are scored.
        apart: whether they took no part in any fit; else each is scored by the fit of the others.
    """
    horizon = stages[0].nearest(JUDGED_AT)
    channels = stages[0].horizons[horizon]
    main = next(iter(channels))
    names = ["\n".join([*name.split(), error.unit]) for name, error in channels.items()]  # "joint displacement" is wide
    rows = []
    for stage in stages:
        here = stage.horizons[horizon]
        first, *others = [number(error.value) for error in here.values()]
        rows.append((escape(stage.model), first, f"{number(here[main].low, 2)}…{number(here[main].high, 2)}", *others))
    for at in (at for at in floor if at.horizon == horizon):
        for label, level in ((LOWEST, {name: error for name, (error, _) in at.errors.items()}), (NOISE, at.noise)):
            if level:
                first, *others = [number(level.get(channel, math.nan), 2) for channel in channels]
                rows.append((f"[dim]{label}[/]", first, "", *others))
    title = f"the ladder: error {horizon:.3g} s ahead on {_names(held_out, apart)}"
    table = compact_table(title, ("model", names[0], "95 %", *names[1:]), rows, left=("model",))
    table.padding = (0, 0)  # the box parts columns by one space: four channels and long intervals stay within 80
    table.columns[0].min_width = 13
    for column in table.columns[1:]:
        column.no_wrap = True
    errors = [stage.horizons[horizon][main] for stage in stages]
    rises = any(after.value > before.high for before, after in pairwise(errors))
    diverged = any(math.isnan(error.value) for stage in stages for error in stage.horizons[horizon].values())
    remarks = [remark for remark, holds in ((TOGETHER, rises), (DIVERGED, diverged)) if holds]
    if remarks:
        table.caption, table.caption_justify = "\n".join(remarks), "left"
    return table


def _names(held_out: Sequence[str], apart: bool) -> str:
    if not held_out:
        return "held-out pieces"
    if len(held_out) <= 3:
        return escape(", ".join(held_out))
    return f"{len(held_out)} logs, {'kept aside' if apart else 'each left out once'}"
