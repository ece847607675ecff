"""The robots that verbs know: a verb over each of their laboratories is a subcommand."""

from functools import reduce
from operator import or_
from typing import Annotated, Any, TypeVar

import tyro

from hardware.crazyflie.laboratory import CrazyflieLaboratory
from hardware.laboratory import Laboratory
from hardware.mushr.laboratory import MushrLaboratory

Kind = TypeVar("Kind", bound=Laboratory)
LABORATORIES: dict[str, type[Laboratory]] = {"crazyflie": CrazyflieLaboratory, "mushr": MushrLaboratory}


def of_every_robot(verb: Any) -> Any:
    """A union for the command line of a verb that is generic in its laboratory."""
    verbs = (Annotated[verb[kind], tyro.conf.subcommand(name)] for name, kind in LABORATORIES.items())
    return reduce(or_, verbs)
