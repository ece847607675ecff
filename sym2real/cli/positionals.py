"""What a verb takes without an option, by the names that its help uses."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from sym2real.cli.places import Place

ModelPlace = Annotated[Place, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL")]
TargetPlace = Annotated[Place, tyro.conf.Positional, tyro.conf.arg(metavar="TARGET")]
ExperimentPlace = Annotated[Place, tyro.conf.Positional, tyro.conf.arg(metavar="NAME")]
RobotPlace = Annotated[Place, tyro.conf.Positional, tyro.conf.arg(metavar="ROBOT")]
DescriptionFile = Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE.xml")]
RobotName = Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="ROBOT")]
TaskName = Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="TASK")]
OptionalTask = Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="[TASK]")]
OptionalName = Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="[NAME]")]
Logs = Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="LOG [LOG ...]")]
EffectTexts = Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="EFFECT [PARAMETER=VALUE ...]")]
