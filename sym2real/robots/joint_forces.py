"""What acts along the joints of a robot from an MJCF: actuators, springs, dampers, dry friction, and what comes in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from sympy import Expr, Max, Min, tanh

from sym2real.layout import push_column
from sym2real.robots.joint_tree import Link, as_expression
from sym2real.robots.spatial import Values
from sym2real.symbolic import symbol

# m/s², rad/s²: what dry friction takes of a rate, about; within a period of it a joint is held rather than slides.
SLOW = 0.3


@dataclass(frozen=True, eq=False)
class Forces:
    """Along the joints: pushes, springs, dampers, dry friction and actuators.

    Args:
        model: the compiled file.
        links: its joints.
        actions: column of the action by actuator.
        slow: rate below which dry friction holds rather than brakes, m/s or rad/s.
    """

    model: mujoco.MjModel
    links: Sequence[Link]
    actions: Mapping[str, str]
    slow: float

    def at(self, place: Values, rate: Values) -> Values:
        """Where the joints are and how fast they move ``# (n,)``."""
        force = np.array([symbol(push_column(link.joint)) for link in self.links], dtype=object)
        for number, link in enumerate(self.links):
            force[number] += -symbol(f"damping_{link.joint}") * rate[number]
            force[number] += -symbol(f"friction_{link.joint}") * tanh(rate[number] / self.slow)
            force[number] += -as_expression(link.stiffness) * (place[number] - as_expression(link.rest))
        numbers = {link.joint: number for number, link in enumerate(self.links)}
        for name, column in self.actions.items():
            index = self.model.actuator(name).id
            joint = numbers[self.model.joint(int(self.model.actuator_trnid[index, 0])).name]
            force[joint] += self._given(index, symbol(column), place[joint], rate[joint])
        return force

    def _given(self, index: int, told: Expr, place: Expr, rate: Expr) -> Expr:
        """By an actuator's gain and bias, within its limits."""
        model = self.model
        gear, gain = as_expression(model.actuator_gear[index, 0]), as_expression(model.actuator_gainprm[index, 0])
        constant, by_place, by_rate = (as_expression(one) for one in model.actuator_biasprm[index, :3])
        given = gain * told + constant + by_place * gear * place + by_rate * gear * rate
        if model.actuator_forcelimited[index]:
            low, high = model.actuator_forcerange[index]
            given = Max(Min(given, float(high)), float(low))
        return gear * given
