"""From a robot description to a flying model, and from a model that is wrong to the physics it lacks.

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

A robot of your own starts from its MJCF or, where it flies or drives, from numbers alone:
  sym2real nominal mjcf arm.xml --out runs/arm
      the folder holds the robot: every verb that takes a model takes it
  sym2real nominal quadrotor --help
      a quadrotor, or a car

Every verb answers --help, and --json FILE writes its result (- is standard output); --report FILE of diagnose and
others writes a page that works offline. sym2real --version says which one this is.
"""

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import reduce
from operator import or_
from typing import Annotated, Any

import tyro

from sym2real import __version__
from sym2real.cli.adapt import Adapt
from sym2real.cli.add import Add
from sym2real.cli.compare import Compare
from sym2real.cli.diagnose import Diagnose
from sym2real.cli.effects import Effects
from sym2real.cli.experiment import RunExperiment
from sym2real.cli.export import Export
from sym2real.cli.inspect import Inspect
from sym2real.cli.learn import Learn
from sym2real.cli.nominal import NominalCar, NominalQuadrotor
from sym2real.cli.nominal_mjcf import NominalMjcf
from sym2real.cli.output import STANDARD_OUTPUT, show_json, write_json
from sym2real.cli.parsing import parse
from sym2real.cli.places import kept_apart
from sym2real.cli.plan import PlanFlight
from sym2real.cli.run import Run
from sym2real.cli.show import Show
from sym2real.cli.simulate import Simulate
from sym2real.cli.terminal import Report, ending_in_words, progress_console, put, stop
from sym2real.errors import DataError, Sym2RealError, UnknownNameError

# A verb per module: a frozen dataclass whose fields are its options, ``json`` among them. Its ``run(console)`` does the
# work, tells the console, and returns what ``--json`` writes. The text at the head of this file is the program's help.
VERBS: dict[str, Any] = {
    "simulate": Simulate,
    "learn": Learn,
    "nominal": Annotated[NominalQuadrotor, tyro.conf.subcommand("quadrotor")]
    | Annotated[NominalCar, tyro.conf.subcommand("car")]
    | Annotated[NominalMjcf, tyro.conf.subcommand("mjcf")],
    "run": Run,
    "show": Show,
    "export": Export,
    "inspect": Inspect,
    "compare": Compare,
    "diagnose": Diagnose,
    "effects": Effects,
    "add": Add,
    "adapt": Adapt,
    "plan": PlanFlight,
    "experiment": RunExperiment,
}
# Verbs whose words are in no class.
OF_SEVERAL = {"nominal": "First-principles equations: from numbers alone, or from a robot's MJCF."}
TRACEBACK = "SYM2REAL_TRACEBACK"  # set to 1, errors that nobody foresaw come as tracebacks


def verbs(*, in_short: bool = False) -> Any:
    """The union of the verbs; in short each says its first paragraph alone."""
    summaries = {name: " ".join((kind.__doc__ or "").partition("\n\n")[0].split()) for name, kind in VERBS.items()}
    known = (summaries | OF_SEVERAL) if in_short else OF_SEVERAL
    kinds = (Annotated[kind, tyro.conf.subcommand(name, description=known.get(name))] for name, kind in VERBS.items())
    return reduce(or_, kinds)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one verb.

    Exits with 2 and one clear message on bad input, with 130 on Ctrl-C, and with 70 on an error that nobody
    foresaw. Results go to standard output, errors and progress to standard error.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    with ending_in_words("interrupted: files that were already written stay"):
        try:
            _main(given)
        except (Sym2RealError, OSError):
            raise
        except Exception as error:
            if os.environ.get(TRACEBACK, "") not in ("", "0"):
                raise
            what = f"{type(error).__name__}: {error}"[:200]
            stop(f"error: {what}, a fault of sym2real: please report it with what {TRACEBACK}=1 prints", 70)


def _main(given: list[str]) -> None:
    if given == ["--version"]:
        put(sys.stdout, f"sym2real {__version__}\n")
        return
    if given and not given[0].startswith("-") and given[0] not in VERBS:
        raise UnknownNameError("verb", given[0], VERBS)
    # The tensors are small: threads that wait for each other make an action five times slower. Set it to override.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    verb = parse(verbs(in_short=not {*given} & {*VERBS}), "sym2real", __doc__ or "", given)
    report = Report(sys.stderr if verb.json == STANDARD_OUTPUT else sys.stdout)  # beside JSON, on standard error
    try:
        if progress_console().is_terminal:  # libraries take seconds: it has begun
            progress_console().print(f"{given[0]}: loading libraries", style="dim")
        with kept_apart(verb):
            result = verb.run(report)
            write_json(result, verb.json)
    except BaseException:
        with suppress(DataError):  # what went wrong first is what the user is told
            report.release()
        raise
    report.release()
    if verb.json == STANDARD_OUTPUT:
        show_json(result)
