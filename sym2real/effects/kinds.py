"""The registry: every kind of effect by its name. A new one is a file of that name, and the name here."""

from sym2real.effects.kind import Kind
from sym2real.registry import Registry

COMMANDS = ("gain", "offset", "limit", "rate_limit", "delay", "lag", "dead_band", "attitude_trim", "steering_curve")
THRUST = ("added_mass", "payload", "thrust_curve", "battery_sag", "com_offset", "rotor_loss", "ground_effect")
TURNING = (
    *("torque_bias", "torque_scale", "motor_lag", "rate_loop_gain", "attitude_loop", "rate_damping"),
    "flapping_moment",
)
ROTORS = ("translational_lift", "rotor_reaction")
TYRES = ("tyre_friction", "tyre_slip", "relaxation_length", "understeer", "lateral_slip")
DRIVING = ("rolling_resistance", "turning_friction", "wheel_radius", "track_width", "slope", "wheelbase", "yaw_drag")
JOINTS = ("joint_damping", "joint_friction", "joint_stiffness", "armature", "gravity_tilt", "load")
FORCES = ("wind", "linear_drag", "quadratic_drag", "periodic_force")
SENSORS = (
    *("mounting_tilt", "yaw_bias", "lever_arm", "sensor_sign"),
    *("sensor_bias", "sensor_scale", "sensor_lag", "time_shift"),
)
OWN = ("parameter",)

# In the order of the catalogue.
_ALL = (*COMMANDS, *THRUST, *TURNING, *ROTORS, *TYRES, *DRIVING, *JOINTS, *FORCES, *SENSORS, *OWN)
EFFECTS: Registry[Kind] = Registry("effect", {}, {name: f"sym2real.effects.{name}:{name.upper()}" for name in _ALL})
