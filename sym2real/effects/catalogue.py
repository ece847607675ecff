"""All effects by name: the registry, the way from a key to an effect, and what applies to given equations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fnmatch import fnmatch

from sym2real.effects.added_mass import ADDED_MASS
from sym2real.effects.battery_sag import BATTERY_SAG
from sym2real.effects.body import Body, Describable
from sym2real.effects.com_offset import COM_OFFSET
from sym2real.effects.dead_band import DEAD_BAND
from sym2real.effects.delay import DELAY
from sym2real.effects.effect import Effect
from sym2real.effects.flapping_moment import FLAPPING_MOMENT
from sym2real.effects.gain import GAIN
from sym2real.effects.ground_effect import GROUND_EFFECT
from sym2real.effects.groups import equivalents
from sym2real.effects.kind import Kind
from sym2real.effects.lag import LAG
from sym2real.effects.lateral_slip import LATERAL_SLIP
from sym2real.effects.lever_arm import LEVER_ARM
from sym2real.effects.limit import LIMIT
from sym2real.effects.linear_drag import LINEAR_DRAG
from sym2real.effects.motor_lag import MOTOR_LAG
from sym2real.effects.mounting_tilt import MOUNTING_TILT
from sym2real.effects.offset import OFFSET
from sym2real.effects.payload import PAYLOAD
from sym2real.effects.periodic_force import PERIODIC_FORCE
from sym2real.effects.quadratic_drag import QUADRATIC_DRAG
from sym2real.effects.rate_damping import RATE_DAMPING
from sym2real.effects.rate_limit import RATE_LIMIT
from sym2real.effects.rate_loop_gain import RATE_LOOP_GAIN
from sym2real.effects.relaxation_length import RELAXATION_LENGTH
from sym2real.effects.rolling_resistance import ROLLING_RESISTANCE
from sym2real.effects.rotor_loss import ROTOR_LOSS
from sym2real.effects.rotor_reaction import ROTOR_REACTION
from sym2real.effects.sensor_bias import SENSOR_BIAS
from sym2real.effects.sensor_lag import SENSOR_LAG
from sym2real.effects.sensor_scale import SENSOR_SCALE
from sym2real.effects.sensor_sign import SENSOR_SIGN
from sym2real.effects.slope import SLOPE
from sym2real.effects.thrust_curve import THRUST_CURVE
from sym2real.effects.time_shift import TIME_SHIFT
from sym2real.effects.torque_bias import TORQUE_BIAS
from sym2real.effects.torque_scale import TORQUE_SCALE
from sym2real.effects.translational_lift import TRANSLATIONAL_LIFT
from sym2real.effects.tyre_friction import TYRE_FRICTION
from sym2real.effects.tyre_slip import TYRE_SLIP
from sym2real.effects.understeer import UNDERSTEER
from sym2real.effects.wheelbase import WHEELBASE
from sym2real.effects.wind import WIND
from sym2real.effects.yaw_bias import YAW_BIAS
from sym2real.effects.yaw_drag import YAW_DRAG
from sym2real.errors import UnknownNameError
from sym2real.registry import Registry
from sym2real.symbolic import Equations

EFFECTS: Registry[Kind] = Registry(
    "effect",
    {
        "gain": GAIN,
        "offset": OFFSET,
        "limit": LIMIT,
        "rate_limit": RATE_LIMIT,
        "delay": DELAY,
        "lag": LAG,
        "dead_band": DEAD_BAND,
        "added_mass": ADDED_MASS,
        "payload": PAYLOAD,
        "thrust_curve": THRUST_CURVE,
        "battery_sag": BATTERY_SAG,
        "com_offset": COM_OFFSET,
        "rotor_loss": ROTOR_LOSS,
        "ground_effect": GROUND_EFFECT,
        "torque_bias": TORQUE_BIAS,
        "torque_scale": TORQUE_SCALE,
        "motor_lag": MOTOR_LAG,
        "rate_loop_gain": RATE_LOOP_GAIN,
        "rate_damping": RATE_DAMPING,
        "flapping_moment": FLAPPING_MOMENT,
        "translational_lift": TRANSLATIONAL_LIFT,
        "rotor_reaction": ROTOR_REACTION,
        "tyre_friction": TYRE_FRICTION,
        "tyre_slip": TYRE_SLIP,
        "relaxation_length": RELAXATION_LENGTH,
        "understeer": UNDERSTEER,
        "lateral_slip": LATERAL_SLIP,
        "rolling_resistance": ROLLING_RESISTANCE,
        "slope": SLOPE,
        "wheelbase": WHEELBASE,
        "yaw_drag": YAW_DRAG,
        "wind": WIND,
        "linear_drag": LINEAR_DRAG,
        "quadratic_drag": QUADRATIC_DRAG,
        "periodic_force": PERIODIC_FORCE,
        "mounting_tilt": MOUNTING_TILT,
        "yaw_bias": YAW_BIAS,
        "lever_arm": LEVER_ARM,
        "sensor_sign": SENSOR_SIGN,
        "sensor_bias": SENSOR_BIAS,
        "sensor_scale": SENSOR_SCALE,
        "sensor_lag": SENSOR_LAG,
        "time_shift": TIME_SHIFT,
    },
)


def effect(key: str, described: Describable) -> Effect:
    """The effect of a key, ``kind`` or ``kind:column``.

    Args:
        key: as a user types it.
        described: the robot or equations that it is for.

    Raises:
        UnknownNameError: for a kind that does not exist, a column that the kind does not have, or one that is missing.
    """
    name, colon, column = key.partition(":")
    kind = EFFECTS[name]
    columns = columns_of(kind, described)
    bound = colon or (columns and kind.column_needed)
    if bound and column not in columns:
        raise UnknownNameError("effect", key, [f"{name}:{known}" for known in columns] or [name])
    body = Body.of(described, column)
    return Effect(kind, body, tuple(one for one in equivalents(key) if EFFECTS[one.partition(":")[0]].fits(body)))


def known(equations: Equations) -> Iterator[Effect]:
    """Every effect of such a robot, one per column where a kind has columns, whether the equations can be given it."""
    body = Body.of(equations)
    for name, kind in EFFECTS.items():
        columns = columns_of(kind, equations)
        keys = [f"{name}:{column}" for column in columns]
        if not kind.columns or (columns and not kind.column_needed):
            keys.insert(0, name)
        yield from (effect(key, equations) for key in keys if kind.fits(body))


def applicable(equations: Equations) -> tuple[Effect, ...]:
    """Every effect that the equations can be given."""
    return tuple(one for one in known(equations) if one.applies(equations))


def require_patterns(patterns: Iterable[str]) -> None:
    """Refuse keys, or patterns of keys, that no effect can match.

    Raises:
        UnknownNameError: for a kind that does not exist, or one that needs a column.
    """
    for pattern in patterns:
        name = pattern.partition(":")[0]
        matching = [kind for kind in EFFECTS.values() if fnmatch(kind.name, name)]
        if not matching:
            raise UnknownNameError("effect", pattern, EFFECTS)
        if pattern == name and all(kind.columns and kind.column_needed for kind in matching) and "*" not in pattern:
            raise UnknownNameError("effect", pattern, [f"{pattern}:*", f"{pattern}:COLUMN"])


def columns_of(kind: Kind, described: Describable) -> tuple[str, ...]:
    """Columns that an effect of this kind may be on, for a robot or equations; none where it has no column."""
    if kind.columns == "action":
        derived = ("thrust",) if "thrust" in getattr(described, "quantities", ()) and kind.substitute else ()
        return (*described.layouts.action, *derived)
    if kind.columns == "state":
        fields = described.layouts.state.fields
        return tuple(column for field in fields if not field.hidden for column in field.columns)
    return ()
