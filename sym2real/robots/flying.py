"""First-principles equations of a rotorcraft from its MJCF: one free body, and rotors or others that act at its sites.

What :func:`sym2real.robots.nominal_quadrotor.quadrotor` needs is in the compiled file: mass and moments in the free
joint's matrix of masses, places of rotors at sites, thrust and reaction torque in gain and gear of their actuators.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from sym2real.errors import ModelError
from sym2real.robots import mjcf_columns as columns
from sym2real.robots.covered import LEARN, forces_beside, those_that_hold
from sym2real.robots.planar import STATE
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array
from sym2real.vocabulary import MOTOR_COLUMNS

if TYPE_CHECKING:
    from sym2real.symbolic import Equations

ALIKE = 0.01  # part by which thrusts may differ, moments lie askew, and forces point aside
NAMED = "`--actions ACTUATOR=motor1 …` names their columns, in Python actions={…}"
OFF = 0.01  # m from the body's origin to its centre of mass, which the equations take for one


@dataclass(frozen=True, eq=False)
class Rotorcraft:
    """A free body with actuators at its sites.

    Args:
        mass: kg.
        centre: of mass in the body's axes, m ``# (3,)``.
        inertia: about it, kg m² ``# (3, 3)``.
        places: of the actuators' sites from there, m ``# (rotors, 3)``.
        forces, torques: of them for a command of 1, N and N m ``# (rotors, 3)``.
    """

    mass: float
    centre: Array
    inertia: Array
    places: Array
    forces: Array
    torques: Array

    @classmethod
    def of(cls, model: mujoco.MjModel, data: Any, actuators: list[int]) -> Rotorcraft:
        """That of a compiled file, where its data stand."""
        free = int(np.argmax(model.jnt_type == columns.FREE))
        body, first = int(model.jnt_bodyid[free]), int(model.jnt_dofadr[free])
        axes = data.xmat[body].reshape(3, 3)
        whole = columns.inertias(model, data)[first : first + 6, first : first + 6]
        mass, centre = float(whole[0, 0]), (data.subtree_com[body] - data.xpos[body]) @ axes
        # Steiner: the matrix holds the moments about the body's origin.
        inertia = whole[3:, 3:] - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        sites = model.actuator_trnid[actuators, 0]
        turned = np.einsum("ba,nbc->nac", axes, data.site_xmat[sites].reshape(-1, 3, 3))
        given = model.actuator_gainprm[actuators, 0][:, None] * model.actuator_gear[actuators]
        forces, torques = (np.einsum("nab,nb->na", turned, part) for part in (given[:, :3], given[:, 3:]))
        return cls(mass, centre, inertia, (data.site_xpos[sites] - data.xpos[body]) @ axes - centre, forces, torques)

    @property
    def thrusts(self) -> Array:
        """Of the rotors along body z for a command of 1, N ``# (rotors,)``."""
        return self.forces[:, 2]

    @property
    def whole_torques(self) -> Array:
        """About the centre of mass, with those of the forces at their places ``# (rotors, 3)``."""
        return np.asarray(self.torques + np.cross(self.places, self.forces))

    @property
    def hovering(self) -> Array:
        """The commands that carry it and turn it least, of rotors all alike ``# (rotors,)``."""
        given = np.column_stack([self.thrusts, self.whole_torques]).T
        return np.asarray(np.linalg.pinv(given) @ [self.mass * GRAVITY, 0.0, 0.0, 0.0])

    @property
    def has_rotors(self) -> bool:
        """Whether every actuator lifts it, as a rotor does; others are a thrust and torques by themselves."""
        return bool(self.thrusts.min() > 0.0)

    @property
    def reactions(self) -> Array:
        """Torque about body z per thrust of every rotor, m ``# (rotors,)``."""
        return self.torques[:, 2] / self.thrusts

    @property
    def numbers(self) -> dict[str, float]:
        """By the names of a body's."""
        moments = dict(zip(("jx", "jy", "jz"), self.inertia.diagonal().tolist(), strict=True))
        if not self.has_rotors:
            return moments
        arm = float(np.hypot(*self.places[:, :2].T).mean())
        return {**moments, "arm": arm, "torque_per_thrust": float(np.abs(self.reactions).mean())}

    def equations(self, dt: float, commands: Sequence[str]) -> Equations:
        """Of its motion by commands of these names."""
        from sym2real.robots.motors import Motors, Wrenches  # noqa: PLC0415 — SymPy stays out of light imports
        from sym2real.robots.nominal_quadrotor import quadrotor  # noqa: PLC0415

        motors: Motors | Wrenches
        if not self.has_rotors:
            motors = Wrenches(
                tuple(commands), tuple(self.thrusts.tolist()), tuple(map(tuple, self.whole_torques.tolist()))
            )
            return quadrotor(self.mass, self.inertia.diagonal().tolist(), interface="motors", motors=motors, dt=dt)
        motors = Motors(
            float(self.thrusts.mean()),
            torque_per_thrust=self.numbers["torque_per_thrust"],
            arm=tuple(np.hypot(*self.places[:, :2].T).tolist()),
            spin=tuple(np.where(self.reactions < 0, -1, 1).tolist()),
            angles=tuple(np.rad2deg(np.arctan2(self.places[:, 1], self.places[:, 0])).tolist()),
        )
        return quadrotor(self.mass, self.inertia.diagonal().tolist(), interface="motors", motors=motors, dt=dt)


