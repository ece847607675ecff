"""A simulated car whose axles steer outwards as the chassis leans in turns (Gillespie, ch. 6).

An axle that turns by an angle per lateral acceleration leads the car as tyres do that slip by it. The four wheels keep
one turning centre, as a linkage would have them: else they fight each other, and some of them slide.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.truth import rates, rotation, velocity
from sym2real.protocols import Change


def roll_steer(body: Body, front: float, rear: float) -> Change:
    """Wheels are turned against the chassis; what that does to the car is left to their contacts with the ground.

    Args:
        body: a car.
        front, rear: of the axles, rad outwards per m/s² of lateral acceleration; inwards when driving backwards.

    Raises:
        ModelError: when the robot's numbers do not suffice.
    """
    wheelbase, track = body.number("wheelbase"), body.number("track")
    places = {
        f"{axle}_{side}": (along, across)
        for axle, along in (("front", wheelbase), ("rear", 0.0))
        for side, across in (("left", track / 2), ("right", -track / 2))
    }

    def turn(model: Any, data: Any) -> None:
        forward = float(rotation(data)[:, 0] @ velocity(data))
        lateral = abs(forward) * float(rates(data)[2])
        angles = {wheel: float(data.joint(f"{wheel}_steer").qpos[0]) for wheel in places if wheel.startswith("front")}
        left = np.tan(angles["front_left"])
        steer = np.arctan(wheelbase * left / (wheelbase + track / 2 * left))
        aside = np.tan(rear * lateral)  # the turning centre is that part of the radius ahead of the rear axle
        curvature = (np.tan(steer - front * lateral) + aside) / wheelbase
        for wheel, (along, across) in places.items():
            wanted = np.arctan2(along * curvature - aside, 1.0 - across * curvature)
            half = (wanted - angles.get(wheel, 0.0)) / 2
            model.body(wheel).quat = [np.cos(half), 0.0, 0.0, np.sin(half)]

    return Change("", force=turn if front or rear else None)
