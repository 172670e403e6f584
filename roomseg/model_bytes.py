"""The same bytes for the same model, and what a model file may name.

A skops file is a ZIP archive of arrays and a JSON schema, in which objects are
numbered by their address in memory; addresses and the archive's dates differ
from run to run. Numbering the objects in the order of the schema, and dating
every member alike, changes nothing of what is loaded.
"""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from dataset.errors import FormatError

__all__ = ["check_plain", "make_repeatable"]

SCHEMA = "schema.json"
PLAIN = {"builtins.dict", "builtins.list", "builtins.str", "numpy.ndarray"}
LOADERS = {"DictNode", "ListNode", "JsonNode", "NdArrayNode", "TypeNode"}
MOST_BYTES = 256_000_000
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


def check_plain(path: str | Path) -> None:
    """Refuse a skops file that holds more than numbers, texts, lists and arrays.

    What skops itself trusts, scikit-learn's classes and NumPy's functions among it, is
    refused, too: a model needs none of it.

    Raises
    ------
    FormatError
        If the file names anything else, or would fill the memory.
    """
    with zipfile.ZipFile(path) as archive:
        size = sum(member.file_size for member in archive.infolist())
        if size > MOST_BYTES:
            raise FormatError(f"{path}: {size} bytes unpacked, expected at most {MOST_BYTES}")
        schema = json.loads(archive.read(SCHEMA))
    for node in _nodes(schema):
        name = f"{node.get('__module__')}.{node.get('__class__')}"
        if name not in PLAIN or node.get("__loader__") not in LOADERS:
            raise FormatError(f"{path}: names {name}, expected numbers only; train again")


def _nodes(value: Any) -> Iterator[dict[str, Any]]:
    """Everything in a schema that makes an object."""
    if isinstance(value, dict):
        if any(key in value for key in ("__class__", "__module__", "__loader__")):
            yield value
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from _nodes(item)
