"""Whether a log's motor columns stand in the model's order, by what the equations say that motors do to the rates."""

from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.fault import Fault, Settled
from sym2real.diagnosis.faults.mistakes.transformation import Exchanged, of_all
from sym2real.effects.along_logs import from_row_to_row
from sym2real.effects.filters import spelled_out
from sym2real.effects.inputs import with_inputs
from sym2real.effects.visible import VisibleModel, visible_in_double
from sym2real.layout import motors_of
from sym2real.logs.agreement import RATES, VELOCITIES
from sym2real.logs.motor_order import ORDERS, MotorOrder, Turning, motor_order
from sym2real.logs.pose import turned
from sym2real.symbolic import Equations, compile_function
from sym2real.symbolic.expressions import names_in
from sym2real.symbolic.period import at_period
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import MOTOR_TORQUES, MOTORS, RATE, THRUST_COLUMN

# Of Newton's method for commands that turn the body the other way: its step, steps that thrust curves need, and what
# it may miss of the largest thrust and torques.
STEP, ROUNDS, MISSED = 1e-6, 8, 1e-6


def order_of_motors(model: Equations, data: Dataset) -> MotorOrder | None:
    """The order in which the columns fit the equations, where it is beyond doubt that it is another one."""
    state, action = model.layouts.state, model.layouts.action
    if motors_of(action) != MOTORS or not all(name in state for name in RATES):
        return None
    per_row = from_row_to_row(model, data)
    return None if per_row is None else motor_order([_turning(per_row[0], log) for log in per_row[1]])


def _turning(predict: VisibleModel, log: Trajectory) -> Turning:
    rates = log.state[:, log.layouts.state.indices(RATES)]
    return Turning(log.time, rates, _air(log), np.stack([_caused(predict, log, order) for order in ORDERS]))


def _air(log: Trajectory) -> Array:
    """Velocity along body axes ``# (rows, 3)``, as far as the log knows it."""
    layout = log.layouts.state
    if not layout.has_field("attitude") or not all(name in layout for name in VELOCITIES):
        return np.zeros((len(log), 0))
    return turned(log, VELOCITIES, to_world=False)


def _caused(predict: VisibleModel, log: Trajectory, order: tuple[int, ...]) -> Array:
    """Angular acceleration by the columns in this order, less that by four motors of one mean ``# (rows, 3)``."""
    place, rates = log.layouts.action.indices(MOTORS), log.layouts.state.indices(RATES)
    sent, alike = torch.as_tensor(log.action).clone(), torch.as_tensor(log.action).clone()
    sent[:, place] = sent[:, place][:, list(order)]
    alike[:, place] = alike[:, place].mean()
    state, inputs = torch.as_tensor(log.state), torch.as_tensor(log.step_inputs)
    return (predict(state, sent, inputs) - predict(state, alike, inputs))[:, rates].numpy() / log.dt


def turned_the_other_way(model: Equations, data: Dataset) -> Dataset | None:
    """The logs with motors that give the same thrust, roll and pitch, and the opposite of their yaw torque.

    None where the equations have no such torques, they follow from more than the motors, or motors would need a
    negative thrust.
    """
    wanted = (THRUST_COLUMN, *MOTOR_TORQUES)
    if not all(name in model.quantities for name in wanted):
        return None
    expressions = [spelled_out(model, model.quantities[name]) for name in wanted]
    if any(names_in(expression) - {*MOTORS} for expression in expressions):
        return None
    wrench_of = compile_function(expressions, [MOTORS])
    logs = [mirrored for log in data if (mirrored := _mirrored(wrench_of, log)) is not None]
    return Dataset(logs) if len(logs) == len(data) else None


def _mirrored(wrench_of: Callable[[Tensor], Tensor], log: Trajectory) -> Trajectory | None:
    """With motors whose thrust and torques are those of the log's with the last reversed; None without any."""
    sent = torch.as_tensor(log.action[:, log.layouts.action.indices(MOTORS)])
    goal = wrench_of(sent) * torch.tensor([1.0, 1.0, 1.0, -1.0], dtype=torch.float64)
    motors, steps = sent, STEP * torch.eye(4, dtype=torch.float64)
    for _ in range(ROUNDS):
        here = wrench_of(motors)
        slopes = (wrench_of(motors[:, None] + steps) - here[:, None]) / STEP  # (rows, motors, wrench)
        motors = motors + torch.linalg.solve_ex(slopes.mT, goal - here).result
    reached = bool(((wrench_of(motors) - goal).abs() <= MISSED * goal.abs().amax(0)).all())
    return log.with_columns(dict(zip(MOTORS, motors.numpy().T, strict=True))) if reached else None


def order_text(motor_order: MotorOrder) -> tuple[str, str]:
    """What shows another order, one clause, and what to change."""
    now, then = motor_order.as_it_stands, motor_order.correlation
    shown = f"how the rates change correlates with them by {then:.2f} then, by {now:.2f} as they stand"
    if not motor_order.certain:
        fix = "look up how the log counts its motors, or fly turns about all three axes; the logs stay as they are"
        return f"motor columns in another order than the model's; the log does not tell which ({shown} at best)", fix
    moved = motor_order.moved
    pairs = [f"{MOTORS[column]} acts as the model's {MOTORS[motor]}" for motor, column in moved.items()]
    wrong, right = (", ".join(MOTORS[place] for place in places) for places in (moved, moved.values()))
    fix = f"reorder them in the log's specification: let {wrong} read the columns that {right} read now"
    return f"motor columns in another order than the model's: {', '.join(pairs)} ({shown})", fix


def spin_text(model: Equations, data: Dataset) -> tuple[str, str]:
    """What a model says that has the rotors turn the wrong way, one clause, and what to change."""
    log = with_inputs(model.layouts.inputs, data)[0]
    place = log.layouts.action.indices(MOTORS)
    # Where all four turn: those that stand answer a square with nothing.
    row = int(log.action[:, place].min(1).argmax())
    state, sent, inputs = (torch.as_tensor(part[row]).repeat(4, 1) for part in (log.state, log.action, log.inputs))
    more = sent.clone()
    more[:, place] += STEP * torch.eye(4, dtype=torch.float64)
    predict = visible_in_double(at_period(model, data.dt))
    apart = predict(state, more, inputs) - predict(state, sent, inputs)
    signs = " ".join(f"{-sign:.0f}" for sign in apart[:, log.layouts.state.index(RATE.columns[2])].sign().tolist())
    fix = f"make the model with these rotors: `sym2real nominal quadrotor --interface motors --spin {signs} …`"
    return "rotors that turn the other way than the model says: yaw answers the motors with the opposite sign", fix


def motors(model: Equations, data: Dataset) -> Settled:
    """Motor columns in another order than the model's, and rotors that turn the other way."""
    order, faults = order_of_motors(model, data), []
    if order is None:
        return (), data
    if order.moved:
        faults.append(Fault("", *order_text(order)))
        if not order.certain:
            return faults, data
        data = of_all(Exchanged(tuple(MOTORS[column] for column in order.columns), MOTORS, (1, 1, 1, 1)), data)
    if order.reversed:
        faults.append(Fault("", *spin_text(model, data)))
        data = turned_the_other_way(model, data) or data
    return faults, data
