"""The whole way of a robot from the command line, for tests of robots that are one file each."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from sym2real.cli import main
from sym2real.diagnosis import compare
from sym2real.logs import read_logs, write_log
from sym2real.symbolic import load_model
from sym2real.trajectory import Trajectory


def go(
    model: Path, drive: Trajectory, task: str, added: Sequence[str], *, channel: str, folder: Path, seconds: float = 0.4
) -> None:
    """Run → compare → diagnose → add → run, on a log with an effect; with it the model predicts better.

    Args:
        model: folder of the learned model.
        drive: the log.
        task: that is flown or driven.
        added: the effect, as `add` takes it.
        channel: whose error 0.5 s ahead must fall by three tenths.
        folder: for all files.
        seconds: of a run.
    """
    log, informed, answer = folder / "log.csv", folder / "informed", folder / "found.json"
    run = [task, "--seconds", str(seconds), "--samples", "64"]
    write_log(drive, log)
    main(["run", str(model), *run, "--out", str(folder / "run")])
    assert (folder / "run" / f"{task}.csv").exists()
    page = folder / "page.html"
    main(["compare", str(model), str(log), "--json", str(folder / "compare.json"), "--report", str(page)])
    assert "Where does it fail?" in page.read_text(encoding="utf-8")
    main(["diagnose", str(model), str(log), "--json", str(answer)])
    # One short log has too few independent pieces.
    assert json.loads(answer.read_text())["verdict"] in {"EFFECT", "CANNOT_TELL"}
    main(["add", str(model), *added, "--out", str(informed)])
    compared, equations = json.loads((folder / "compare.json").read_text())["horizons"], load_model(informed)
    (before,) = (at["errors"][channel]["value"] for at in compared if at["horizon"] == 0.5)
    after = compare(equations, read_logs([log], layouts=equations.layouts)).at(0.5).errors[channel].value
    assert after < 0.7 * before
    main(["run", str(informed), *run])
