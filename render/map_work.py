"""A map whose images are being made: what is to be rendered, and the journal that keeps it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from dataset.camera import FisheyeCamera
from dataset.closing import Closing
from dataset.errors import FormatError, RoomsegError
from dataset.journal import FrameJournal, discard_frames
from dataset.storage import read_map
from dataset.topomap import TopoMap
from render.blender import render_window
from render.cycles import Device
from render.lighting import missing_light
from render.presets import Preset
from render.process import Job
from scenes.apartment import Apartment
from scenes.errors import SceneError
from scenes.storage import apartment_from_json

__all__ = ["MapWork", "Outcome", "Wanted"]


@dataclass(frozen=True)
class Wanted:
    """What images are wanted of each map; see `render.render_map`."""

    preset: Preset
    limit: int | None = None
    threads: int | None = None
    device: Device = "auto"
    hdr: bool = False
    force: bool = False
    """Throw away the images that are there."""


@dataclass(frozen=True)
class Outcome:
    """What became of a map: how many new images, and what went wrong, if something did."""

    path: Path
    count: int
    problem: RoomsegError | SceneError | OSError | None = None


class MapWork(Closing):
    """The images that a map lacks. Use it as a context manager, or close it.

    Parameters
    ----------
    path : path
    wanted : Wanted
    nodes : iterable of int, optional
        All if absent.

    Attributes
    ----------
    job : Job
    poses : array, shape (n, 3) or (n, 5)
        True poses of all nodes.
    journal : FrameJournal
    missing : deque of int
        Nodes to be rendered; who takes some of them removes them.
    total : int
        Images that there will be.

    Raises
    ------
    FormatError, RoomsegError
        See `render.render_map`.
    """

    def __init__(
        self, path: str | Path, wanted: Wanted, nodes: Iterable[int] | None = None
    ) -> None:
        self.path = Path(path)
        if wanted.force:
            discard_frames(path)
        topomap = read_map(path)
        apartment = _apartment(path, topomap)
        preset = wanted.preset
        camera = _camera(path, topomap, preset)
        poses = topomap.nodes.camera_pose
        assert poses is not None
        folder = str(self.path.resolve().parent)
        self.job = Job(
            apartment, camera, preset, wanted.threads, wanted.device, topomap.seed, folder
        )
        self.poses = poses
        self.journal = FrameJournal(path, camera, preset.name, keep_radiance=wanted.hdr)
        chosen = range(len(topomap.nodes)) if nodes is None else sorted(set(nodes))
        done = self.journal.done
        self.missing = deque([i for i in chosen if i not in done][: wanted.limit])
        self.total = len(done) + len(self.missing)

    def close(self) -> None:
        """Pack what was rendered into the map, and let go of it."""
        try:
            self.journal.pack()
        finally:
            self.journal.close()


def _camera(path: str | Path, topomap: TopoMap, preset: Preset) -> FisheyeCamera:
    """The camera to render; FormatError if Blender cannot place its disc."""
    camera = preset.camera(topomap.camera)
    try:
        render_window(camera)
    except ValueError as error:
        raise FormatError(f"{path}: /camera: {error}") from error
    return camera


def _apartment(path: str | Path, topomap: TopoMap) -> Apartment:
    """The map's own apartment; FormatError if the map cannot be rendered."""
    if topomap.scene is None:
        raise FormatError(f"{path}: /scene: missing, only simulated maps can be rendered")
    if topomap.nodes.true_pose is None:
        raise FormatError(f"{path}: /nodes/true_pose: missing, only simulated maps can be rendered")
    try:
        apartment = apartment_from_json(topomap.scene, origin=f"{path}: /scene")
    except SceneError as error:
        raise FormatError(str(error)) from error
    if apartment.scene_file is None and (missing := missing_light(apartment)) is not None:
        source = apartment.lighting.source
        raise FormatError(
            f"{path}: /scene: lighting.source {source!r}: nothing gives light; expected {missing}"
        )
    return apartment
