"""What a user is told when Blender does not load."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

from render import libraries
from render.libraries import DEBIAN_PACKAGES, MissingLibraryError, explain, load_bpy, main


@pytest.mark.parametrize(
    ("file", "package"),
    [("libXi.so.6", "libxi6"), ("libGL.so.1", "libgl1"), ("libxkbcommon.so.0", "libxkbcommon0")],
)
def test_the_missing_file_and_its_package_are_named(
    file: str, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(libraries, "find_library", lambda name: f"lib{name}.so")
    line = explain(ImportError(f"{file}: cannot open shared object file: No such file"))
    assert file in line
    assert line.endswith(f"apt-get install {package}")
    assert "\n" not in line


def test_all_missing_packages_are_named_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    there = {"X11", "Xrender", "Xi", "xkbcommon", "SM", "ICE"}
    monkeypatch.setattr(libraries, "find_library", lambda name: name if name in there else None)
    line = explain(ImportError("libXfixes.so.3: cannot open shared object file"))
    assert line.endswith("apt-get install libxfixes3 libgl1")


def test_an_unknown_library_names_all_packages() -> None:
    line = explain(ImportError("libfoo.so.3: cannot open shared object file"))
    assert "libfoo.so.3" in line
    assert all(package in line for package in DEBIAN_PACKAGES.values())


def test_bpy_not_installed() -> None:
    assert "pip install bpy" in explain(ModuleNotFoundError("No module named 'bpy'"))


def test_load_and_main_fail_with_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(name: str) -> None:
        raise ImportError("libSM.so.6: cannot open shared object file")

    monkeypatch.setattr(importlib, "import_module", fail)
    with pytest.raises(MissingLibraryError, match="libsm6"):
        load_bpy()
    assert main() == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_importing_render_does_not_load_blender() -> None:
    code = "import sys, render; sys.exit('bpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
