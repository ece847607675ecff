"""A carriage of 1 kg on a rail, driven by a force, and what regulators of it have in common."""

from __future__ import annotations

from pathlib import Path

from sym2real.robots import Robot
from sym2real.trajectory import Array

TEXT = """<mujoco><option timestep="0.001" integrator="implicitfast"/><worldbody><body>
<joint name="rail" type="slide" axis="1 0 0" damping="{damping}" stiffness="{stiffness}" range="-9 9"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
</body></worldbody><actuator><motor name="drive" joint="rail" ctrlrange="-{most} {most}"/></actuator></mujoco>"""


def carriage(folder: Path, *, damping: float, most: float, stiffness: float = 0.0) -> Robot:
    """With damping in N s/m, a largest force in N, and a spring in N/m."""
    (file := folder / "rail.xml").write_text(TEXT.format(damping=damping, most=most, stiffness=stiffness))
    return Robot.from_mjcf(file, dt=0.02)


class Regulator:
    """It has nothing to forget and nothing to note."""

    def reset(self) -> None:
        """Begin anew."""

    def remember(self, sent: Array) -> None:
        """Note what was sent."""
