"""What the project installs: bounded above, pinned for measurements, and permissive outside the extras."""

from __future__ import annotations

import configparser
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools"))

from licence_table import permissive, required  # noqa: E402 — a script beside the package


def requirements() -> Iterator[Requirement]:
    settings = configparser.ConfigParser()
    settings.read(ROOT / "setup.cfg")
    lists = [settings["options"]["install_requires"], *settings["options.extras_require"].values()]
    for line in "\n".join(lists).splitlines():
        if line.strip():
            yield Requirement(line)
    yield from map(Requirement, tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"])


def test_every_dependency_has_an_upper_bound() -> None:
    unbounded = [str(r) for r in requirements() if not any(s.operator in ("<", "<=", "==", "~=") for s in r.specifier)]
    assert unbounded == []


def test_every_dependency_is_pinned_for_measurements() -> None:
    lines = (ROOT / "tools" / "constraints.txt").read_text().splitlines()
    pins = {canonicalize_name(line.split("==")[0]): line.split("==")[1] for line in lines if not line.startswith("#")}
    assert required("sym2real", ["test"]) - {"sym2real"} <= set(pins), "needed here, not in tools/constraints.txt"
    build = {"setuptools"}
    for requirement in requirements():
        name = canonicalize_name(requirement.name)
        assert name in build or requirement.specifier.contains(pins[name]), f"{requirement} beside {pins[name]}"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("MIT", True),
        ("BSD-3-Clause AND 0BSD AND Zlib", True),
        ("Apache-2.0 WITH LLVM-exception", True),
        ("GPL-2.0-only OR MIT", True),
        ("(MIT OR Apache-2.0)", True),
        ("BSD-3-Clause AND GPL-3.0-or-later", False),
        ("GNU General Public License v2 (GPLv2)", False),
        ("not stated", False),
    ],
)
def test_a_licence_is_permissive_when_every_part_of_an_alternative_is(text: str, expected: bool) -> None:
    assert permissive(text) is expected


def package(folder: Path, name: str, *lines: str) -> None:
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("\n".join(["Metadata-Version: 2.4", f"Name: {name}", "Version: 1.0", *lines, ""]))


def table(folder: Path) -> subprocess.CompletedProcess[str]:
    """The table of an environment in which the packages of this folder come first."""
    paths = f"sys.path[:0] = {[str(folder)]}; sys.path += {sys.path}"
    code = f"import sys; {paths}; import licence_table; licence_table.main()"
    command = [sys.executable, "-S", "-c", code]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT / "tools", check=False)


def test_the_table_refuses_a_needed_package_that_is_not_permissive(tmp_path: Path) -> None:
    package(tmp_path, "sym2real", "Requires-Dist: copyleft<2", "Provides-Extra: radio")
    package(tmp_path, "copyleft", "License-Expression: GPL-3.0-only")
    done = table(tmp_path)
    assert done.returncode == 1
    assert "not permissive, or not stated: copyleft (GPL-3.0-only)" in done.stderr


def test_the_table_lets_an_extra_have_any_licence(tmp_path: Path) -> None:
    package(tmp_path, "sym2real", 'Requires-Dist: copyleft<2; extra == "radio"', "Provides-Extra: radio")
    package(tmp_path, "copyleft", "License-Expression: GPL-3.0-only")
    done = table(tmp_path)
    assert done.returncode == 0, done.stderr
    assert "extra radio" in done.stdout
