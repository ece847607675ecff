"""Connect to a MuSHR and its motion capture, and measure for some seconds what a drive needs. Nothing moves.

For example:
  python -m hardware.check_car --sim
  python -m hardware.check_car --master http://192.168.1.3:11311 --poses /vicon/car/car --kind TransformStamped
"""

from hardware.checking import Checking
from hardware.command_line import main
from hardware.mushr.laboratory import MushrLaboratory

if __name__ == "__main__":
    main(Checking[MushrLaboratory], "python -m hardware.check_car", __doc__)
