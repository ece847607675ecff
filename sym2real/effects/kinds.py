"""The registry: every kind of effect by its name. A new one is its file and its line here."""

from __future__ import annotations

from sym2real.effects.added_mass import ADDED_MASS
from sym2real.effects.armature import ARMATURE
from sym2real.effects.battery_sag import BATTERY_SAG
from sym2real.effects.com_offset import COM_OFFSET
from sym2real.effects.dead_band import DEAD_BAND
from sym2real.effects.delay import DELAY
from sym2real.effects.flapping_moment import FLAPPING_MOMENT
from sym2real.effects.gain import GAIN
from sym2real.effects.gravity_tilt import GRAVITY_TILT
from sym2real.effects.ground_effect import GROUND_EFFECT
from sym2real.effects.joint_damping import JOINT_DAMPING
from sym2real.effects.joint_friction import JOINT_FRICTION
from sym2real.effects.kind import Kind
from sym2real.effects.lag import LAG
from sym2real.effects.lateral_slip import LATERAL_SLIP
from sym2real.effects.lever_arm import LEVER_ARM
from sym2real.effects.limit import LIMIT
from sym2real.effects.linear_drag import LINEAR_DRAG
from sym2real.effects.load import AT_SITE
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
from sym2real.registry import Registry

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
        "joint_damping": JOINT_DAMPING,
        "joint_friction": JOINT_FRICTION,
        "armature": ARMATURE,
        "gravity_tilt": GRAVITY_TILT,
        "load": AT_SITE,
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
