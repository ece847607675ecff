"""What acts along the joints of a robot from an MJCF: actuators, springs, dampers, and what comes in."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from sympy import Abs, Expr, Integer, Max, Min

from sym2real.robots.driven import braking
from sym2real.robots.joint_tree import Link, as_expression
from sym2real.robots.mjcf_columns import command_kind, driven_joint, servos_of
from sym2real.robots.spatial import Values, exact
from sym2real.symbolic import symbol
from sym2real.vocabulary import push_column, quantity_of


@dataclass(frozen=True, eq=False)
class Forces:
    """Along the joints: external forces, springs, dampers and actuators, and what dry friction may be.

    Args:
        model: the compiled file.
        links: its joints.
        actions: column of the action by actuator; others stand at control 0.
    """

    model: mujoco.MjModel
    links: Sequence[Link]
    actions: Mapping[str, str]

    def at(self, place: Values, rate: Values) -> Values:
        """Where the joints are and how fast they move ``# (n,)``."""
        joints = {link.joint: number for number, link in enumerate(self.links)}
        force = np.array([symbol(push_column(joint)) for joint in joints], dtype=object)
        for number, link in enumerate(self.links):
            force[number] += -symbol(quantity_of("damping", link.joint)) * rate[number]
            force[number] += -symbol(quantity_of("drag", link.joint)) * rate[number] * Abs(rate[number])
            force[number] += -symbol(quantity_of("stiffness", link.joint)) * (place[number] - as_expression(link.rest))
        actuation = np.zeros(len(joints), dtype=int).astype(object)
        for index in range(self.model.nu):
            name = self.model.actuator(index).name
            control = symbol(self.actions[name]) if name in self.actions else Integer(0)
            joint = joints[driven_joint(self.model, index)]
            actuation[joint] += self._given(index, control, place[joint], rate[joint])
        servos = servos_of(self.model)
        for number, link in enumerate(self.links):
            joint = self.model.joint(link.joint).id
            if self.model.jnt_actfrclimited[joint]:
                actuation[number] = within(actuation[number], *self.model.jnt_actfrcrange[joint].tolist())
            if link.joint in servos:
                most = symbol(quantity_of("servo_limit", link.joint))
                actuation[number] = within(actuation[number], -most, most)
        return force + actuation

    @property
    def friction(self) -> list[Expr]:
        """Dry friction of each joint at most ``# (n,)``."""
        return [symbol(quantity_of("friction", link.joint)) for link in self.links]

    @property
    def brakes(self) -> Values:
        """Damping of each joint with its servos' gain of the rate ``# (n,)``."""
        dofs = [self.model.joint(link.joint).dofadr[0] for link in self.links]
        servos = exact((braking(self.model) - self.model.dof_damping)[dofs])
        return servos + [symbol(quantity_of("damping", link.joint)) for link in self.links]

    def _given(self, index: int, control: Expr, place: Expr, rate: Expr) -> Expr:
        """By an actuator's gain and bias, within its limits."""
        model = self.model
        gear, gain = as_expression(model.actuator_gear[index, 0]), as_expression(model.actuator_gainprm[index, 0])
        constant, by_place, by_rate = (as_expression(bias) for bias in model.actuator_biasprm[index, :3])
        if (kind := command_kind(model, index)) != "force":
            times = symbol(quantity_of("servo_gain", driven_joint(model, index)))
            gain, by_place = times * gain, by_place * (times if kind == "position" else 1)
            by_rate = by_rate * (times if kind == "velocity" else 1)
        given = gain * control + constant + by_place * gear * place + by_rate * gear * rate
        if model.actuator_forcelimited[index]:
            given = within(given, *model.actuator_forcerange[index].tolist())
        return gear * given


def within(force: Expr, low: Expr | float, high: Expr | float) -> Expr:
    """A force that ends at limits."""
    return Max(Min(force, high), low)
