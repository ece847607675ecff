"""The rooms of the house: an import may point down, never up or sideways, and heavy libraries have one owner."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "sym2real"
HARDWARE = PACKAGE.parent / "hardware"

FLOORS: dict[str, int] = {
    **dict.fromkeys(
        (
            "errors",
            "registry",
            "field",
            "vocabulary",
            "layout",
            "rotation",
            "past",
            "trajectory",
            "dataset",
            "level_ground",
            "inertias",
            "protocols",
            "data",
            "native",
            "files",
            "upward",
            "threads",
            "generator",
            "toml_tables",
            "json_objects",
            "stages",
            "correlations",
            "least_squares",
        ),
        0,
    ),
    **dict.fromkeys(("robots", "tasks", "effects", "symbolic", "logs"), 1),
    **dict.fromkeys(("plants", "control", "regression", "neural"), 2),
    **dict.fromkeys(("adaptation", "diagnosis"), 3),
    **dict.fromkeys(("report", "experiments"), 4),
    **dict.fromkeys(("cli", "__main__"), 5),
}
# The same within the diagnosis, whose data flow one way; folders have a dozen files at most.
DIAGNOSIS_FLOORS = {
    name: floor
    for floor, name in enumerate(
        ("settings", "data", "faults", "question", "predict", "estimate", "errors", "search", "score",
         "unexplained", "design", "conclusion", "answer", "naming", "pipeline", "adding")
    )
}  # fmt: skip
MOST_FILES = 12
SIBLINGS_ALLOWED = {
    ("robots", "symbolic"), ("tasks", "symbolic"), ("effects", "symbolic"), ("tasks", "robots"), ("__main__", "cli"),
    ("report", "experiments"),
}  # fmt: skip
OWNERS = {
    "mujoco": {"plants", "robots"},
    "pyoperon": {"regression"},
    "pysr": {"regression"},
    "matplotlib": {"report"},
    "jinja2": {"report"},
    "gymnasium": {"plants"},
    "pandas": {"logs"},
    "pyarrow": {"logs"},
    "tyro": {"cli"},
    "joblib": {"experiments"},
    "distributed": {"experiments"},
    "stable_baselines3": {"experiments"},
}
# Files of hardware/ that may import a robot's or a laboratory's library, inside functions: they are extras.
HARDWARE_OWNERS = {"cflib": "crazyflie/connection.py", "motioncapture": "motion_capture.py", "rclpy": "ros2/node.py"}
FILES = sorted(PACKAGE.rglob("*.py"))
HARDWARE_FILES = sorted(HARDWARE.rglob("*.py"))


def room_of(path: Path) -> str:
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


@cache
def imported_modules(path: Path) -> frozenset[str]:
    return frozenset(modules_in(ast.parse(path.read_text())))


def modules_in(tree: ast.AST) -> set[str]:
    modules: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            modules.update(f"{node.module}.{alias.name}" for alias in node.names)
    return modules


def imports(files: list[Path]) -> Iterator[tuple[Path, str]]:
    """Every module that each file imports."""
    return ((path, module) for path in files for module in sorted(imported_modules(path)))


def may_import(here: str, there: str) -> bool:
    return (
        here in ("__init__", there)
        or FLOORS[there] < FLOORS[here]
        or (here, there) in SIBLINGS_ALLOWED
        or FLOORS[here] == FLOORS[there] == 0
    )


def test_imports_point_down() -> None:
    rooms = [(path, module.split(".")[1]) for path, module in imports(FILES) if module.startswith("sym2real.")]
    wrong = [(str(path), room) for path, room in rooms if room in FLOORS and not may_import(room_of(path), room)]
    assert wrong == []


def test_the_diagnosis_flows_one_way() -> None:
    folder, prefix, wrong = PACKAGE / "diagnosis", "sym2real.diagnosis.", []
    for path, module in imports(sorted(folder.rglob("*.py"))):
        here = path.relative_to(folder).parts[0].removesuffix(".py")
        if here != "__init__" and module.startswith(prefix):
            there = module.removeprefix(prefix).split(".")[0]
            wrong += [(str(path), module)] if DIAGNOSIS_FLOORS[there] > DIAGNOSIS_FLOORS[here] else []
    assert wrong == []


def test_folders_of_the_diagnosis_have_a_dozen_files() -> None:
    folders = [folder for folder in (PACKAGE / "diagnosis").iterdir() if folder.is_dir()]
    assert {folder.name for folder in folders if len([*folder.glob("*.py")]) > MOST_FILES} == set()


def test_no_module_hides_behind_what_its_room_calls_alike() -> None:
    for room in PACKAGE.rglob("__init__.py"):
        imported = [node for node in ast.parse(room.read_text()).body if isinstance(node, ast.ImportFrom)]
        given = {alias.asname or alias.name: node.module for node in imported for alias in node.names}
        modules = {path.stem for path in room.parent.glob("*.py")} - {"__init__"}
        package = ".".join(("sym2real", *room.parent.relative_to(PACKAGE).parts))
        assert [name for name in modules & set(given) if given[name] != package] == [], room


@cache
def types_alone(path: Path) -> set[str]:
    """What a file imports for its annotations: no library is loaded by it."""
    blocks = (node for node in ast.parse(path.read_text()).body if isinstance(node, ast.If))
    return {module for block in blocks if ast.unparse(block.test) == "TYPE_CHECKING" for module in modules_in(block)}


def test_heavy_libraries_have_one_owner() -> None:
    owned = [
        (path, module, OWNERS.get(module.split(".", maxsplit=1)[0]))
        for path, module in imports(FILES)
        if module not in types_alone(path)
    ]
    assert [(str(path), module) for path, module, owners in owned if owners and room_of(path) not in owners] == []


def test_hardware_imports_the_package_and_never_the_reverse() -> None:
    assert [(path, module) for path, module in imports(FILES) if module.split(".", maxsplit=1)[0] == "hardware"] == []


def test_libraries_of_robots_have_one_owner() -> None:
    owned = [
        (p, module, HARDWARE_OWNERS.get(module.split(".", maxsplit=1)[0])) for p, module in imports(HARDWARE_FILES)
    ]
    assert [(path, module) for path, module, owner in owned if owner and HARDWARE / owner != path] == []


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
