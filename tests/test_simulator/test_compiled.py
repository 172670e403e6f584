"""What was compiled is used again, but not after any file of the package has changed."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import simulator.compiled

INNER = """
from loops.compiled import compiled

@compiled
def inner():
    return {value}
"""
OUTER = """
from loops.compiled import compiled
from loops.inner import inner

@compiled
def outer():
    return inner()
"""
RUN = """
from loops.compiled import is_kept
from loops.outer import outer

print(is_kept(outer), outer(), sum(outer.stats.cache_hits.values()))
"""


def test_a_change_in_a_called_function_is_noticed(tmp_path):
    package = tmp_path / "loops"
    package.mkdir()
    (package / "__init__.py").touch()
    shutil.copy(Path(simulator.compiled.__file__), package)
    (package / "outer.py").write_text(OUTER)

    def printed(value):
        (package / "inner.py").write_text(INNER.format(value=value))
        command = [sys.executable, "-c", RUN]
        environment = {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "kept")}
        # Python's own cache takes a file changed within a second, and as long, for the same.
        environment["PYTHONDONTWRITEBYTECODE"] = "1"
        run = subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return run.stdout.split()

    assert printed(1) == ["False", "1", "0"]
    assert printed(1) == ["True", "1", "1"]
    assert printed(2) == ["False", "2", "0"]
