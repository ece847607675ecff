"""A simulated car whose axles steer outwards as the chassis leans in turns (Gillespie, ch. 6).

An axle that turns by an angle per lateral acceleration leads the car as tyres do that slip by it. The four wheels keep
one turning centre, as a linkage would have them: else they fight each other, and some of them slide. What several
effects steer adds up in a number of the description, from which the wheels are turned.
"""

from typing import Any

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.truth import rates, rotation, velocity
from sym2real.protocols import Change

NUMBERS = "roll_steer"  # of the description: front and rear, rad per m/s²


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
        """Set the wheels' angles (rad) against the chassis, less what the steering joints have turned them."""
        outwards_front, outwards_rear = model.numeric(NUMBERS).data
        forward = float(rotation(data)[:, 0] @ velocity(data))
        lateral = abs(forward) * float(rates(data)[2])
        angles = {wheel: float(data.joint(f"{wheel}_steer").qpos[0]) for wheel in places if wheel.startswith("front")}
        left = np.tan(angles["front_left"])
        steer = np.arctan(wheelbase * left / (wheelbase + track / 2 * left))
        aside = np.tan(outwards_rear * lateral)  # the turning centre is that part of the radius ahead of the rear axle
        curvature = (np.tan(steer - outwards_front * lateral) + aside) / wheelbase
        for wheel, (along, across) in places.items():
            wanted = np.arctan2(along * curvature - aside, 1.0 - across * curvature)
            half = (wanted - angles.get(wheel, 0.0)) / 2
            model.body(wheel).quat = [np.cos(half), 0.0, 0.0, np.sin(half)]

    return Change("", edit=lambda spec: _add(spec, front, rear), force=turn)


def _add(spec: Any, front: float, rear: float) -> None:
    """Put angles to those of the effects before."""
    known = spec.numeric(NUMBERS)
    if known is None:
        spec.add_numeric(name=NUMBERS, size=2, data=[front, rear])
    else:
        known.data = [known.data[0] + front, known.data[1] + rear]
