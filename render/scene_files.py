"""What a 3D scene file says of itself, read before Blender opens it.

Blender follows the references of a file while it opens it, and says little about
what is wrong with one. So this looks first: is it the format that its name says, is it
whole, does it refer to files outside of its own folder, and does it say its unit?
None of it needs Blender.
"""

from __future__ import annotations

import errno
import gzip
import io
import json
import os
import re
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any
from urllib.parse import unquote

import zstandard

from render.usd_strings import usd_layers
from scenes.errors import SceneError

__all__ = ["FORMATS", "inspect_scene", "is_inside", "require_whole", "save_blend"]

MOST_JSON = 200_000_000
"""Longest JSON of a glTF, bytes."""
GZIP, ZSTD = b"\x1f\x8b", b"\x28\xb5\x2f\xfd"
OLDEST_BLOCK, SMALL_BLOCK = struct.Struct("<4siIii"), struct.Struct("<4siQii")
LARGE_BLOCK = struct.Struct("<4siQqq")
"""Of 32-bit Blender, up to 2.7; of 64-bit Blender; of Blender 5."""
USD = (".usd", ".usda", ".usdc", ".usdz")
MOST_UNPACKED = 8_000_000_000
"""Longest content of a Blender file, bytes; compressed nonsense can be any length."""
NEWEST = 500
"""The Blender that this is, as its files count: 5.0."""


def inspect_scene(path: Path) -> bool:
    """Check a file as far as that goes without Blender.

    Parameters
    ----------
    path : Path

    Returns
    -------
    bool
        Whether the format or the file says how long its unit is. (Of a .blend, only
        Blender can tell: true.)

    Raises
    ------
    SceneError
        If the file is missing, another format than its suffix says, cut short, or
        refers to files outside of its folder.
    """
    check = FORMATS.get(path.suffix.lower())
    if check is None:
        raise SceneError(f"{path}: unknown suffix; expected one of {', '.join(FORMATS)}")
    try:
        with path.open("rb") as stream:
            return check(path, stream)
    except OSError as error:
        raise SceneError(f"{path}: cannot be read: {error.strerror or error}") from None


def is_inside(folder: Path, target: str | Path) -> bool:
    """Whether a path, as written in a file of ``folder``, stays in that folder."""
    try:
        return (folder / target).resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):
        return False


def _refuse_outside(path: Path, where: str, target: str, base: Path | None = None) -> None:
    """An error if ``target``, as written in a file of ``base``, is outside of ``path``'s folder."""
    local = target.replace("\\", "/")  # as importers do
    found = (base or path.parent).absolute() / local
    if re.match(r"[a-zA-Z][a-zA-Z0-9+.-]*://", local) or not is_inside(path.parent, found):
        raise SceneError(
            f"{path}: {where}: {target!r} leads out of the file's folder; expected a file in it"
        )


# ---- .blend ---------------------------------------------------------------------------------


def _blend(path: Path, stream: IO[bytes]) -> bool:
    head = stream.read(4)
    stream.seek(0)
    data: Any = stream
    if head == ZSTD:
        reader = zstandard.ZstdDecompressor().stream_reader(stream, read_across_frames=True)
        data = io.BufferedReader(reader, 1 << 20)
    elif head[:2] == GZIP:
        data = gzip.GzipFile(fileobj=stream)
    try:
        libraries = list(_libraries(path, data))
    except (zstandard.ZstdError, EOFError, gzip.BadGzipFile, zlib.error):
        raise _cut_short(path) from None
    if libraries:
        raise SceneError(
            f"{path}: links data of other files ({', '.join(libraries)}); expected all in one "
            f"file (Blender: Object > Relations > Make Local > All)"
        )
    return True


def save_blend(bpy: Any, path: str) -> None:
    """Write the open scene, compressed.

    Raises
    ------
    OSError
        If Blender notices that it cannot; see `require_whole` for when it does not.
    """
    try:
        bpy.ops.wm.save_as_mainfile(filepath=path, compress=True)
    except RuntimeError as error:
        raise OSError(str(error).strip().removeprefix("Error: ")) from None


def require_whole(path: Path) -> None:
    """Refuse half of a file that Blender wrote: it does not notice when the disk is full.

    Raises
    ------
    OSError
        If the file is not whole.
    """
    try:
        inspect_scene(path)
    except SceneError:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) from None


def _cut_short(path: Path) -> SceneError:
    return SceneError(f"{path}: cut short or damaged; expected a whole file")


def _libraries(path: Path, data: IO[bytes]) -> Iterator[str]:
    """Names of the files that a Blender file takes data from; reads all of its blocks."""
    block, wide = _blend_header(path, data)
    left = MOST_UNPACKED
    while True:
        head = data.read(block.size)
        if len(head) < block.size:
            raise _cut_short(path)
        fields = block.unpack(head)
        length = fields[3] if wide else fields[1]
        if fields[0] == b"ENDB":
            return
        left -= length
        if length < 0 or left < 0:
            raise _cut_short(path)
        if fields[0] == b"LI\0\0":
            names = re.findall(rb"[^\0-\x1f]+\.blend\b", data.read(min(length, 1 << 16)))
            yield (names[-1] if names else b"?").decode(errors="replace")
            length -= 1 << 16
        _skip(path, data, length)


