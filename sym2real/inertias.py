"""Inertias of an ``MjSpec``'s bodies, as MuJoCo compiled them, written out."""

from typing import Any


def write_inertia(body: Any, model: Any, times: float = 1.0) -> None:
    """Give a body of a spec the mass and the inertia that the compiled model has for it, or so many times these.

    Then no geom says what it weighs.
    """
    body.explicitinertial, body.fullinertia = True, [float("nan")] * 6
    body.mass, body.inertia = times * model.body_mass[body.id], times * model.body_inertia[body.id]
    body.ipos, body.iquat = model.body_ipos[body.id], model.body_iquat[body.id]
