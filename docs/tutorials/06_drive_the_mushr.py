"""# Drive the MuSHR (fake)

The same for a car over ROS 1, without ROS on this machine: the fake has a master, a car with MuJoCo behind it, and a
motion capture. Hold the button for autonomy on the real one.

    python docs/tutorials/06_drive_the_mushr.py
"""

import subprocess
import sys

from sym2real import ROBOTS, read_logs, save_model

SHORT = "--short" in sys.argv

# A model, a drive, a record. `--master URI` in place of `--sim` talks to the robot's own ROS.

robot = ROBOTS["mushr"]
save_model(robot.nominal(), "model")
command = ["-m", "hardware.run", "mushr", "model", "circle", "--sim", "--samples", "64"]
seconds = ["--seconds", "3" if SHORT else "10"]
# A busy machine may be late; a real drive keeps the limits as they are.
patient = ["--limits.late", "9", "--limits.pose-age", "9", "--limits.overruns", "10000"]
subprocess.run([sys.executable, *command, *seconds, *patient, "--out", "drive"], check=True)

log = max(read_logs("drive/circle.csv", layouts=robot.layouts), key=len)
print(log)
log.plot().savefig("driven.svg")
assert abs(log.column("speed")).max() > 0.3