def _blend_header(path: Path, data: IO[bytes]) -> tuple[struct.Struct, bool]:
    """The layout of the blocks, by the file's first bytes."""
    head = data.read(12)
    old = re.fullmatch(rb"BLENDER([-_])v(\d\d\d)", head)
    if old:
        return SMALL_BLOCK if old[1] == b"-" else OLDEST_BLOCK, False
    new = re.fullmatch(rb"BLENDER17-(\d\d)v(\d{4})", head + data.read(5))
    if new:
        if int(new[1]) > 1 or int(new[2]) > NEWEST:
            raise SceneError(f"{path}: of Blender {int(new[2]) / 100:g}; expected at most 5.0")
        return LARGE_BLOCK, True
    raise SceneError(f"{path}: not a file of Blender for little-endian computers; expected one")


def _skip(path: Path, data: IO[bytes], length: int) -> None:
    while length > 0:
        step = len(data.read(min(length, 1 << 20)))
        if step == 0:
            raise _cut_short(path)
        length -= step


# ---- glTF -----------------------------------------------------------------------------------


def _glb(path: Path, stream: IO[bytes]) -> bool:
    head = stream.read(20)
    if len(head) < 20 or head[:4] != b"glTF":
        raise SceneError(f"{path}: not a binary glTF file; expected one")
    version, length, size, kind = struct.unpack("<4x2I I4s", head)
    there = path.stat().st_size
    if length > there:
        raise SceneError(f"{path}: cut short: {there} of {length} bytes; expected a whole file")
    if version != 2 or kind != b"JSON":
        raise SceneError(f"{path}: glTF version {version}; expected 2")
    _check_gltf(path, stream.read(min(size, MOST_JSON)))
    return True


def _gltf(path: Path, stream: IO[bytes]) -> bool:
    _check_gltf(path, stream.read(MOST_JSON))
    return True


def _check_gltf(path: Path, text: bytes) -> None:
    """Every file that a glTF names must lie in its folder."""
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        raise SceneError(f"{path}: its JSON is damaged; expected glTF 2.0") from None
    if not isinstance(content, dict) or "asset" not in content:
        raise SceneError(f"{path}: no glTF; expected an object with 'asset'")
    for group in ("buffers", "images"):
        for index, item in enumerate(_list(content.get(group))):
            target = item.get("uri", "") if isinstance(item, dict) else ""
            if isinstance(target, str) and not target.startswith("data:"):
                _refuse_outside(path, f"{group}[{index}].uri", unquote(target))


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


# ---- others --------------------------------------------------------------------------------


def _obj(path: Path, stream: IO[bytes]) -> bool:
    for number, line in enumerate(stream, start=1):
        if b"\0" in line:
            raise SceneError(f"{path}: line {number} is no text; expected Wavefront OBJ")
        _, keyword, rest = line.partition(b"mtllib")
        target = rest.decode(errors="replace").strip().strip('"')
        if target.endswith("\\"):
            raise SceneError(f"{path}: line {number}: mtllib goes on; expected it in one line")
        if keyword:
            _refuse_outside(path, f"line {number}: mtllib", target)
    return False


def _usd(path: Path, stream: IO[bytes]) -> bool:
    """Every file that a USD file names must lie in its folder, and what those name, too."""
    root = list(usd_layers(path, stream))
    seen, waiting = {path.resolve()}, [(path, root)]
    while waiting:
        file, layers = waiting.pop()
        for target in (asset for layer in layers for asset in layer.assets):
            _refuse_outside(path, "asset", target, file.parent)
            part = (file.parent / target.partition("[")[0]).resolve()
            if part.suffix.lower() in USD and part.is_file() and part not in seen:
                seen.add(part)
                with part.open("rb") as inner:
                    waiting.append((part, list(usd_layers(part, inner))))
    return any("metersPerUnit" in layer.words for layer in root[:1])


def _stl(path: Path, stream: IO[bytes]) -> bool:
    head, size = stream.read(84), path.stat().st_size
    whole = len(head) == 84 and size >= 84 + 50 * int.from_bytes(head[80:], "little")
    if head[:5] != b"solid" and not whole:
        raise SceneError(f"{path}: cut short or no STL; expected a whole STL file")
    return False


def _ply(path: Path, stream: IO[bytes]) -> bool:
    if stream.read(3) != b"ply":
        raise SceneError(f"{path}: no PLY; expected a PLY file")
    return False


def _fbx(path: Path, stream: IO[bytes]) -> bool:
    head = stream.read(18)
    if head != b"Kaydara FBX Binary" and not head.startswith(b"; FBX"):
        raise SceneError(f"{path}: no FBX; expected an FBX file")
    return True


FORMATS = {
    ".blend": _blend,
    ".fbx": _fbx,
    ".glb": _glb,
    ".gltf": _gltf,
    ".obj": _obj,
    ".ply": _ply,
    ".stl": _stl,
    **dict.fromkeys(USD, _usd),
}
"""What can be imported, by suffix."""
