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

COMMANDS = (GAIN, OFFSET, LIMIT, RATE_LIMIT, DELAY, LAG, DEAD_BAND)
THRUST = (ADDED_MASS, PAYLOAD, THRUST_CURVE, BATTERY_SAG, COM_OFFSET, ROTOR_LOSS, GROUND_EFFECT)
TURNING = (TORQUE_BIAS, TORQUE_SCALE, MOTOR_LAG, RATE_LOOP_GAIN, RATE_DAMPING, FLAPPING_MOMENT)
ROTORS = (TRANSLATIONAL_LIFT, ROTOR_REACTION)
TYRES = (TYRE_FRICTION, TYRE_SLIP, RELAXATION_LENGTH, UNDERSTEER, LATERAL_SLIP)
DRIVING = (ROLLING_RESISTANCE, SLOPE, WHEELBASE, YAW_DRAG)
JOINTS = (JOINT_DAMPING, JOINT_FRICTION, ARMATURE, GRAVITY_TILT, AT_SITE)
FORCES = (WIND, LINEAR_DRAG, QUADRATIC_DRAG, PERIODIC_FORCE)
SENSORS = (MOUNTING_TILT, YAW_BIAS, LEVER_ARM, SENSOR_SIGN, SENSOR_BIAS, SENSOR_SCALE, SENSOR_LAG, TIME_SHIFT)

# In the order of the catalogue.
_ALL = (*COMMANDS, *THRUST, *TURNING, *ROTORS, *TYRES, *DRIVING, *JOINTS, *FORCES, *SENSORS)
EFFECTS: Registry[Kind] = Registry("effect", {kind.name: kind for kind in _ALL})
