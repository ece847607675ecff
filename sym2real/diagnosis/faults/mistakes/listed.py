"""The transformations that logs are held against: every kind that their columns allow, as the balance asks for it.

Of a kind with many members (orders and signs of components, an angle) the balance proposes the one that fits best;
whether it is there is judged elsewhere, for all kinds alike.
"""

from collections.abc import Iterator, Sequence
from itertools import chain, combinations, permutations, product

import numpy as np
from scipy.optimize import linear_sum_assignment

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import present
from sym2real.diagnosis.faults.misread_attitudes import COMMANDED, FROM_WORLD, OfAttitude, orders_of
from sym2real.diagnosis.faults.mistakes.balance import SHIFTED, Balance
from sym2real.diagnosis.faults.mistakes.transformation import Exchanged, Late, OtherAxes, Transformation, Turned
from sym2real.diagnosis.faults.sensor_readings import measured_by, rates_of
from sym2real.diagnosis.settings import SETTINGS
from sym2real.layout import Layout, motors_of
from sym2real.logs.agreement import RATES, VELOCITIES
from sym2real.logs.course import between, courses, headings
from sym2real.trajectory import Array
from sym2real.vocabulary import ATTITUDE, EULER_ANGLES, HEADING, POSITION, RATE_COMMAND

TILTED = ("level velocity", "attitude about x", "attitude about y")  # what roll and pitch change
SHIFTS = range(2, SHIFTED + 1)  # rows; honest sensors are up to one behind, and none reports what is still to come
PLACE_SHIFTS = (*range(2, 13), 14, 16, 18, 20, 23, 26)  # a receiver's are tenths of a second
Vectors = Sequence[tuple[str, ...]]  # columns of vectors whose components are exchanged alike


def transformations(data: Dataset, balance: Balance) -> Iterator[Transformation]:
    """What may have been done to these logs, the simplest first."""
    yield from _axes(data)
    for field in ("position", "velocity", "attitude", "heading"):
        yield from _turned(data, balance, field)
    position, velocity = present(data, POSITION.columns), present(data, VELOCITIES)
    rates, commands = present(data, RATES), present(data, RATE_COMMAND.columns)
    yield from _exchanged(balance, "position", (position,), of_measured=True)
    yield from _exchanged(balance, "position", (velocity,), of_measured=False)
    if len(position) == len(velocity):
        yield from _exchanged(balance, "velocity", (position, velocity), of_measured=True)
    if present(data, HEADING.columns) == HEADING.columns:
        yield from _orders((HEADING.columns,))
    yield from _exchanged(balance, "attitude", (rates,), of_measured=False)
    if len(commands) == len(rates) == 3:
        yield from _in_common(_followed(data, rates, commands), (commands,))
    elif not motors_of(data.layouts.action):  # whose order and spin have a look of their own
        yield from _swapped((_single_columns(data.layouts.action),))
    yield from _of_attitudes(data, balance)
    yield from _of_joints(data, balance)
    # What has rates is late against these, to parts of a row (``late_pose.py``).
    with_rates = {name for of in rates_of(data).values() for name in measured_by(data.layouts.state, of)[1]}
    for sensor in (sensor for sensor in data.layouts.state.fields if not with_rates.issuperset(sensor.columns)):
        yield from (Late(sensor.name, sensor.columns, rows, data.dt) for rows in SHIFTS)
    # As satellite receivers give them, beside an attitude of the robot's own: its thrust says when. Of a car an arm, or
    # tyres that slip, do as much.
    if len(position) == len(velocity) == 3 and present(data, ATTITUDE.columns) == ATTITUDE.columns:
        yield from (Late("place", (*position, *velocity), rows, data.dt) for rows in PLACE_SHIFTS)


def mimics(transformation: Transformation, commands: Sequence[str]) -> Iterator[Transformation]:
    """What no mistake is and may explain as much: a sensor's filter, and commands that take effect later."""
    if isinstance(transformation, Late):
        yield from (Late(transformation.what, transformation.columns, rows, transformation.dt) for rows in (-1, 1))
        yield Late("commands", tuple(commands), -abs(transformation.rows), transformation.dt)


def _axes(data: Dataset) -> Iterator[Transformation]:
    velocity, rates = present(data, VELOCITIES), present(data, RATES)
    attitude = present(data, ATTITUDE.columns) == ATTITUDE.columns
    if velocity and (attitude or present(data, HEADING.columns) == HEADING.columns):
        yield OtherAxes(velocity, "body")
    if attitude:
        yield FROM_WORLD
        if rates == RATES:
            yield OtherAxes(rates, "world")


def _of_joints(data: Dataset, balance: Balance) -> Iterator[Exchanged]:
    """Joints and commands that count the other way, and joints of one kind in another order."""
    state, commands = data.layouts.state, data.layouts.action.columns
    alone = () if motors_of(data.layouts.action) else _single_columns(data.layouts.action)
    counted = [(joint, state.rates[joint]) for joint in state.joints]
    driven = zip(counted, commands, strict=True) if len(commands) == len(counted) else ()
    together = [(*joint, command) for joint, command in driven if command in alone]
    for columns in (*counted, *((command,) for command in alone), *together):
        yield Exchanged(columns, columns, (-1,) * len(columns))
    for field in state.fields:
        joints = tuple(name for name in field.columns if name in state.joints)
        if len(joints) < 2:
            continue
        rates = tuple(state.rates[joint] for joint in joints)
        yield from _swapped((joints, rates))
        moved, turned = _alike(balance, joints), _alike(balance, rates)
        yield from _in_common(turned, (joints, rates))
        yield from _in_common(moved, (joints,))
        yield from _in_common(moved.T, (rates,))
        if len(commands) == len(joints):
            yield from _in_common(turned.T, (commands,))


