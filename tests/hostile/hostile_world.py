"""What is damaged: logs, a specification, a model, a simulator and the folder of a diagnosis, small and whole."""

import json
import shutil
from contextlib import chdir, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

from sym2real.cli import main
from sym2real.logs import LogSpec, read_log, write_log
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import save_model

SECONDS = "2"
# What each file is read by; the answer goes to result.json.
READERS: dict[str, tuple[str, ...]] = {
    "flight.csv": ("compare", "model", "flight.csv"),
    "flight.parquet": ("compare", "model", "flight.parquet"),
    "foreign.csv": ("inspect", "foreign.csv"),
    "foreign.toml": ("compare", "model", "foreign.csv", "--spec", "foreign.toml"),
    "model": ("show", "model"),
    "plant": ("simulate", "plant", "hover", "--seconds", "0.2", "--out", "new.csv"),
}
RESULT = "result.json"


@dataclass(frozen=True)
class World:
    """A folder with whole files, and the answers that they get.

    Args:
        folder: of the files.
        answers: by what of :data:`READERS` is read.
    """

    folder: Path
    answers: dict[str, object]


def make_world(folder: Path) -> World:
    """Make the files and ask for the answers; every verb has been run once then, and what it loads is there."""
    with redirect_stdout(StringIO()):
        return _made(folder)


def _made(folder: Path) -> World:
    folder.mkdir(parents=True)
    flight = folder / "flight.csv"
    main(["simulate", "crazyflie", "circle", "--noise", "--seconds", SECONDS, "--out", str(flight)])
    log = read_log(flight, layouts=CRAZYFLIE.layouts)
    write_log(log, folder / "flight.parquet")
    save_model(CRAZYFLIE.nominal(), folder / "model")
    main(["add", str(folder / "model"), "wind", "fx=0.01", "--out", str(folder / "added")])
    shutil.move(folder / "added" / "simulator", folder / "plant")
    shutil.rmtree(folder / "added")
    _make_foreign(folder)
    diagnosis = folder / "diagnosis"
    diagnosis.mkdir()
    (diagnosis / "ladder.png").write_bytes(b"a figure")
    (diagnosis / "diagnosis.json").write_text(json.dumps({"verdict": "EFFECT", "files": ["ladder.png"]}))
    return World(folder, {name: _answer(folder, reader) for name, reader in READERS.items()})


def _make_foreign(folder: Path) -> None:
    """The flight under other names, and the specification that maps them."""
    header, _, rows = (folder / "flight.csv").read_text().partition("\n")
    names = {name: f"log_{name}" for name in header.split(",")}
    (folder / "foreign.csv").write_text(",".join(names.values()) + "\n" + rows)
    quaternion = [names[name] for name in ("qw", "qx", "qy", "qz")]
    columns = {name: names[name] for name in ("x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz", "thrust")}
    columns |= {name: names[name] for name in ("wx_cmd", "wy_cmd", "wz_cmd")}
    lines = [
        "[time]",
        'column = "log_time"',
        "[columns]",
        *(f'{name} = "{source}"' for name, source in columns.items()),
    ]
    lines += ["[attitude]", f"quaternion = {json.dumps(quaternion)}"]
    LogSpec.parse("\n".join(lines)).save(folder / "foreign.toml")


def _answer(folder: Path, reader: tuple[str, ...]) -> object:
    with chdir(folder):
        main([*reader, "--json", RESULT])
        answer = json.loads(Path(RESULT).read_text())
        Path(RESULT).unlink()
        Path("new.csv").unlink(missing_ok=True)
        return answer
