"""# Fly the Crazyflie (fake)

The launch script that flies a real Crazyflie flies a fake one with `--sim`: a process that speaks its radio protocol on
UDP, with MuJoCo behind it. Check, arm, take off, task, land, compare: the order is that of a real flight.

    python docs/tutorials/05_fly_the_crazyflie.py
"""

import subprocess
import sys

from sym2real import ROBOTS, read_logs, save_model

SHORT = "--short" in sys.argv

# A model to fly with: first principles do.

robot = ROBOTS["crazyflie"]
save_model(robot.nominal(), "model")

# `hardware.checking crazyflie --sim` asks first whether everything is there that a flight needs. Without `--sim` both
# commands talk to the robot, and the flight asks for `--thrust-map`, its firmware's.

seconds = "3" if SHORT else "10"
command = ["-m", "hardware.run", "crazyflie", "model", "hover", "--sim", "--seconds", seconds, "--samples", "64"]
# A busy machine may be late; a real flight keeps the limits as they are.
patient = [f"--limits.{age}=0.4" for age in ("late", "pose-age", "attitude-age")] + ["--limits.overruns=10000"]
subprocess.run([sys.executable, *command, *patient, "--out", "flight"], check=True)

# The folder holds the whole record and the part that MPPI flew, which is a log like any other. Where the computer
# missed control periods it has gaps, and `read_logs` makes logs of what lies between them.

log = max(read_logs("flight/hover.csv", layouts=robot.layouts), key=len)
print(log, f"mean height {log.column('z').mean():.2f} m")
log.plot().savefig("flown.svg")
assert 0.5 < log.column("z").mean() < 1.5
