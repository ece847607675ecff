"""Connect to a Crazyflie and its motion capture, and measure for some seconds what a flight needs. Nothing moves.

For example:
  python -m hardware.check_link --sim
  python -m hardware.check_link --thrust-map 2026.04 --capture vicon --settings hostname=192.168.1.2
"""

from hardware.checking import Checking
from hardware.command_line import main
from hardware.crazyflie.laboratory import CrazyflieLaboratory

if __name__ == "__main__":
    main(Checking[CrazyflieLaboratory], "python -m hardware.check_link", __doc__)