def _single_columns(layout: Layout) -> tuple[str, ...]:
    """The columns that may be taken for another: a quaternion's are none by themselves."""
    return tuple(name for field in layout.fields if field.kind == "vector" for name in field.columns)


def _of_attitudes(data: Dataset, balance: Balance) -> Iterator[Transformation]:
    """Roll and pitch in every order and sign, of what was measured or commanded, where that is badly predicted.

    Of what was commanded also the scalar elsewhere; of what was measured the rates have told that.
    """
    losses = dict(zip(balance.names, balance.losses.mean(0), strict=True))
    if max(losses.get(name, 0.0) for name in TILTED) <= SETTINGS.mostly:
        return
    for ending in ("", COMMANDED):
        quaternion = tuple(f"{name}{ending}" for name in ATTITUDE.columns)
        if present(data, quaternion) == quaternion:
            for order in _orders((tuple(f"{angle}{ending}" for angle in EULER_ANGLES[:2]),)):
                yield OfAttitude(order.columns, order.sources, order.signs, quaternion)
            yield from orders_of(ending) if ending else ()


def _swapped(vectors: Vectors) -> Iterator[Exchanged]:
    """Two components in each other's place, in several vectors alike."""
    for pairs in zip(*(combinations(vector, 2) for vector in vectors), strict=True):
        yield _in_order(pairs, (1, 0), (1, 1))


def _alike(balance: Balance, columns: Sequence[str]) -> Array:
    """Correlation of the measured change of every column with the change that is predicted of each ``# (n, n)``."""
    measured, predicted = balance.of_quantities([balance.names.index(column) for column in columns])
    return np.asarray(np.nan_to_num(np.corrcoef(measured.T, predicted.T)[: len(columns), len(columns) :]))


def _exchanged(balance: Balance, field: str, vectors: Vectors, *, of_measured: bool) -> Iterator[Exchanged]:
    """The order and signs of a vector's components by which a field's two changes have most in common."""
    measured, predicted = balance.of_field(field)
    if len(vectors[0]) < 3:
        yield from _orders(vectors)
    elif len(vectors[0]) == measured.shape[1] == 3:
        yield from _in_common(measured.T @ predicted if of_measured else predicted.T @ measured, vectors)


def _followed(data: Dataset, rates: Sequence[str], commands: Sequence[str]) -> Array:
    """What rate commands have in common with the rates a row later ``# (3, 3)``."""
    sent = [log.action[:-1, log.layouts.action.indices(commands)] for log in data]
    answered = [log.state[1:, log.layouts.state.indices(rates)] for log in data]
    centred = [np.concatenate([part - part.mean(0) for part in parts]) for parts in (sent, answered)]
    return np.asarray(centred[0].T @ centred[1])


def _in_common(common: Array, vectors: Vectors) -> Iterator[Exchanged]:
    """The exchange by which most is in common; ``common`` is of what a column holds and what it may mean."""
    common = np.nan_to_num(common)  # of a model that predicts no number
    rows, places = linear_sum_assignment(np.abs(common), maximize=True)
    signs = np.where(common[rows, places] < 0, -1, 1)
    if (places != rows).any() or (signs < 0).any():
        yield _in_order(vectors, places.tolist(), signs.tolist())


def _orders(vectors: Vectors) -> Iterator[Exchanged]:
    """Every order and all signs of components, the same in several vectors, but for the right ones."""
    size = len(vectors[0])
    for order in permutations(range(size)):
        for signs in product((1, -1), repeat=size):
            if order != tuple(range(size)) or min(signs, default=1) < 0:
                yield _in_order(vectors, order, signs)


def _in_order(vectors: Vectors, order: Sequence[int], signs: Sequence[int]) -> Exchanged:
    """Components that hold those in another order, with these signs, the same in several vectors."""
    sources = tuple(vector[place] for vector in vectors for place in order)
    return Exchanged(tuple(chain(*vectors)), sources, tuple(signs) * len(vectors))


def _turned(data: Dataset, balance: Balance, field: str) -> Iterator[Turned]:
    """A frame that is turned about the vertical, by the angle that fits best."""
    if not data.layouts.state.has_field(field):
        return
    # From the way a car moves to where it says that it points.
    angle = -between(courses(data), headings(data)) if field == "heading" else _of_vectors(data, balance, field)
    if abs(angle) > SETTINGS.frame_turn:
        yield Turned(field, angle)


def _of_vectors(data: Dataset, balance: Balance, field: str) -> float:
    """Attitude turns thrust and with it the velocity that is predicted, velocity moves the position."""
    level = np.array([1.0, 1.0j])
    if field == "attitude":
        measured, predicted = (part[:, :2] @ level for part in balance.of_field("velocity"))
        return -float(np.angle(np.vdot(predicted, measured)))
    if present(data, ("x", "y", "vx", "vy")) != ("x", "y", "vx", "vy"):
        return 0.0
    way = np.concatenate([np.diff(log.state[:, log.layouts.state.indices(("x", "y"))], axis=0) @ level for log in data])
    pace = np.concatenate([log.state[:-1, log.layouts.state.indices(("vx", "vy"))] @ level for log in data])
    angle = float(np.angle(np.vdot(pace, way)))
    return angle if field == "position" else -angle
