"""What a loop leaves behind as it goes, so that an interrupted run continues where it stopped."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sym2real.errors import ModelError
from sym2real.files import read_object, write_text
from sym2real.layout import Layouts
from sym2real.logs import read_log, write_log
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory

SETTINGS = "settings.json"


@dataclass(frozen=True)
class Record:
    """Episodes, equations and reports of one run in a folder; with no folder nothing is kept.

    Args:
        folder: where to keep them, or None.
        layouts: columns of the episodes.
    """

    folder: Path | None
    layouts: Layouts

    def claim(self, settings: dict[str, Any]) -> None:
        """Note what the folder's run is, or check that it is the same run.

        Raises:
            ModelError: when the folder holds a run with other settings.
            DataError: when its settings cannot be read.
        """
        if self.folder is None:
            return
        if not (self.folder / SETTINGS).exists():
            text = json.dumps(settings, indent=1, default=int)  # NumPy has integers of its own
            write_text(self.folder / SETTINGS, text)
            return
        recorded = read_object(self.folder / SETTINGS, "the settings of a run")
        differing = sorted(key for key in settings | recorded if settings.get(key) != recorded.get(key))
        if differing:
            changes = ", ".join(f"{key}: {recorded.get(key)} there, {settings.get(key)} now" for key in differing)
            raise ModelError(
                f"{self.folder} holds a run with other settings ({changes}); "
                "choose another folder, or delete this one to start over"
            )

    def episode(self, name: str, fly: Callable[[], Trajectory]) -> Trajectory:
        """The episode kept under this name, or a new one that is kept before it is returned."""
        if self.folder is None:
            return fly()
        path = self.folder / f"{name}.parquet"
        if not path.exists():
            write_log(fly(), path)
        return read_log(path, layouts=self.layouts)

    def equations(self, name: str, fit: Callable[[], Equations]) -> Equations:
        """The equations kept under this name, or new ones that are kept before they are returned."""
        if self.folder is None:
            return fit()
        path = self.folder / f"{name}.json"
        if not path.exists():
            write_text(path, fit().to_json())
        return Equations.from_json(path.read_text(encoding="utf-8"))
