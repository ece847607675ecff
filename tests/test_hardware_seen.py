"""Which of the poses that a motion capture tells are believed."""

import numpy as np

from hardware.frame import Frame
from hardware.reach import AGREEING
from hardware.seen import SeenBody
from sym2real.trajectory import Array

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
PERIOD = 0.01


class Body(SeenBody):
    """Told by a test, a pose every 10 ms, each with the noise that every camera has."""

    def __init__(self) -> None:
        super().__init__(Frame())
        self.time, self._noise = 50.0, np.random.default_rng(0)

    def connect(self) -> None:
        """Nothing to open."""

    def close(self) -> None:
        """Nothing to close."""

    def see(self, *place: float, noise: float = 1e-4) -> Array:
        """The newest position, after it was told this one."""
        self.time += PERIOD
        self.tell(np.array(place) + noise * self._noise.standard_normal(3), UPRIGHT, self.time)
        pose = self.latest()
        assert pose is not None
        return pose.position


def test_a_place_out_of_reach_has_not_arrived() -> None:
    body = Body()
    for step in range(20):
        assert abs(body.see(0.02 * step, 0.0, 1.0)[0] - 0.02 * step) < 0.01, "2 m/s are in reach"
    before = body.latest()
    body.see(3.0, 0.0, 1.0)
    assert body.latest() is before
    assert abs(body.see(0.4, 0.0, 1.0)[0] - 0.4) < 0.01, "the next good one counts at once"
    for _ in range(10):
        assert body.see(3.0, 0.0, 1.0)[0] < 1.0, "a reflection that comes and goes never counts"
        body.see(0.4, 0.0, 1.0)


def test_a_body_that_was_put_elsewhere_is_believed_after_some_poses() -> None:
    body = Body()
    body.see(0.0, 0.0, 0.0)
    seen = [body.see(2.0, 0.0, 0.0)[0] > 1.0 for _ in range(AGREEING + 2)]
    assert seen == [False] * (AGREEING - 1) + [True] * 3
    pose = body.latest()
    assert pose is not None
    assert abs(pose.velocity[0]) < 0.1 or np.isnan(pose.velocity[0]), "it was carried, it did not fly"


def test_a_picture_that_stands_still_is_none_of_now() -> None:
    """Same place to the last bit, new stamps: a robot that believes it rises without end."""
    body = Body()
    body.see(0.3, 0.2, 1.0, noise=0.0)
    last = body.latest()
    for _ in range(30):
        body.see(0.3, 0.2, 1.0, noise=0.0)
    assert body.latest() is last
    body.see(0.3, 0.2, 1.0)
    assert body.latest() is not last
