"""What a map is: arrays, the camera model, and the HDF5 map file."""

from dataset.borders import borders_between, crosses_border
from dataset.camera import REAL_CAMERA, SIMULATED_CAMERA, CameraFlaws, FisheyeCamera
from dataset.errors import FormatError, RoomsegError
from dataset.frames import Images, Radiance
from dataset.inspection import Summary, summarise
from dataset.journal import FrameJournal, discard_frames
from dataset.rewriting import write_ground_truth, write_rooms
from dataset.storage import MapFile, Rooms, read_map, write_map
from dataset.topomap import GroundTruth, Nodes, Obstacles, Path, Settings, TopoMap, Visits
from dataset.validation import problems

open = MapFile
"""``with dataset.open("map.h5") as m: ...``"""

__all__ = [
    "REAL_CAMERA",
    "SIMULATED_CAMERA",
    "CameraFlaws",
    "FisheyeCamera",
    "FormatError",
    "FrameJournal",
    "GroundTruth",
    "Images",
    "MapFile",
    "Nodes",
    "Obstacles",
    "Path",
    "Radiance",
    "Rooms",
    "RoomsegError",
    "Settings",
    "Summary",
    "TopoMap",
    "Visits",
    "borders_between",
    "crosses_border",
    "discard_frames",
    "open",
    "problems",
    "read_map",
    "summarise",
    "write_ground_truth",
    "write_map",
    "write_rooms",
]
