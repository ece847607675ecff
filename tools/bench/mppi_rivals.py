"""The same plan by other libraries: pytorch-mppi (with our module and with sympytorch's) and JAX.

Each function returns one step as a callable without arguments, and the rollout that it plans with, for comparison:
``# (N, state), (N, H, action)`` → ``# (N, H, state)``.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytorch_mppi
import sympy
import torch
from mppi_models import HORIZON, Subject
from torch import Tensor, nn

from sym2real.neural import Composed
from sym2real.symbolic import compile_function, symbol
from sym2real.symbolic.compile import build_function

Step = Callable[[], object]
Rollout = Callable[[Tensor, Tensor], Tensor]


def stepped(dynamics: Callable[[Tensor, Tensor], Tensor]) -> Rollout:
    """Rollout of a step function."""

    def roll(state: Tensor, actions: Tensor) -> Tensor:
        states = []
        for action in actions.unbind(1):
            state = dynamics(state, action)
            states.append(state)
        return torch.stack(states, dim=1)

    return roll


def with_pytorch_mppi(
    subject: Subject,
    dynamics: Callable[[Tensor, Tensor], Tensor],
    samples: int,
    *,
    compiled: bool = False,
    past: int = 0,
    device: str = "cpu",
) -> Step:
    """One ``command`` of pytorch-mppi with these dynamics and the task's cost; states end in so many past commands."""
    robot, settings = subject.robot, subject.robot.mppi
    cost, goal = _cost(subject, compiled), subject.task.reference(torch.zeros(1)).float().to(device)
    size = len(robot.layouts.state)

    def here(values: object) -> Tensor:
        return torch.as_tensor(values, dtype=torch.float32, device=device)

    planner = pytorch_mppi.MPPI(
        dynamics,
        lambda state, action: cost(state[..., :size], action, goal)[..., 0],
        size + past * len(robot.layouts.action),
        torch.diag(here(settings.noise) ** 2),
        num_samples=samples,
        horizon=HORIZON,
        device=device,
        lambda_=settings.temperature,
        u_min=here(robot.low),
        u_max=here(robot.high),
        U_init=here(robot.rest).repeat(HORIZON, 1),
    )
    if compiled:
        planner.compile()
    start = torch.cat([here(subject.start), here(robot.rest).repeat(past)])
    return lambda: planner.command(start).tolist()


def remembering(model: Composed, subject: Subject) -> Callable[[Tensor, Tensor], Tensor]:
    """A model that sees past commands as dynamics for others: they go along in the state, newest first."""
    size, actions = len(subject.robot.layouts.state), len(subject.robot.layouts.action)

    def dynamics(state: Tensor, action: Tensor) -> Tensor:
        past = state[..., size:]
        following = model(state[..., :size], action, past=past)
        return torch.cat([following, action, past[..., :-actions]], dim=-1)

    return dynamics


def _cost(subject: Subject, plain: bool) -> nn.Module:
    """The task's cost, scripted or as torch.compile can see through it."""
    state, action = subject.robot.layouts.state.columns, subject.robot.layouts.action.columns
    arguments = [state, action, [f"ref_{column}" for column in state]]
    return (build_function if plain else compile_function)([subject.task.cost], arguments)


def sympytorch_dynamics(subject: Subject) -> Callable[[Tensor, Tensor], Tensor]:
    """The equations as a sympytorch module."""
    import sympytorch

    layouts = subject.equations.layouts
    module = sympytorch.SymPyModule(expressions=list(subject.equations.next.values()))
    names = (*layouts.state, *layouts.action)

    def dynamics(state: Tensor, action: Tensor) -> Tensor:
        columns = torch.cat([state, action], dim=-1).unbind(-1)
        return layouts.state.normalise(module(**dict(zip(names, columns, strict=True))))

    return dynamics


