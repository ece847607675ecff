"""What nobody knows of a healthy robot: numbers that are free in every fit, within bounds, and never a finding there.

Inertia and the gain of the on-board rate loop are rarely known better than to a tenth. Their ratio sets how fast the
body follows its rate commands, so that the loop's gain is free between 0.8 and 1.25 of the nominal one whatever else is
fitted; ``rate_loop_gain`` is a finding only where the data ask for more than that. What a torque does to the rates goes
by the loop's stiffness, inertia times gain: effects that act by a torque are known no better than that stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor

from sym2real.diagnosis.predict.library import Library


@dataclass(frozen=True)
class Nuisance:
    """Parameters that every hypothesis has free, with their bounds.

    Args:
        free: slots, those that move together in one tuple.
        low, high: bounds of each.
    """

    free: tuple[tuple[int, ...], ...] = ()
    low: tuple[float, ...] = ()
    high: tuple[float, ...] = ()

    def nearest(self, tied: tuple[int, ...], value: float, otherwise: float) -> float:
        """The value itself as far as the bounds allow; ``otherwise`` for slots that are no nuisance."""
        if tied not in self.free:
            return otherwise
        place = self.free.index(tied)
        return min(max(value, self.low[place]), self.high[place])


def nuisance_of(library: Library, origin: Tensor) -> Nuisance:
    """The nuisance of a library around what is known of its base ``# (P,)``."""
    known = [(slot, effect.of.nuisance) for key, effect in library.effects.items() for slot in library.indices(key)]
    bounds = [(slot, float(origin[slot]), factors) for slot, factors in known if factors is not None]
    return Nuisance(
        tuple((slot,) for slot, _, _ in bounds),
        tuple(low * here for _, here, (low, _) in bounds),
        tuple(high * here for _, here, (_, high) in bounds),
    )
