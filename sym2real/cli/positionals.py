"""What several verbs take, with the names and the words that their help uses."""

from pathlib import Path
from typing import Annotated

import tyro

from sym2real.cli.places import Place

JsonFile = Annotated[Path | None, tyro.conf.arg(help="Write the result to this file (- is standard output).")]
HtmlFile = Annotated[Path | None, tyro.conf.arg(help="Write the whole as one HTML file that works offline.")]
LogsOfModel = Annotated[tuple[Path, ...], tyro.conf.arg(help="Logs that the model is for: it gets their time step.")]
ModelPlace = Annotated[
    Place,
    tyro.conf.Positional,
    tyro.conf.arg(metavar="MODEL", help="A model folder, or a robot's name (its base is learned once and cached)."),
]
TargetPlace = Annotated[Place, tyro.conf.Positional, tyro.conf.arg(metavar="TARGET")]
ExperimentPlace = Annotated[Place, tyro.conf.Positional, tyro.conf.arg(metavar="NAME")]
RobotPlace = Annotated[Place, tyro.conf.Positional, tyro.conf.arg(metavar="ROBOT")]
DescriptionFile = Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE.xml")]
RobotName = Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="ROBOT")]
TaskName = Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="TASK")]
TaskOptions = Annotated[
    tuple[str, ...],
    tyro.conf.Positional,
    tyro.conf.arg(
        metavar="[OPTION=VALUE ...]",
        help="Numbers of the task, as radius=2 of a circle; of regulate the goals of joints or other columns (m, rad).",
    ),
]
OptionalTask = Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="[TASK]")]
OptionalName = Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="[NAME]")]
Logs = Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="LOG [LOG ...]")]
EffectTexts = Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="EFFECT [PARAMETER=VALUE ...]")]
