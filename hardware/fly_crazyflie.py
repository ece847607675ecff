"""Fly a task with MPPI and a model on a Crazyflie: check, arm, take off, task, land; then compare with the model.

Ctrl-C lands, a second one cuts the motors. The folder holds the record of the run (flight.parquet, flight.yaml) and
the part that MPPI flew (TASK.csv), which `sym2real compare` and `diagnose` take.

For example:
  python -m hardware.fly_crazyflie runs/base hover --sim --out runs/hover_1
  python -m hardware.fly_crazyflie runs/base circle --thrust-map 2026.04 --out runs/circle_1
"""

from hardware.command_line import main
from hardware.crazyflie.laboratory import CrazyflieLaboratory
from hardware.run import Run

if __name__ == "__main__":
    main(Run[CrazyflieLaboratory], "python -m hardware.fly_crazyflie", __doc__)
