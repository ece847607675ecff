"""The folder of an adaptation: every round as a model with its log, the best model at the top, and what happened.

``rounds/NN/`` appears when its model is complete, ``log.parquet`` in it when the episode is, ``round.json`` when both
are scored: an interrupted run continues behind the last of them.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sym2real.adaptation.record import Record
from sym2real.adaptation.round_report import Learned, RoundReport, best_of, settled
from sym2real.dataset import Dataset
from sym2real.errors import ModelError
from sym2real.files import make_folder, read_as, whole, write_text
from sym2real.json_objects import plain
from sym2real.layout import Layouts
from sym2real.neural.model_folder import Model, holds_model, open_model, save_model

ROUNDS, ANSWER = "rounds", "adaptation.json"
LEARNED, LOG, REPORT = "learned.json", "log.parquet", "round.json"


@dataclass(frozen=True)
class Rounds:
    """Models, logs and reports of one run in a folder; with no folder nothing is kept.

    Args:
        folder: where to keep them, or None.
        layouts: columns of the logs.
    """

    folder: Path | None
    layouts: Layouts

    def claim(self, settings: dict[str, Any]) -> None:
        """Note what the folder's run is, or check that it is the same run.

        Raises:
            ModelError: when the folder holds another run, or a model that no run has made.
            DataError: when its settings cannot be read.
        """
        if self.folder is None:
            return
        if holds_model(self.folder) and not (self.folder / ROUNDS).exists():
            raise ModelError(f"{self.folder} holds a model that was not adapted there; choose another folder")
        Record(self.folder / ROUNDS, self.layouts).claim(settings)

    def model(self, number: int, learn: Callable[[], tuple[Model, Learned]]) -> tuple[Model, Learned]:
        """The model of a round and how it came about: as kept, or learned and kept."""
        if self.folder is None:
            return learn()
        place = round_folder(self.folder, number)
        if not place.exists():
            model, learned = learn()
            make_folder(place.parent)
            with whole(place) as beside:
                save_model(model, beside)
                write_text(beside / LEARNED, json.dumps(plain(learned), indent=1))
        return open_model(place), read_as(place / LEARNED, Learned, "how a model was learned")

    def log(self, number: int, fly: Callable[[], Dataset]) -> Dataset:
        """The log of a round: as kept, or flown and kept."""
        place = None if self.folder is None else round_folder(self.folder, number)
        return Dataset([Record(place, self.layouts).episode(Path(LOG).stem, lambda: fly()[0])])

    def report(self, number: int, score: Callable[[], RoundReport]) -> RoundReport:
        """What a round showed: as kept, or scored and kept."""
        if self.folder is None:
            return score()
        path = round_folder(self.folder, number) / REPORT
        if not path.exists():
            write_text(path, json.dumps(plain(score()), indent=1))
        return read_as(path, RoundReport, "a round of an adaptation")

    def put_on_top(self, model: Model, reports: Sequence[RoundReport]) -> None:
        """The best model at the top of the folder, and beside it what happened in every round."""
        if self.folder is None:
            return
        save_model(model, self.folder)
        answer = {"best": best_of(reports), "settled": settled(reports), "rounds": reports}
        write_text(self.folder / ANSWER, json.dumps(plain(answer), indent=1) + "\n")


def round_folder(folder: Path, number: int) -> Path:
    """Where a round is kept."""
    return folder / ROUNDS / f"{number:02d}"
