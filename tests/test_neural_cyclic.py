"""Where the world's origin lies is nothing that a residual can learn from, unless the base has a place in it."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from tracked import tracked

from sym2real.dataset import Transitions
from sym2real.effects import effect
from sym2real.layout import Layout, Layouts
from sym2real.neural import Composed, Descent, Ensemble, ResidualMLP, ResidualTraining
from sym2real.neural.cyclic import cyclic_coordinates
from sym2real.neural.networks import Networks
from sym2real.neural.normal import Normal
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot
from sym2real.symbolic import symbol

SHORT = ResidualTraining(widths=(16,), steps=5, descent=Descent(steps=100))
SHIFT = (6.0, -3.0)  # m, along x and y
CHANGES = {CRAZYFLIE: ("added_mass", 0.007), MUSHR: ("offset:steer", 0.1)}


def logged(robot: Robot, rows: int = 200) -> Transitions:
    key, value = CHANGES[robot]
    return tracked(MujocoPlant(robot, (effect(key, robot).inject(value=value),)), rows=rows, seed=1)


def elsewhere(states: np.ndarray) -> np.ndarray:
    """The same motion in a world whose origin lies elsewhere; x and y come first."""
    return states + np.pad(SHIFT, (0, states.shape[-1] - 2))


@torch.no_grad()
def residual_at(model: Composed, states: np.ndarray, log: Transitions) -> torch.Tensor:
    rows, commands = (torch.tensor(values).float() for values in (states, log.action))
    found: torch.Tensor = model.residual(rows, commands)
    return found


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR])
def test_a_log_whose_world_is_shifted_teaches_the_same(robot: Robot) -> None:
    base, log = robot.nominal(), logged(robot)
    moved = replace(log, state=elsewhere(log.state), next_state=elsewhere(log.next_state))
    here, there = (SHORT.fit(rows, base) for rows in (log, moved))
    found = residual_at(here, log.state, log)
    assert float(found.abs().max()) > 0
    torch.testing.assert_close(residual_at(here, elsewhere(log.state), log), found, rtol=0, atol=0)
    size = float(found.abs().max())
    torch.testing.assert_close(residual_at(there, log.state, log), found, rtol=0, atol=1e-3 * size)


def test_what_an_earlier_result_knew_of_places_goes() -> None:
    base, log = MUSHR.nominal(), logged(MUSHR)
    start = SHORT.fit(log, base)
    with torch.no_grad():
        start.residual.linears[0].weight[:, :2] = 1.0
    assert not torch.equal(residual_at(start, elsewhere(log.state), log), residual_at(start, log.state, log))
    model = SHORT.fit(log, base, start)
    assert torch.equal(residual_at(model, elsewhere(log.state), log), residual_at(model, log.state, log))


def test_past_places_are_not_seen_either() -> None:
    log = logged(MUSHR)
    model = replace(SHORT, commands=2, states=2).fit(log, MUSHR.nominal())
    found = residual_at(model, log.state, log)  # the past is the present row, repeated
    assert float(found.abs().max()) > 0
    assert torch.equal(residual_at(model, elsewhere(log.state), log), found)


@pytest.mark.parametrize(("name", "expected"), [("crazyflie", ("x", "y")), ("mushr", ("x", "y")), ("cart_pole", ())])
def test_places_are_cyclic_and_joints_and_height_are_not(name: str, expected: tuple[str, ...]) -> None:
    assert cyclic_coordinates(ROBOTS[name].nominal()) == expected


def test_a_base_with_a_place_in_it_leaves_over_what_depends_on_it() -> None:
    base = MUSHR.nominal()
    uphill = replace(base, next={**base.next, "vx": base.next["vx"] - 0.01 * symbol("x")})
    pulled = replace(base, next={**base.next, "y": base.next["y"] - 0.01 * symbol("y")})
    assert cyclic_coordinates(uphill) == ("y",)
    assert cyclic_coordinates(pulled) == ("x",)
    named = replace(base, quantities={**base.quantities, "grade": symbol("x") * 0.01})
    through = replace(named, next={**base.next, "vx": base.next["vx"] - symbol("grade")})
    assert cyclic_coordinates(through) == ("y",)
    assert cyclic_coordinates(Ensemble(MUSHR.layouts, 1, (4,))) == ()


def test_a_field_is_scaled_by_the_columns_that_are_seen() -> None:
    layout = Layouts(Layout.of(["x", "y", "z", "vx"]), Layout.of(["thrust"]))
    raw = torch.tensor([[100.0, -50.0, 3.0, 1.0, 0.2], [90.0, 60.0, -3.0, 2.0, 0.4]])
    normal = Normal.of(raw, [layout.state, layout.action], torch.ones(4), ("x", "y"))
    assert normal.kept.tolist() == [2, 3, 4]
    assert float(normal.scale[0]) == pytest.approx(3.0)
    torch.testing.assert_close(normal(raw)[:, 0], torch.tensor([1.0, -1.0]))


def test_weights_go_to_normalised_columns_and_back() -> None:
    """Of columns that are not seen nothing is left: the function is that of zeros in their place."""
    log, first, again = logged(MUSHR, 60), ResidualMLP(MUSHR.layouts, (8,), seed=2), ResidualMLP(MUSHR.layouts, (8,))
    with torch.no_grad():
        first.linears[-1].weight.normal_(generator=torch.Generator().manual_seed(1))
    state, action = (torch.tensor(values).float() for values in (log.state, log.action))
    layouts, size = [MUSHR.layouts.state, MUSHR.layouts.action], len(MUSHR.layouts.state)
    normal = Normal.of(torch.cat([state, action], dim=-1), layouts, torch.full((size,), 0.01), ("x", "y"))
    networks = Networks((len(normal.mean), 8, size), 1)
    normal.begin_with(networks, first.layers(), torch.arange(networks.count))
    normal.write([(weight[0], bias[0, 0]) for weight, bias in networks.pairs()], again, torch.ones(size).bool())
    without = state * torch.tensor([0.0, 0.0, *[1.0] * (size - 2)])
    with torch.no_grad():
        torch.testing.assert_close(again(state, action), first(without, action), rtol=1e-4, atol=1e-5)
