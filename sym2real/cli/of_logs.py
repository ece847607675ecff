"""The options that give every verb that reads logs the names of their columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sym2real.cli.numbers import OptionalPositive
from sym2real.cli.places import Place
from sym2real.errors import ModelError

if TYPE_CHECKING:
    from sym2real.dataset import Dataset
    from sym2real.logs import LogSpec
    from sym2real.symbolic import Equations


@dataclass(frozen=True, kw_only=True)
class OfLogs:
    """A verb that reads logs."""

    spec: Place | None = None
    """How the logs' columns are named: a shipped specification's name or a TOML file."""
    columns: tuple[str, ...] = ()
    """Names of the columns of text files without a header, in their order."""

    @property
    def naming(self) -> LogSpec | None:
        """The specification, with the names of the columns where they were given."""
        from sym2real.logs import with_header

        return with_header(self.spec, self.columns)

    def naming_of(self, given: object, options: str) -> LogSpec | None:
        """The same where an option has given logs.

        Raises:
            ModelError: for names of the columns of none.
        """
        if not given and (self.spec is not None or self.columns):
            raise ModelError(f"--spec and --columns name the columns of {options}, found no {options}")
        return self.naming


@dataclass(frozen=True, kw_only=True)
class OfFit(OfLogs):
    """A verb that fits effects to logs, and scores the fit."""

    held_out: tuple[Path, ...] = ()
    """Logs that score the fit; by default each log is scored by the fit without it."""
    exclude: tuple[str, ...] = ()
    """Effects that are not tested (KIND or KIND:COLUMN)."""
    horizon: OptionalPositive = None
    """Longest horizon of the error ladder in s."""
    calibrate: bool = True
    """Before a fit, calibrate the base in the robot's plain simulator."""

    def read(self, base: Equations, logs: Sequence[Path]) -> tuple[Dataset, dict[str, Any]]:
        """The logs, and the other arguments of ``diagnose`` and ``try_effect``; errors of the reader."""
        from sym2real.cli.model import logs_for

        data = logs_for(base, logs, self.naming)
        held_out = logs_for(base, self.held_out, self.naming, apart_from=logs) if self.held_out else None
        options = {"held_out": held_out, "exclude": self.exclude, "horizon": self.horizon, "calibrate": self.calibrate}
        return data, options
