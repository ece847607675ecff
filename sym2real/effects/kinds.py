"""The registry: every kind of effect by its name. A new one stands in one of these files, or in one more."""

from sym2real.effects.kind import Kind
from sym2real.registry import Registry

# Files, and the kinds in each, in the order of the catalogue.
FILES = {
    "commands": ("gain", "offset", "limit"),
    "actuators": ("rate_limit", "delay", "lag", "dead_band", "dead_zone"),
    "attitude_commands": ("attitude_trim", "attitude_gain"),
    "curves": ("steering_curve", "speed_curve", "steering_asymmetry", "speed_asymmetry"),
    "thrusts": (
        *("added_mass", "thrust_curve", "battery_sag"),
        *("com_offset", "rotor_loss", "ground_effect"),
    ),
    "payload": ("payload",),
    "motors": ("torque_bias", "torque_scale", "motor_lag"),
    "loops": ("rate_loop_gain", "attitude_loop", "speed_loop", "rate_damping"),
    "inertia": ("inertia_axes",),
    "blades": ("flapping_moment", "translational_lift", "rotor_reaction"),
    "tyres": ("tyre_friction", "tyre_slip", "relaxation_length", "yaw_inertia", "understeer", "lateral_slip"),
    "driving": (
        *("rolling_resistance", "turning_friction", "wheel_radius", "track_width"),
        *("wheel_grip", "carried_mass", "slope", "wheelbase", "yaw_drag"),
    ),
    "joints": (
        *("joint_damping", "joint_friction", "joint_stiffness", "armature", "link_mass"),
        *("servo_gain", "gravity_tilt", "load"),
    ),
    "joint_forces": ("joint_drag", "joint_bias", "torque_ripple", "stribeck", "servo_limit"),
    "links": ("link_centre", "link_inertia", "link_length"),
    "forces": ("wind", "linear_drag", "quadratic_drag", "periodic_force"),
    "mountings": ("mounting_tilt", "marker_tilt", "mounting_yaw", "yaw_bias", "lever_arm"),
    "readings": ("sensor_sign", "sensor_bias", "sensor_scale", "sensor_lag", "time_shift"),
    "parameter": ("parameter",),
}
EFFECTS: Registry[Kind] = Registry(
    "effect",
    {},
    {name: f"sym2real.effects.{file}:{name.upper()}" for file, names in FILES.items() for name in names},
)
