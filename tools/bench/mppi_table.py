"""The comparison as Markdown: what is held against a bar, and the times of everybody."""

from collections.abc import Sequence

from figures import Figure

WORDS = {None: "", True: "holds", False: "missed"}


def markdown(figures: Sequence[Figure]) -> str:
    """Two tables: figures that are no times of contestants, then median and p99 in ms by contestant and samples."""
    times = [figure for figure in figures if ", N = " in figure.name]
    others = [figure for figure in figures if ", N = " not in figure.name]
    bars = others + [figure for figure in times if figure.bar]
    lines = ["| figure | measured | bar | |", "|---|---:|---:|---|"]
    lines += [f"| {f.name} | {f.value:.3g} {f.unit} | {f.bar} | {WORDS[f.holds]} |" for f in bars]
    return "\n".join([*lines, "", *_times(times)])


def _times(figures: Sequence[Figure]) -> list[str]:
    cells: dict[tuple[str, str], dict[int, dict[str, float]]] = {}
    for figure in figures:
        robot, rest = figure.name.split(", N = ")
        samples, name = rest.split(": ")
        name, kind = name.removesuffix(", p99"), "p99" if name.endswith(", p99") else "median"
        cells.setdefault((robot, name), {}).setdefault(int(samples), {})[kind] = figure.value
    columns = sorted({samples for row in cells.values() for samples in row})
    lines = ["| robot | ms: median (p99) | " + " | ".join(f"N = {samples}" for samples in columns) + " |"]
    lines += ["|---|---|" + "---:|" * len(columns)]
    for (robot, name), row in cells.items():
        values = [f"{row[n]['median']:.3g} ({row[n]['p99']:.3g})" if n in row else "" for n in columns]
        lines.append(f"| {robot} | {name} | {' | '.join(values)} |")
    return lines
