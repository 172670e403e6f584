"""What an apartment is; reference apartments; the generator."""

from scenes.apartment import (
    Apartment,
    Frame,
    Lamp,
    Lighting,
    Material,
    Passage,
    Piece,
    Room,
    Start,
    Threshold,
    Wall,
    Window,
)
from scenes.checks import check
from scenes.errors import SceneError
from scenes.generator import generate_apartment
from scenes.mesh import Mesh, apartment_mesh
from scenes.passages import reachable_positions, room_borders
from scenes.solids import Prism, apartment_solids, floor_area, floor_region, obstacles
from scenes.storage import (
    apartment_from_json,
    apartment_to_json,
    load_apartment,
    reference_names,
    save_apartment,
)

__all__ = [
    "Apartment",
    "Frame",
    "Lamp",
    "Lighting",
    "Material",
    "Mesh",
    "Passage",
    "Piece",
    "Prism",
    "Room",
    "SceneError",
    "Start",
    "Threshold",
    "Wall",
    "Window",
    "apartment_from_json",
    "apartment_mesh",
    "apartment_solids",
    "apartment_to_json",
    "check",
    "floor_area",
    "floor_region",
    "generate_apartment",
    "load_apartment",
    "obstacles",
    "reachable_positions",
    "reference_names",
    "room_borders",
    "save_apartment",
]
