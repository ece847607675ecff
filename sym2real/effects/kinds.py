"""The registry: every kind of effect by its name. A new one is a file of that name, and its words in ``words.toml``."""

from sym2real.effects.kind import WORDS, Kind
from sym2real.registry import Registry

# In the order of the catalogue.
EFFECTS: Registry[Kind] = Registry("effect", {}, {name: f"sym2real.effects.{name}:{name.upper()}" for name in WORDS})
