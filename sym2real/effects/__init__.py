"""Physical effects: hypotheses that substitute into equations, and their truth in a simulator.

>>> EFFECTS["wind"].summary
'A steady force along world axes: wind, a pulling cable.'
"""

from sym2real.effects.body import Body
from sym2real.effects.bound import Effect
from sym2real.effects.catalogue import applicable, effect
from sym2real.effects.composing import compose
from sym2real.effects.groups import GROUPS, equivalents
from sym2real.effects.kind import Kind, Parameter
from sym2real.effects.kinds import EFFECTS
from sym2real.effects.known_effects import as_simulated, injected, noted

__all__ = [
    "EFFECTS",
    "GROUPS",
    "Body",
    "Effect",
    "Kind",
    "Parameter",
    "applicable",
    "as_simulated",
    "compose",
    "effect",
    "equivalents",
    "injected",
    "noted",
]
