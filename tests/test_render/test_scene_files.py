"""What scene files say of themselves is read without Blender, and other files are not."""

from __future__ import annotations

import gzip
import json
import struct
import zipfile
from pathlib import Path

import pytest

from render.scene_files import FORMATS, inspect_scene, is_inside
from render.usd_strings import _lz4
from scenes import SceneError


def write(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def glb(content: object) -> bytes:
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text), len(text), b"JSON")
    return head + text


HEADS = {"5.0": b"BLENDER17-01v0500", "4.5": b"BLENDER-v405", "32 bits": b"BLENDER_v261"}


def blend(*blocks: tuple[bytes, bytes], kind: str = "5.0") -> bytes:
    """A Blender file of the three layouts."""
    data = HEADS[kind]
    for code, content in (*blocks, (b"ENDB", b"")):
        if kind == "5.0":
            data += struct.pack("<4siQqq", code, 0, 1, len(content), 1) + content
        else:
            address = "Q" if kind == "4.5" else "I"
            data += struct.pack(f"<4si{address}ii", code, len(content), 1, 0, 1) + content
    return data


def test_paths_that_leave_a_folder(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "way_out").symlink_to("/etc")
    for inside in ("a.png", "sub/a.png", "sub/../a.png", str(tmp_path / "a.png"), "./a"):
        assert is_inside(tmp_path, inside), inside
    for outside in ("../a.png", "/etc/passwd", "sub/../../a", "way_out/passwd", "a\0b"):
        assert not is_inside(tmp_path, outside), outside


@pytest.mark.parametrize("kind", HEADS)
def test_blender_files_are_walked_to_their_end(tmp_path: Path, kind: str) -> None:
    whole = blend((b"GLOB", b"x" * 99), (b"DNA1", b"y" * 1000), kind=kind)
    assert inspect_scene(write(tmp_path / "a.blend", whole))
    assert inspect_scene(write(tmp_path / "z.blend", gzip.compress(whole)))
    for cut in (len(whole) - 30, len(whole) - 40, 200, 20):
        with pytest.raises(SceneError, match="cut short or damaged"):
            inspect_scene(write(tmp_path / "a.blend", whole[:cut]))
    with pytest.raises(SceneError, match="cut short or damaged"):
        inspect_scene(write(tmp_path / "z.blend", gzip.compress(whole)[:-20]))


def test_a_blender_file_without_end_is_refused(tmp_path: Path) -> None:
    head = b"BLENDER17-01v0500"
    for code in (b"DATA", b"LI\0\0"):
        huge = head + struct.pack("<4siQqq", code, 0, 1, 1 << 60, 1)
        with pytest.raises(SceneError, match="cut short or damaged"):
            inspect_scene(write(tmp_path / "a.blend", huge))


@pytest.mark.parametrize("kind", HEADS)
def test_a_blender_file_that_links_another_is_refused(tmp_path: Path, kind: str) -> None:
    library = b"\0" * 40 + b"LIchairs.blend" + b"\0" * 60 + b"//../chairs.blend\0"
    path = write(tmp_path / "a.blend", blend((b"LI\0\0", library), kind=kind))
    with pytest.raises(SceneError, match=r"links data of other files \(//../chairs.blend\)"):
        inspect_scene(path)


def test_a_newer_blender_is_named(tmp_path: Path) -> None:
    newer = write(tmp_path / "a.blend", b"BLENDER17-01v0612" + b"\0" * 100)
    with pytest.raises(SceneError, match=r"of Blender 6.12; expected at most 5.0"):
        inspect_scene(newer)


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
@pytest.mark.parametrize("group", ["buffers", "images"])
@pytest.mark.parametrize(
    ("uri", "allowed"),
    [
        ("part.bin", True),
        ("data:application/octet-stream;base64,AAAA", True),
        ("../secret.bin", False),
        ("%2e%2e/secret.bin", False),
        ("..\\\\secret.bin", False),
        ("/etc/passwd", False),
        ("file:///etc/passwd", False),
        ("http://example.org/a.png", False),
    ],
)
def test_gltf_names_files_of_its_folder_only(
    tmp_path: Path, suffix: str, group: str, uri: str, allowed: bool
) -> None:
    content = {"asset": {"version": "2.0"}, group: [{"byteLength": 1}, {"uri": uri}]}
    data = glb(content) if suffix == ".glb" else json.dumps(content)
    path = write(tmp_path / f"a{suffix}", data)
    if allowed:
        assert inspect_scene(path)
    else:
        with pytest.raises(SceneError, match=rf"{group}\[1\].uri: .* leads out of the file's"):
            inspect_scene(path)


@pytest.mark.parametrize(
    ("data", "line"),
    [
        (glb({"asset": {}})[:-4], "cut short"),
        (glb({"asset": {}}).replace(b"\x02\0\0\0", b"\x01\0\0\0", 1), "glTF version 1"),
        (glb([1]), "no glTF"),
        (glb({}), "no glTF"),
        (b"glTF", "not a binary glTF"),
        (b"", "not a binary glTF"),
    ],
)
def test_damaged_glb_is_one_line(tmp_path: Path, data: bytes, line: str) -> None:
    with pytest.raises(SceneError, match=line):
        inspect_scene(write(tmp_path / "a.glb", data))


