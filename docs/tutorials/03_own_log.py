"""# A log of your own: CSV, ULog, bag, data frame

Any log becomes a model's columns by a specification, a small TOML file. `inspect` proposes one. Here the log is the
real flight that comes with the package; put the path of yours in its place.

    python docs/tutorials/03_own_log.py
"""

from pathlib import Path

import pandas as pd

from sym2real import Trajectory, compare, example_flight, inspect_logs, quadrotor, read_log
from sym2real.robots import Motors, fit_thrust_per_unit

# What do its columns seem to hold? Every row of the answer has its evidence. Nothing is applied that is only suspected:
# read the proposal, then correct it by hand.

proposal = inspect_logs(example_flight())
for row in proposal.rows[:6]:
    print(f"{row.column:>8}  {row.meaning}: {row.evidence}")
Path("flight.toml").write_text(proposal.toml(), encoding="utf-8")

# This flight has the commands of four motors and a measured attitude. The model that fits is of first principles at
# motor level; its thrust per unit of command is fitted to the first two seconds. Without a mass everything is per
# kilogram.

columns = quadrotor(interface="motors", attitude="measured")
log = read_log(example_flight(), "flight.toml", columns.layouts, columns.dt)
motors = Motors(thrust=fit_thrust_per_unit(log))
model = quadrotor(interface="motors", attitude="measured", motors=motors)
print(compare(model, log))

# A data frame is a log too, by the same specification, and a log is a data frame.

again = Trajectory.from_pandas(pd.read_csv(example_flight()), "flight.toml", columns.layouts, columns.dt)
assert (again.state == log.state).all()
print(log.to_pandas().describe().loc[["mean", "std"], ["x", "y", "z"]].round(3))

# Recordings open in the same way: `read_log("flight.ulg")`, `read_log("drive.bag")`, `read_log("rosbag2_folder")`,
# `read_log("log.mcap")`, with the extra `recordings`. What remains is
# `diagnose(model, log)`, as in the tutorial before.
