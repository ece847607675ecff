"""A stand-in for PySRRegressor in the worker process: least squares that counts its fits and prints like Julia."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np


class Stub:
    made = 0

    def __init__(self, **settings: Any) -> None:
        Stub.made += 1
        self.number, self.settings, self.fits = Stub.made, settings, 0
        self.found = ""

    def fit(self, values: np.ndarray, target: np.ndarray, variable_names: list[str]) -> Stub:
        print("Progress: 5 / 5 total iterations (100.000%)", flush=True)
        self.fits += 1
        numbers = np.linalg.lstsq(values, target, rcond=None)[0]
        line = " + ".join(f"({number:.12e} * {name})" for number, name in zip(numbers, variable_names, strict=True))
        self.found = line
        return self

    def get_best(self) -> dict[str, str]:
        return {"equation": self.found}

    @property
    def record(self) -> dict[str, Any]:
        return {"number": self.number, "fits": self.fits, "settings": self.settings}


class Logged(Stub):
    """A stub that writes down which fit of which regressor this was, and the modules of its process."""

    def fit(self, values: np.ndarray, target: np.ndarray, variable_names: list[str]) -> Stub:
        import os
        import sys

        super().fit(values, target, variable_names)
        torch = any(name.split(".")[0] == "torch" for name in sys.modules)
        line = {**self.record, "names": variable_names, "process": os.getpid(), "torch": torch}
        with Path(os.environ["STUB_LOG"]).open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        return self


class Failing(Stub):
    def fit(self, values: np.ndarray, target: np.ndarray, variable_names: list[str]) -> Stub:
        raise ArithmeticError("the search diverged")


class Dying(Stub):
    def fit(self, values: np.ndarray, target: np.ndarray, variable_names: list[str]) -> Stub:
        import os
        import sys

        sys.stderr.write("segmentation fault in libjulia\n")
        sys.stderr.flush()
        os._exit(3)