def test_obj_says_no_unit_and_reads_materials_of_its_folder_only(tmp_path: Path) -> None:
    path = write(tmp_path / "a.obj", "mtllib a.mtl\nv 0 0 0\n")
    assert inspect_scene(path) is False
    write(path, "v 0 0 0\n  mtllib ../../secret\n")
    with pytest.raises(SceneError, match=r"line 2: mtllib: '../../secret' leads out of"):
        inspect_scene(path)
    for hidden in ('mtllib "../secret"', "\x01mtllib ..\\secret", "mtllib a/../../secret"):
        with pytest.raises(SceneError, match=r"line 1: mtllib: .* leads out of"):
            inspect_scene(write(path, hidden))
    with pytest.raises(SceneError, match="line 1: mtllib goes on; expected it in one line"):
        inspect_scene(write(path, "mtllib \\\n../secret\n"))
    with pytest.raises(SceneError, match="line 1 is no text"):
        inspect_scene(write(path, b"v 0 0 0 \0\n"))


USDA = '#usda 1.0\n(\n    metersPerUnit = 0.01\n)\ndef "a" (references = @{}@</b>) {{}}\n'


def test_text_usd_names_files_of_its_folder_only(tmp_path: Path) -> None:
    path = write(tmp_path / "a.usda", USDA.format("parts/chair.usd"))
    assert inspect_scene(path) is True
    assert inspect_scene(write(path, "#usda 1.0\n")) is False
    for outside in ("../chair.usd", "/home/chair.usd"):
        with pytest.raises(SceneError, match=f"asset: '{outside}' leads out of"):
            inspect_scene(write(path, USDA.format(outside)))


def test_what_usd_files_name_is_looked_into(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    path = write(tmp_path / "a.usda", USDA.format("parts/chair.usd"))
    write(tmp_path / "parts" / "chair.usd", crate("../wood.png", "../a.usda", "leg.usda"))
    write(tmp_path / "parts" / "leg.usda", USDA.format("chair.usd"))
    assert inspect_scene(path) is True
    write(tmp_path / "parts" / "leg.usda", USDA.format("../../leg.usd"))
    with pytest.raises(SceneError, match=r"asset: '../../leg.usd' leads out of"):
        inspect_scene(path)


def test_packed_usd_is_looked_into(tmp_path: Path) -> None:
    path = tmp_path / "a.usdz"
    for target, fine in (("b.usda", True), ("../b.usda", False)):
        with zipfile.ZipFile(path, "w") as package:
            package.writestr("a.usda", USDA.format(target))
            package.writestr("texture.png", b"@../not_usd@")
        if fine:
            assert inspect_scene(path) is True
        else:
            with pytest.raises(SceneError, match=r"'../b.usda' leads out of"):
                inspect_scene(path)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as package:
        package.writestr("a.usda", USDA.format("b.usda") + " " * 10_000)
    with pytest.raises(SceneError, match="no USD"):
        inspect_scene(path)
    write(path, path.read_bytes()[:80])
    with pytest.raises(SceneError, match="cut short, damaged, or no USD"):
        inspect_scene(path)


def lz4_literals(data: bytes) -> bytes:
    """A block without any copy."""
    rest, more = len(data) - 15, b""
    if rest < 0:
        return bytes([len(data) << 4]) + data
    while rest >= 255:
        more, rest = more + b"\xff", rest - 255
    return b"\xf0" + more + bytes([rest]) + data


def crate(*strings: str) -> bytes:
    """The frame of a binary USD file with its table of strings."""
    table = b"".join(text.encode() + b"\0" for text in strings)
    packed = b"\0" + lz4_literals(table)
    tokens = struct.pack("<3q", len(strings), len(table), len(packed)) + packed
    head = b"PXR-USDC" + bytes(8) + struct.pack("<q", 24 + len(tokens))
    return head + tokens + struct.pack("<q16s2q", 1, b"TOKENS", 24, len(tokens))


def test_binary_usd_names_files_of_its_folder_only(tmp_path: Path) -> None:
    path = write(tmp_path / "a.usdc", crate("metersPerUnit", "parts/chair.usd", "/World/Chair"))
    assert inspect_scene(path) is True
    assert inspect_scene(write(path, crate("upAxis"))) is False
    for outside in ("../chair.usdc", "/home/wood.PNG", "textures/../../wood.png"):
        with pytest.raises(SceneError, match=f"asset: '{outside}' leads out of"):
            inspect_scene(write(path, crate("x" * 600, outside)))
    with pytest.raises(SceneError, match="cut short"):
        inspect_scene(write(path, crate("upAxis")[:-20]))


def test_lz4_copies_what_came_before() -> None:
    # 'ab', then 6 bytes from 2 back (overlapping itself), then 'c'.
    assert _lz4(b"\x22ab\x02\x00\x10c") == b"ab" + b"ababab" + b"c"
    # A copy of 4 + 15 + 1 bytes from 1 back.
    assert _lz4(b"\x1fa\x01\x00\x01\x00") == b"a" * 21
    with pytest.raises(ValueError, match="block"):
        _lz4(b"\x10a\x05\x00")


def test_other_suffixes_and_missing_files_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"unknown suffix; expected one of .blend, "):
        inspect_scene(tmp_path / "a.max")
    for suffix in FORMATS:
        with pytest.raises(SceneError, match="cannot be read: No such file"):
            inspect_scene(tmp_path / f"a{suffix}")
