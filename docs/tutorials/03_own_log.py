"""# A log of your own: CSV, ULog, bag, data frame

Any log becomes a model's columns by a specification, a small TOML file. `inspect` proposes one. Here the log is the
real flight that comes with the package; put the path of yours in its place.

    python docs/tutorials/03_own_log.py
"""

from pathlib import Path

from sym2real import Trajectory, compare, example_flight, inspect_logs, quadrotor, read_log
from sym2real.robots import Motors, fit_thrust_per_unit

# What do its columns seem to hold? Every row of the answer has its evidence. Nothing is applied that is only suspected:
# read the proposal, then correct it by hand.

path = example_flight()  # or "my_flight.csv"
proposal = inspect_logs(path)
for row in proposal.rows[:6]:
    print(f"{row.column:>8}  {row.meaning}: {row.evidence}")
Path("flight.toml").write_text(proposal.toml(), encoding="utf-8")
print(proposal.toml())

# This flight has the commands of four motors and a measured attitude. The model that fits is of first principles at
# motor level; its thrust per unit of command is fitted to the first two seconds. Without a mass everything is per
# kilogram. For other commands, or a car, see [by the command line](../tutorial.md).

columns = quadrotor(interface="motors", attitude="measured")
log = read_log(path, "flight.toml", columns.layouts, columns.dt)
log.plot().savefig("flown.svg")
motors = Motors(thrust=fit_thrust_per_unit(log))
model = quadrotor(interface="motors", attitude="measured", motors=motors)
gap = compare(model, log)
print(gap)
gap.plot().savefig("gap.svg")
log.plot(model=model).savefig("measured_and_predicted.svg")

# A data frame is a log too, by the same specification, and a log is a data frame (extra `pandas`).

import pandas as pd

again = Trajectory.from_pandas(pd.read_csv(path), "flight.toml", columns.layouts, columns.dt)
assert (again.state == log.state).all()
print(log.to_pandas().describe().loc[["mean", "std"], ["x", "y", "z"]].round(3))

# Recordings open in the same way: `read_log("flight.ulg")`, `read_log("drive.bag")`, `read_log("rosbag2_folder")`,
# `read_log("log.mcap")`, with the extra `recordings`. What remains is
# `diagnose(model, log)`, as in the tutorial before.
