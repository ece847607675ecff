"""The rooms of the house: an import may point down, never up or sideways, and heavy libraries have one owner."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "sym2real"
HARDWARE = PACKAGE.parent / "hardware"

FLOORS: dict[str, int] = {
    **dict.fromkeys(
        ("errors", "registry", "layout", "rotation", "past", "trajectory", "protocols", "data", "native", "files"), 0
    ),
    **dict.fromkeys(("robots", "tasks", "effects", "symbolic", "logs"), 1),
    **dict.fromkeys(("plants", "control", "regression", "neural"), 2),
    **dict.fromkeys(("adaptation", "diagnosis"), 3),
    **dict.fromkeys(("report", "experiments"), 4),
    **dict.fromkeys(("cli", "__main__"), 5),
}
SIBLINGS_ALLOWED = {
    ("robots", "symbolic"), ("tasks", "symbolic"), ("effects", "symbolic"), ("tasks", "robots"), ("__main__", "cli"),
    ("report", "experiments"),
}  # fmt: skip
OWNERS = {
    "mujoco": {"plants", "robots"},
    "pyoperon": {"regression"},
    "pysr": {"regression"},
    "matplotlib": {"report"},
    "gymnasium": {"plants"},
    "pandas": {"logs"},
    "pyarrow": {"logs"},
    "tyro": {"cli"},
    "joblib": {"experiments"},
    "distributed": {"experiments"},
    "stable_baselines3": {"experiments"},
}
# Files of hardware/ that may import a robot's or a laboratory's library, inside functions: they are extras.
HARDWARE_OWNERS = {"cflib": "crazyflie/connection.py", "motioncapture": "motion_capture.py"}
FILES = sorted(PACKAGE.rglob("*.py"))
HARDWARE_FILES = sorted(HARDWARE.rglob("*.py"))


def room_of(path: Path) -> str:
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imported_modules(path: Path) -> set[str]:
    modules: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            modules.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            modules.update(f"{node.module}.{alias.name}" for alias in node.names)
    return modules


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_down(path: Path) -> None:
    here = room_of(path)
    if here == "__init__":
        return
    for module in imported_modules(path):
        parts = module.split(".")
        if parts[0] != "sym2real" or len(parts) < 2 or parts[1] not in FLOORS:
            continue
        there = parts[1]
        allowed = there == here or FLOORS[there] < FLOORS[here] or (here, there) in SIBLINGS_ALLOWED
        assert allowed or FLOORS[here] == FLOORS[there] == 0, f"{path.name}: {here} may not import {there}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_heavy_libraries_have_one_owner(path: Path) -> None:
    for module in imported_modules(path):
        owners = OWNERS.get(module.split(".", maxsplit=1)[0])
        assert owners is None or room_of(path) in owners, f"{path} may not import {module}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_hardware_imports_the_package_and_never_the_reverse(path: Path) -> None:
    assert not {module for module in imported_modules(path) if module.split(".", maxsplit=1)[0] == "hardware"}


@pytest.mark.parametrize("path", HARDWARE_FILES, ids=lambda path: str(path.relative_to(HARDWARE)))
def test_libraries_of_robots_have_one_owner(path: Path) -> None:
    for module in imported_modules(path):
        owner = HARDWARE_OWNERS.get(module.split(".", maxsplit=1)[0])
        assert owner is None or HARDWARE / owner == path, f"{path} may not import {module}"


def test_hardware_is_packaged_and_loads_no_robot_library() -> None:
    folders = {path.parent for path in HARDWARE_FILES}
    packages = {".".join(folder.relative_to(HARDWARE.parent).parts) for folder in folders}
    listed = (HARDWARE.parent / "setup.cfg").read_text().split("packages =")[1].split("install_requires")[0].split()
    assert packages == {name for name in listed if name.startswith("hardware")}
    names = [".".join(path.relative_to(HARDWARE.parent).with_suffix("").parts) for path in HARDWARE_FILES]
    modules = ", ".join(name for name in names if not name.endswith("__main__"))
    code = f"import sys, {modules}; print([name for name in {[*HARDWARE_OWNERS]!r} if name in sys.modules])"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert loaded.stdout.strip() == "[]"


def test_every_room_has_a_floor_and_is_packaged() -> None:
    rooms = {room_of(path) for path in FILES} - {"__init__"}
    assert rooms <= FLOORS.keys()
    listed = (PACKAGE.parent / "setup.cfg").read_text().split("packages =")[1].split("install_requires")[0].split()
    folders = [path.parent.relative_to(PACKAGE.parent) for path in PACKAGE.rglob("__init__.py")]
    packages = {".".join(folder.parts) for folder in folders}
    assert packages == {name for name in listed if name.startswith("sym2real")}


def test_import_is_light() -> None:
    heavy = ("mujoco", "pandas", "pyarrow", "matplotlib", "sympy", "tyro", "gymnasium")
    code = f"import sym2real, sys; print([name for name in {heavy!r} if name in sys.modules])"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert loaded.stdout.strip() == "[]"
