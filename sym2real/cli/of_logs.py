"""The options by which every verb that reads logs is told how their columns are named."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from sym2real.cli.places import Place
from sym2real.errors import ModelError

if TYPE_CHECKING:
    from sym2real.logs import LogSpec


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
        from sym2real.logs import load_spec, with_header

        return with_header(None if self.spec is None else load_spec(self.spec), self.columns)

    def naming_of(self, given: object, options: str) -> LogSpec | None:
        """The same where an option has given logs.

        Raises:
            ModelError: for names of the columns of none.
        """
        if not given and (self.spec is not None or self.columns):
            raise ModelError(f"--spec and --columns name the columns of {options}, found none")
        return self.naming
