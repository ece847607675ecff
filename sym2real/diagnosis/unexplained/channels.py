"""What may depend on something: disturbances, what measurements are off by, and parameters that were found."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from sym2real.diagnosis.estimate.fit import Fit
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.features import ahead_of
from sym2real.effects.wrench import AXES
from sym2real.symbolic.mass_normalised import unit_for
from sym2real.vocabulary import FORCE

TURNED = " in the robot's axes"  # behind the name of a level force
# Measurements that may be off by a constant which the free start does not take up, and their unit.
MEASURED = {"attitude": "rad", "heading": "rad", "rate": "rad/s"}


@dataclass(frozen=True)
class Channel:
    """What may depend on something.

    Args:
        name, unit: of a disturbance or a measurement; of a parameter that was found its effect's name.
        kind: "disturbance", "measured" or "fitted".
        size: of a step, in the unit.
        level: its value where no term acts.
        places: of the shapes that it is made of.
        axis: of a level force in the robot's axes, forward or to the left; none of others.
    """

    name: str
    unit: str
    kind: str
    size: float
    places: tuple[int, ...]
    level: float = 0.0
    axis: int | None = None


def channels_of(problem: Problem, spread: Spread, fit: Fit) -> list[Channel]:
    """Disturbances, those in the robot's axes, measurements that may be off, and parameters that were found."""
    names, library = spread.names, problem.library
    layouts, sizes = library.equations.layouts, dict(zip(names, spread.sizes.tolist(), strict=True))
    units = {n: unit_for(library.equations, (layouts.action.units | layouts.inputs.units)[n]) for n in names}
    channels = [Channel(n, units[n], "disturbance", sizes[n], (k,)) for k, n in enumerate(names)]
    level = [channel for channel in channels if channel.name in FORCE.columns[:2]]
    if len(level) > 1 and _turns(problem):
        both = tuple(place for channel in level for place in channel.places)
        turned = (replace(along, name=along.name + TURNED, places=both) for along in level)
        channels += [replace(along, axis=axis) for axis, along in enumerate(turned)]
    offsets = [*offsets_of(problem)]
    channels += [Channel(n, unit, "measured", 1.0, (k,)) for k, (n, unit, _) in enumerate(offsets, len(names))]
    for place, slot in enumerate(fit.free, len(names) + len(offsets)):
        known, scale, value = library.slots[slot], float(library.scale[slot]), float(fit.values[slot])
        channels.append(Channel(known.effect, known.parameter.unit, "fitted", scale, (place,), value))
    return channels


def _turns(problem: Problem) -> bool:
    """Whether the robot points elsewhere in the course of the logs: else its axes are the world's, turned once."""
    ahead = ahead_of(problem)
    return ahead is not None and float(ahead.mean((0, 1)).norm()) < 1.0 - SETTINGS.negligible


def offsets_of(problem: Problem) -> Iterator[tuple[str, str, int]]:
    """Name, unit and component of every measurement that may be off by a constant."""
    segments = problem.segments
    for place, (component, number) in enumerate(zip(segments.compared, segments.channel, strict=True)):
        owner, places = segments.layout.fields[number], segments.layout.tangent_places[number]
        if owner.name in MEASURED:
            axis = f" {AXES[component - places.start]}" if len(places) > 1 else ""
            yield f"measured {owner.name}{axis}", MEASURED[owner.name], place