def with_jax(subject: Subject, samples: int, ensemble: Any = None) -> tuple[Step, Rollout]:
    """The whole step as one jitted function with ``lax.scan`` over the horizon, noise and weights included."""
    import jax
    import jax.numpy as jnp

    robot, settings = subject.robot, subject.robot.mppi
    dynamics = _jax_network(subject, ensemble) if ensemble is not None else _jax_equations(subject)
    cost = _jax_cost(subject)
    low, high = jnp.asarray(robot.low, jnp.float32), jnp.asarray(robot.high, jnp.float32)
    scale = jnp.asarray(settings.noise, jnp.float32)

    def roll(start: Any, actions: Any) -> Any:  # (N, state), (H, N, action)
        def one(state: Any, action: Any) -> Any:
            following = dynamics(state, action)
            return following, following

        return jax.lax.scan(one, start, actions)[1]

    def plan(key: Any, mean: Any, start: Any) -> Any:
        noise = jax.random.normal(key, (HORIZON, samples, len(scale))) * scale
        actions = jnp.clip(mean[:, None] + noise.at[:, 0].set(0.0), low, high)

        def one(carried: Any, action: Any) -> Any:
            state, total = carried
            following = dynamics(state, action)
            return (following, total + cost(following, action)), None

        (_, costs), _ = jax.lax.scan(one, (start, jnp.zeros(samples)), actions)
        return jnp.einsum("n,hna->ha", jax.nn.softmax(-costs / settings.temperature), actions)

    jitted, jitted_roll = jax.jit(plan), jax.jit(roll)
    start = jnp.broadcast_to(jnp.asarray(subject.start, jnp.float32), (samples, len(subject.start)))
    mean, keys = jnp.tile(jnp.asarray(robot.rest, jnp.float32), (HORIZON, 1)), iter(range(1 << 30))

    def step() -> object:
        return jitted(jax.random.key(next(keys)), mean, start).block_until_ready()

    def rollout(state: Tensor, actions: Tensor) -> Tensor:
        states = jitted_roll(jnp.asarray(state.numpy()), jnp.asarray(actions.numpy()).swapaxes(0, 1))
        return torch.from_numpy(np.array(states.swapaxes(0, 1)))

    return step, rollout


def _jax_equations(subject: Subject) -> Callable[[Any, Any], Any]:
    import jax.numpy as jnp

    layouts = subject.equations.layouts
    names = [*layouts.state, *layouts.action]
    function = sympy.lambdify([symbol(n) for n in names], list(subject.equations.next.values()), "jax", cse=True)

    def dynamics(state: Any, action: Any) -> Any:
        columns = [*jnp.moveaxis(state, -1, 0), *jnp.moveaxis(action, -1, 0)]
        return _jax_normalised(subject, function(*columns))

    return dynamics


def _jax_normalised(subject: Subject, columns: list[Any]) -> Any:
    import jax.numpy as jnp

    parts, place = [], 0
    for field in subject.equations.layouts.state.fields:
        values = columns[place : place + len(field.columns)]
        place += len(field.columns)
        if field.kind != "vector":
            length = jnp.sqrt(sum(value**2 for value in values))
            values = [value / length for value in values]
        parts += values
    return jnp.stack(jnp.broadcast_arrays(*parts), axis=-1)


def _jax_network(subject: Subject, ensemble: Any) -> Callable[[Any, Any], Any]:
    import jax
    import jax.numpy as jnp

    layers = [(jnp.asarray(w.detach().numpy()), jnp.asarray(b.detach().numpy())) for w, b in ensemble.networks.pairs()]

    def dynamics(state: Any, action: Any) -> Any:
        values = jnp.concatenate([state, action], axis=-1)[None]
        for place, (weight, bias) in enumerate(layers):
            values = (jax.nn.relu(values) if place else values) @ weight + bias
        following = state + values.mean(axis=0)
        return _jax_normalised(subject, list(jnp.moveaxis(following, -1, 0)))

    return dynamics


def _jax_cost(subject: Subject) -> Callable[[Any, Any], Any]:
    import jax.numpy as jnp

    layouts = subject.robot.layouts
    goal = subject.task.reference(torch.zeros(1))[0].tolist()
    names = [*layouts.state, *layouts.action]
    fixed = {symbol(f"ref_{column}"): value for column, value in zip(layouts.state, goal, strict=True)}
    function = sympy.lambdify([symbol(name) for name in names], subject.task.cost.subs(fixed), "jax", cse=True)
    return lambda state, action: function(*jnp.moveaxis(state, -1, 0), *jnp.moveaxis(action, -1, 0))