def against_flying(model: mujoco.MjModel, data: Any, actions: Mapping[str, str]) -> list[str]:
    """What keeps a robot with a free joint from being a rotorcraft with equations here; empty for one that is none."""
    actuators = [model.actuator(name).id for name in actions]
    at_sites = bool(actuators) and (model.actuator_trntype[actuators] == mujoco.mjtTrn.mjTRN_SITE).all()
    if model.njnt > 1 and not at_sites:
        return [
            f"joints that its actuators drive (on wheels it opens with --state {' '.join(STATE)}, in Python state=[…])"
        ]
    wrong = {
        "joints beside the free one": model.njnt > 1,
        "actuators that are not at sites": not at_sites,
        "an actuator that is commanded more than a force": bool(
            model.actuator_biastype.any() or model.actuator_dyntype.any()
        ),
        f"a gravity that is not {GRAVITY:g} m/s² along z down": not np.allclose(
            model.opt.gravity, (0.0, 0.0, -GRAVITY), atol=ALIKE * GRAVITY
        ),
        "rotors whose force ends before their command does": _ends_early(model, actuators),
        "a damping of the free joint": model.dof_damping[
            model.dof_jntid == np.argmax(model.jnt_type == columns.FREE)
        ].any(),
    }
    if reasons := those_that_hold(wrong | forces_beside(model)):
        return reasons
    craft = Rotorcraft.of(model, data, actuators)
    moments = craft.inertia.diagonal()
    askew = np.abs(craft.inertia - np.diag(moments)).max()
    wrong = {
        "principal axes that are not the body's": askew > ALIKE * moments.min(),
        f"a centre of mass {np.linalg.norm(craft.centre):.3g} m from the body's origin": np.linalg.norm(craft.centre)
        > OFF,
        "actuators that do not push along body z alone": np.abs(craft.forces[:, :2]).max()
        > ALIKE * np.abs(craft.thrusts).max(),
    }
    return those_that_hold(wrong | (_against_rotors(craft, [*actions.values()]) if craft.has_rotors else {}))


def _against_rotors(craft: Rotorcraft, names: list[str]) -> dict[str, bool]:
    thrusts, reactions = craft.thrusts, np.abs(craft.torques[:, 2])
    uneven = bool(np.ptp(reactions) > ALIKE * reactions.max())
    motors = [*MOTOR_COLUMNS[: len(names)]]
    return {
        f"actuators that are not called {', '.join(motors)} ({NAMED})": names != motors,
        "rotors that do not push alike, all along body z": bool(np.ptp(thrusts) > ALIKE * thrusts.min()),
        "rotors whose torques are not alike, about body z": uneven
        or bool(np.abs(craft.torques[:, :2]).max() > ALIKE * reactions.max()),
    }


def _ends_early(model: mujoco.MjModel, actuators: list[int]) -> bool:
    """Whether an actuator's forcerange cuts off what its ctrlrange asks for."""
    limited = [index for index in actuators if model.actuator_forcelimited[index] and model.actuator_ctrllimited[index]]
    asked = model.actuator_gainprm[limited, :1] * model.actuator_ctrlrange[limited]
    given = np.clip(asked, *model.actuator_forcerange[limited].T[..., None])
    return bool((np.abs(asked - given) > ALIKE * np.abs(asked)).any())


def flying(model: mujoco.MjModel, data: Any, actions: Mapping[str, str], dt: float) -> Equations:
    """Equations of a compiled MJCF.

    Raises:
        ModelError: for what these equations do not cover, naming it.
    """
    if reasons := against_flying(model, data, actions):
        raise ModelError(f"expected a free body with rotors at its sites, found {' and '.join(reasons)}: {LEARN}")
    craft = Rotorcraft.of(model, data, [model.actuator(name).id for name in actions])
    return craft.equations(dt, [*actions.values()])
