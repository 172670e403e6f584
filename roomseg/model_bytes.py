"""The same bytes for the same model.

A skops file is a ZIP archive of arrays and a JSON schema, in which objects are
numbered by their address in memory; addresses and the archive's dates differ
from run to run. Numbering the objects in the order of the schema, and dating
every member alike, changes nothing of what is loaded.
"""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

__all__ = ["make_repeatable"]

SCHEMA = "schema.json"
ADDRESS = re.compile(r'(?<="__id__": )\d+|(?<=")\d+(?=\.npy")')
"""An object's number, or the name of the file that holds its array."""


def make_repeatable(path: str | Path) -> None:
    """Rewrite a skops file so that equal models give equal files.

    Parameters
    ----------
    path : path
        Rewritten in place; not safe against a crash, so not a user's only copy.
    """
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    schema = members.pop(SCHEMA).decode()
    number: dict[str, str] = {}
    schema = ADDRESS.sub(lambda m: number.setdefault(m[0], str(len(number) + 1)), schema)
    named = {f"{number[Path(name).stem]}.npy": data for name, data in members.items()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in [*sorted(named.items()), (SCHEMA, schema.encode())]:
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
