"""The command line. One verb per module; a verb is a frozen dataclass whose fields are its options."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Annotated, Any, NoReturn, Protocol

import tyro
from rich.console import Console
from rich.markup import escape

from sym2real import __version__
from sym2real.cli.add import Add
from sym2real.cli.compare import Compare
from sym2real.cli.demo import Demo
from sym2real.cli.diagnose import Diagnose
from sym2real.cli.effects import Effects
from sym2real.cli.export import Export
from sym2real.cli.inspect import Inspect
from sym2real.cli.learn import Learn
from sym2real.cli.loading import loading
from sym2real.cli.nominal import NominalCar, NominalQuadrotor
from sym2real.cli.output import console_for, require_places, write_json
from sym2real.cli.parsing import fitted, parse
from sym2real.cli.plan import PlanFlight
from sym2real.cli.run import Run
from sym2real.cli.show import Show
from sym2real.cli.simulate import Simulate
from sym2real.errors import DataError, Sym2RealError, UnknownNameError, reason

DESCRIPTION = """\
From a robot description to a flying model, and from a model that is wrong to the physics it lacks.

From a robot to a model that flies it:
  sym2real learn crazyflie --out runs/base
      equations from a plain simulator
  sym2real run runs/base circle
      fly them with MPPI

From a model and your logs to what is missing:
  sym2real inspect flight.csv --out flight.toml
      what a log of yours holds
  sym2real compare runs/base flight.csv --spec flight.toml
      how good the model is, and where it fails
  sym2real diagnose runs/base flight.csv --spec flight.toml --out runs/found
      which physical effect it lacks
  sym2real run runs/found/model circle
      fly the model that has it
  sym2real add runs/base added_mass --fit flight.csv --out runs/heavier
      or test an idea of your own
  sym2real plan crazyflie hover circle
      what a manoeuvre can show, before you fly it

A robot that is neither of the two starts from numbers alone: sym2real nominal quadrotor --help

Every verb answers --help, and --json FILE writes its result (- is standard output). sym2real --version says which one
this is.
"""

VERBS: dict[str, Any] = {
    "demo": Demo,
    "simulate": Simulate,
    "learn": Learn,
    "nominal": Annotated[NominalQuadrotor, tyro.conf.subcommand("quadrotor")]
    | Annotated[NominalCar, tyro.conf.subcommand("car")],
    "run": Run,
    "show": Show,
    "export": Export,
    "inspect": Inspect,
    "compare": Compare,
    "diagnose": Diagnose,
    "effects": Effects,
    "add": Add,
    "plan": PlanFlight,
}
OF_SEVERAL = {"nominal": "Rigid-body equations from numbers alone."}  # verbs whose words are in no class
Verb: Any = reduce(
    or_,
    (Annotated[kind, tyro.conf.subcommand(name, description=OF_SEVERAL.get(name))] for name, kind in VERBS.items()),
)


class Runnable(Protocol):
    """What every verb offers."""

    @property
    def json(self) -> Path | None:
        """Where the result goes as JSON."""
        ...

    def run(self, console: Console) -> dict[str, Any]:
        """Do the work, tell the console; what ``--json`` writes."""
        ...


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one verb; exit with 2 and one clear message on bad input, with 130 on Ctrl-C."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given == ["--version"]:
        print(f"sym2real {__version__}")
        return
    if given and not given[0].startswith("-") and given[0] not in VERBS:
        _stop(Console(), UnknownNameError("verb", given[0], VERBS))
    # The tensors are small: threads that wait for each other make an action five times slower. Set it to override.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    verb: Runnable = parse(Verb, "sym2real", DESCRIPTION, given)
    console = console_for(verb.json)
    try:
        with loading(given[0], console):
            require_places(verb)
            result = verb.run(console)
        write_json(result, verb.json)
    except Sym2RealError as error:
        _stop(console, error)
    except OSError as error:
        _stop(console, DataError(error.filename or "a file", "one that can be used", reason(error)))
    except KeyboardInterrupt:
        console.print("interrupted; files that were already written stay")
        sys.exit(130)


def _stop(console: Console, error: Sym2RealError) -> NoReturn:
    text = fitted(f"error: {error}", console.width)
    console.print(escape(text).replace("error:", "[bold red]error:[/]", 1), soft_wrap=True)
    sys.exit(2)
