"""Drive a task with MPPI and a model on a MuSHR: check, drive to the start, task, brake; then compare.

Hold the button for autonomy. Ctrl-C brakes, a second one stops the wheels at once. The folder holds the record of
the run (drive.parquet, drive.yaml) and the part that MPPI drove (TASK.csv), which `sym2real compare` and `diagnose`
take.

For example:
  python -m hardware.drive_mushr runs/base circle --sim --out runs/circle_1
  python -m hardware.drive_mushr runs/base park --master http://192.168.1.3:11311 --out runs/park_1
"""

from hardware.command_line import main
from hardware.mushr.laboratory import MushrLaboratory
from hardware.run import Run

if __name__ == "__main__":
    main(Run[MushrLaboratory], "python -m hardware.drive_mushr", __doc__)
