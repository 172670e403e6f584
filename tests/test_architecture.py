"""The house holds: import floors, package names, bpy only in render, no unsafe loading."""

from __future__ import annotations

import ast
import importlib.metadata
import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("scenes", "dataset", "simulator", "render", "roomseg")

# Who may import whom; a package may always import itself.
METHOD_MAY = {"dataset"}
MAY_IMPORT = {
    "scenes": set(),
    "dataset": set(),
    "simulator": {"scenes", "dataset"},
    "render": {"scenes", "dataset"},
}


def source_files() -> list[Path]:
    return [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]


def imported_roots(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    roots = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            roots |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            roots.add((node.module or "").split(".")[0])
    return roots


def allowed(path: Path) -> set[str]:
    relative = path.relative_to(ROOT).parts
    if relative[0] == "roomseg":
        return set(PACKAGES) if relative[1] == "cli" else METHOD_MAY | {"roomseg"}
    return MAY_IMPORT[relative[0]] | {relative[0]}


@pytest.mark.parametrize("path", source_files(), ids=lambda p: str(p.relative_to(ROOT)))
def test_imports_go_down_only(path):
    own = imported_roots(path) & set(PACKAGES)
    assert own <= allowed(path)


@pytest.mark.parametrize("path", source_files(), ids=lambda p: str(p.relative_to(ROOT)))
def test_bpy_lives_in_render_only(path):
    if path.relative_to(ROOT).parts[0] != "render":
        assert not imported_roots(path) & {"bpy", "mathutils"}


def test_method_does_not_import_its_command_line():
    for path in sorted((ROOT / "roomseg").rglob("*.py")):
        if path.relative_to(ROOT).parts[1] == "cli":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert not (node.module or "").startswith("roomseg.cli"), path


@pytest.mark.parametrize("package", PACKAGES)
def test_package_name_resolves_to_this_repository(package):
    spec = importlib.util.find_spec(package)
    assert spec is not None and spec.submodule_search_locations is not None
    places = [Path(place).resolve() for place in spec.submodule_search_locations]
    assert places == [ROOT / package]


@pytest.mark.parametrize("package", PACKAGES)
def test_package_name_belongs_to_this_distribution_alone(package):
    owners = importlib.metadata.packages_distributions().get(package, [])
    assert set(owners) <= {"roomseg"}


@pytest.mark.parametrize("package", PACKAGES)
def test_import_does_not_load_bpy(package):
    code = f"import sys, {package}; sys.exit('bpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0


def test_modules_stay_readable():
    long = [p for p in source_files() if len(p.read_text(encoding="utf-8").splitlines()) > 400]
    assert long == []


def test_test_folders_do_not_shadow_packages():
    assert not [name for name in PACKAGES if (ROOT / "tests" / name).exists()]
