"""Physical effects: hypotheses that substitute into equations, and their truth in a simulator.

>>> EFFECTS["wind"].summary
'A steady force along world axes: wind, a pulling cable.'
"""

from sym2real.effects.body import Body as Body
from sym2real.effects.bound import Effect as Effect
from sym2real.effects.catalogue import applicable as applicable, effect as effect
from sym2real.effects.composing import compose as compose
from sym2real.effects.groups import GROUPS as GROUPS, equivalents as equivalents
from sym2real.effects.kind import Kind as Kind, Parameter as Parameter
from sym2real.effects.kinds import EFFECTS as EFFECTS
from sym2real.effects.known_effects import as_simulated as as_simulated, injected as injected, noted as noted
