"""Finished frames, kept safe beside the map until they are packed into it.

Rendering a map takes hours and may be stopped at any instant; changing an
HDF5 file in place is not safe against that. So each finished frame is appended
to ``MAP.frames`` and forced to disk, and `FrameJournal.pack` merges the journal
into a new copy of the map, renames that over the map, and only then removes the
journal. Whatever instant it dies at:

- while appending: the record is cut off, its checksum does not match, and the
  next opening drops it; that one frame is rendered again;
- while packing: the half-written copy is thrown away, map and journal are whole;
- between rename and removal: the frames are in the map *and* in the journal;
  packing them again changes nothing.

The journal begins with one line of JSON that names the map, the camera and the
preset of its frames, so that frames of two cameras, two presets or two maps
never mix. The records that follow are those of `dataset.records`.
"""

from __future__ import annotations

import hashlib
import heapq
import json
import os
import zlib
from collections.abc import Callable, Iterable, Iterator, Set
from contextlib import ExitStack, suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import BinaryIO

import h5py
import numpy as np
from numpy.typing import NDArray

from dataset.atomic import force_to_disk, locked, remove_leftovers, replacing, unwritten
from dataset.camera import FisheyeCamera
from dataset.closing import Closing
from dataset.errors import FormatError
from dataset.frames import (
    Frame,
    Radiance,
    pack_image,
    pack_radiance,
    put_images,
    stored_frames,
    unpack_radiance,
)
from dataset.layout import decode_camera, encode_camera
from dataset.records import RECORD, Entry, packed, records, seal, unpacked
from dataset.rewriting import rewriting
from dataset.storage import OWN_CAMERA, MapFile
from dataset.topomap import TopoMap

__all__ = ["FrameJournal", "discard_frames", "journal_path"]

MAGIC = b"roomseg-frames 1 "
LONGEST_HEADER = 65536
Expose = Callable[[int, NDArray[np.float32]], tuple[NDArray[np.uint8], float]]
"""From a node and its radiance to its image and exposure gain."""


def journal_path(path: str | Path) -> Path:
    """Name the journal of a map file."""
    return Path(f"{Path(path).resolve()}.frames")


def _fingerprint(topomap: TopoMap) -> str:
    """Tells maps apart, but not a map from itself with other labels."""
    digest = hashlib.sha256(f"{topomap.environment}/{topomap.run}/{topomap.seed}".encode())
    poses = topomap.nodes.camera_pose
    digest.update((topomap.nodes.position if poses is None else poses).tobytes())
    digest.update((topomap.scene or "").encode())
    return digest.hexdigest()


