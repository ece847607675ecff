"""A measurement has the wrong sign: y → -y, a factor of -1; 1 is none."""

from sym2real.effects.kind import Kind, Parameter, of_any_body
from sym2real.effects.searching import SETTLED, Searching
from sym2real.effects.sensor_scale import multiplied, multiplying

SENSOR_SIGN = Kind(
    name="sensor_sign",
    stage="measurement",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=-1.0, high=1.0, scale=2.0, fitted=False)),
    formula=r"y_m = -y",
    summary="A sensor's axis points the other way.",
    confused_with="nothing, once the column is compared with the attitude's derivative",
    shown_by="any motion of that axis",
    fix="turn the sign in the log's specification, or the axis in the driver",
    inject=multiplying,
    substitute=multiplied,
    columns="state",
    searching=Searching(why_not=lambda _: SETTLED),
)
