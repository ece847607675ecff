"""How a robot's model is learned in its plain simulator, and by what it is judged."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal


@dataclass(frozen=True)
class Recipe:
    """What is known beforehand of learning a robot.

    Args:
        tasks: that its base model is learned on, by name with their options.
        episodes: that a base is learned from when nobody says how many.
        most_episodes: that learning may take.
        base: what its base is: learned from episodes of Stage I, or from drives by a geometric controller; or its
            nominal equations, of a robot whose motion no short equation holds.
        dither: standard deviation of what is added to commands so that logs show delays and lags, in each action's
            unit; a fiftieth of the commands' range by default.
        dependencies: pairs (state column, action column): that action must show in that state's equation.
        angles: columns that may stand inside sin and cos.
        cost_weights: of the default running cost by state field; ``orientation`` for attitude and heading.
    """

    tasks: tuple[tuple[str, Mapping[str, Any]], ...]
    episodes: int = 3
    most_episodes: int = 10
    base: Literal["episodes", "drives", "nominal"] = "episodes"
    dither: tuple[float, ...] = ()
    dependencies: tuple[tuple[str, str], ...] = ()
    angles: tuple[str, ...] = ()
    cost_weights: Mapping[str, float] = field(default_factory=dict)