class FrameJournal(Closing):
    """The one writer of a map's images. Use it as a context manager.

    Parameters
    ----------
    path : path
        The map file.
    camera : FisheyeCamera, optional
        The camera of the frames that will be appended; the map's if absent.
        If it differs, packing makes it the map's camera.
    preset : str
        Name of the render settings; empty if they do not matter.
    keep_radiance : bool
        Keep the radiance of every image, too. A map that does goes on to do so.

    Raises
    ------
    FormatError
        If the map is unreadable, or it or its journal already holds frames of
        another camera, preset or map, or without the radiance that is to be kept.
    RoomsegError
        If another process is writing to the map.
    """

    def __init__(
        self,
        path: str | Path,
        camera: FisheyeCamera | None = None,
        preset: str = "",
        *,
        keep_radiance: bool = False,
    ) -> None:
        self.path = Path(path)
        self._journal = journal_path(path)
        self._stream: BinaryIO | None = None
        with MapFile(self.path) as file:
            self.camera = camera or file.topomap.camera
        self.preset = preset
        self.keeps_radiance = keep_radiance
        with ExitStack() as stack:
            stack.enter_context(locked(self.path))
            remove_leftovers(self.path)
            remove_leftovers(self._journal)
            self._read_map()
            self._entries = self._read_journal() if self._journal.exists() else {}
            self._done = self._packed | self._entries.keys()
            self._stack = stack.pop_all()

    def close(self) -> None:
        """Let go of the map; what was appended stays in the journal."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None
        self._stack.close()

    @property
    def done(self) -> Set[int]:
        """Nodes whose frame is safe, in the map or in the journal; grows with `append`."""
        return self._done

    def append(
        self,
        index: int,
        image: NDArray[np.uint8],
        gain: float,
        radiance: Radiance | None = None,
    ) -> None:
        """Keep a finished frame; when this returns, it survives a crash.

        Parameters
        ----------
        index : int
            Node.
        image : array, shape ``camera.image_size``, uint8
        gain : float
            Exposure gain a.
        radiance : Radiance, optional
            Heeded if this journal keeps it, and missed.

        Raises
        ------
        FormatError
            If the node does not exist or the image has another size or type.
        RoomsegError
            If the journal cannot be written; what was appended before stays.
        """
        frame = Frame(index, pack_image(image, self.camera.image_size), gain)
        if self.keeps_radiance and radiance is not None:
            light = pack_radiance(radiance, self.camera.image_size)
            frame = replace(frame, radiance=light, exponent=radiance.exponent)
        self.add(frame)

    def add(self, frame: Frame) -> None:
        """Keep a finished frame that is packed already; as `append`."""
        index, gain = frame.index, frame.gain
        if not 0 <= index < self._node_count:
            raise FormatError(f"{self.path}: node {index}, expected 0..{self._node_count - 1}")
        if not (np.isfinite(gain) and gain > 0.0):
            raise FormatError(f"{self.path}: gain {gain} of node {index}, expected a number > 0")
        if self.keeps_radiance and not frame.radiance:
            raise FormatError(f"{self.path}: keeps radiance, but node {index} has none")
        data = packed(frame) if self.keeps_radiance else frame.pixels
        stream = self._open_stream()
        start = stream.seek(0, os.SEEK_END)
        try:
            stream.write(seal(index, data, gain) + data)
            stream.flush()
            os.fsync(stream.fileno())
        except OSError as error:
            self._drop_stream(start)
            raise unwritten(f"{self.path}.frames", error) from error
        self._entries[index] = Entry(start + RECORD.size, len(data), gain)
        self._done.add(index)

    def pack(self) -> int:
        """Merge the journal into the map and remove it.

        Returns
        -------
        int
            How many frames came from the journal.
        """
        count = len(self._entries)
        if not count:
            return 0
        self._merge()
        if self._stream is not None:
            self._stream.close()
            self._stream = None
        self._journal.unlink()
        self._entries = {}
        return count

    def expose(self, camera: FisheyeCamera, expose: Expose) -> int:
        """Make the map's images anew from the radiance that it keeps.

        Parameters
        ----------
        camera : FisheyeCamera
            The map's, but perhaps with other flaws.
        expose : callable
            From (node, radiance (h, w) float32) to (image (h, w) uint8, gain).

        Returns
        -------
        int
            How many images there are.

        Raises
        ------
        FormatError
            If the map keeps no radiance.
        """
        self.pack()
        if not self.keeps_radiance:
            raise FormatError(
                f"{self.path}: /images/radiance: missing, expected images of "
                f"`roomseg render --hdr {self.path}`"
            )
        self.camera = camera
        with rewriting(self.path, without=["images", "camera"]) as (source, target):
            frames = (_exposed(frame, expose, camera) for frame in stored_frames(source))
            self._put(source, target, frames)
        return len(self._done)

    def _merge(self) -> None:
        with rewriting(self.path, without=["images", "camera"]) as (source, target):
            old = (frame for frame in stored_frames(source) if frame.index not in self._entries)
            # Sorted by node, so that the bytes do not depend on who finished first.
            frames = heapq.merge(old, self._frames(), key=lambda frame: frame.index)
            self._put(source, target, frames)

    def _put(self, source: h5py.File, target: h5py.File, frames: Iterable[Frame]) -> None:
        """Write camera and images into the new file."""
        if decode_camera(source) != self.camera and OWN_CAMERA not in source:
            source.copy("camera", target, name=OWN_CAMERA)
        encode_camera(target, self.camera)
        put_images(
            target,
            frames,
            self._node_count,
            self.camera.image_size,
            self.preset,
            keep_radiance=self.keeps_radiance,
        )

    def _frames(self) -> Iterator[Frame]:
        with self._journal.open("rb") as stream:
            for index, entry in sorted(self._entries.items()):
                stream.seek(entry.offset)
                data = stream.read(entry.length)
                yield unpacked(index, entry.gain, data, with_radiance=self.keeps_radiance)

    def _read_map(self) -> None:
        with MapFile(self.path) as file:
            topomap, done = file.topomap, file.done
            self._node_count = len(done)
            self._packed = set(np.flatnonzero(done).tolist())
            self._fingerprint = _fingerprint(topomap)
            if self._packed:
                self._match(self.path, topomap.camera, file.preset, file.keeps_radiance)

    def _match(self, path: Path, camera: FisheyeCamera, preset: str, radiance: bool) -> None:
        """Refuse to mix frames of two cameras or presets; adopt a preset if none was given."""
        if camera != self.camera:
            raise FormatError(
                f"{path}: holds frames of a {camera.disc_diameter:g} px disc in "
                f"{camera.image_size} px, not {self.camera.disc_diameter:g} px in "
                f"{self.camera.image_size} px: one map has one camera; use the same preset, "
                "or start its images again (--force)"
            )
        if preset and self.preset and preset != self.preset:
            raise FormatError(
                f"{path}: holds frames of preset {preset!r}, not {self.preset!r}: use the same "
                "preset, or start its images again (--force)"
            )
        if self.keeps_radiance and not radiance:
            raise FormatError(
                f"{path}: holds frames without radiance: go on without --hdr, or start its "
                "images again (--force)"
            )
        self.preset = self.preset or preset
        self.keeps_radiance = radiance

    def _header(self) -> bytes:
        fields = {
            "map": self._fingerprint,
            "camera": asdict(self.camera),
            "preset": self.preset,
            "radiance": self.keeps_radiance,
        }
        text = json.dumps(fields, sort_keys=True).encode()
        return MAGIC + b"%08x " % zlib.crc32(text) + text + b"\n"

    def _open_stream(self) -> BinaryIO:
        """Open the journal for appending; begin it atomically, so its header is never torn."""
        if self._stream is None:
            if not self._journal.exists():
                with replacing(self._journal) as part:
                    part.write_bytes(self._header())
            self._stream = self._journal.open("r+b")
        return self._stream

    def _drop_stream(self, end: int) -> None:
        """Forget what is behind ``end``; closing would try to write it again."""
        stream, self._stream = self._stream, None
        assert stream is not None
        with suppress(OSError):
            stream.close()
        if self._entries:
            os.truncate(self._journal, end)
        else:
            self._journal.unlink()

    def _read_journal(self) -> dict[int, Entry]:
        with self._journal.open("r+b") as stream:
            self._check_header(stream.readline(LONGEST_HEADER))
            entries: dict[int, Entry] = {}
            end = stream.tell()
            for index, entry in records(stream):
                if not 0 <= index < self._node_count:
                    break
                entries[index] = entry
                end = stream.tell()
            stream.truncate(end)
        force_to_disk(self._journal)
        return entries

    def _check_header(self, line: bytes) -> None:
        checksum, _, text = line.removeprefix(MAGIC).rstrip(b"\n").partition(b" ")
        if not line.startswith(MAGIC) or checksum != b"%08x" % zlib.crc32(text):
            raise FormatError(f"{self._journal}: no journal of frames, remove or rename it")
        header = json.loads(text)
        if header["map"] != self._fingerprint:
            raise FormatError(
                f"{self._journal}: holds frames of another map than {self.path.name}, remove it"
            )
        camera, radiance = FisheyeCamera.of(header["camera"]), bool(header.get("radiance"))
        self._match(self._journal, camera, header["preset"], radiance)


def _exposed(frame: Frame, expose: Expose, camera: FisheyeCamera) -> Frame:
    """The same frame with an image made anew."""
    radiance = unpack_radiance(frame.radiance, frame.exponent, camera.image_size)
    image, gain = expose(frame.index, radiance.light)
    return replace(frame, pixels=pack_image(image, camera.image_size), gain=gain)


def discard_frames(path: str | Path) -> None:
    """Remove all images of a map, packed or not, to render them anew.

    The map gets back the camera that it had before it was rendered.

    Raises
    ------
    RoomsegError
        If the map is unreadable, or another process is writing to it.
    """
    with MapFile(path) as file:
        has_images = bool(file.done.any())
    with locked(path):
        journal_path(path).unlink(missing_ok=True)
        if has_images:
            with rewriting(path, without=["images", "camera", OWN_CAMERA]) as (source, target):
                camera = OWN_CAMERA if OWN_CAMERA in source else "camera"
                source.copy(camera, target, name="camera")
