"""Generated apartments: valid, connected, of the size asked for, the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import Polygon

from scenes.apartment import Apartment
from scenes.checks import check
from scenes.errors import SceneError
from scenes.floorplan import draw_plan
from scenes.generator import generate_apartment
from scenes.materials import resolve
from scenes.passages import passage_rooms
from scenes.solids import floor_region, obstacles
from scenes.storage import apartment_from_json, apartment_to_json

SEEDS = range(30)


def wishes(seed: int) -> dict:
    """Room counts from 2 to 10, small and large homes, all contrasts and lights."""
    rooms = 2 + seed % 9
    return {
        "rooms": rooms,
        "area": rooms * (9.0 + 1.5 * (seed % 4)),
        "contrast": ("low", "medium", "high")[seed % 3],
        "lighting": ("exterior", "interior", "mixed")[seed // 3 % 3],
    }


@pytest.fixture(scope="module")
def homes() -> dict[int, Apartment]:
    return {seed: generate_apartment(seed, **wishes(seed)) for seed in SEEDS}


def joins(apartment: Apartment) -> list[tuple[int, int]]:
    return [passage_rooms(apartment, p) for p in apartment.passages if not p.closed]


def reachable(apartment: Apartment, radius: float) -> shapely.Geometry:
    """The connected free floor around the start, by way of shapely alone."""
    free = floor_region(apartment).buffer(-radius).difference(obstacles(apartment).buffer(radius))
    return min(shapely.get_parts(free), key=shapely.Point(apartment.start.position).distance)


@pytest.mark.parametrize("seed", SEEDS)
def test_valid(homes: dict[int, Apartment], seed: int) -> None:
    assert list(check(homes[seed])) == []
    text = apartment_to_json(homes[seed])
    assert apartment_from_json(text) == homes[seed]


@pytest.mark.parametrize("seed", SEEDS)
def test_what_was_asked_for(homes: dict[int, Apartment], seed: int) -> None:
    home, asked = homes[seed], wishes(seed)
    assert len(home.rooms) == asked["rooms"]
    area = sum(Polygon(room.polygon).area for room in home.rooms)
    assert area == pytest.approx(asked["area"], rel=0.02)
    assert home.passageway_contrast == asked["contrast"]
    assert home.lighting.source == asked["lighting"]


@pytest.mark.parametrize("seed", SEEDS)
def test_robot_reaches_every_room(homes: dict[int, Apartment], seed: int) -> None:
    home = homes[seed]
    driven = reachable(home, 0.15)
    for room in home.rooms:
        assert driven.intersection(Polygon(room.polygon)).area > 0.2, room.name


@pytest.mark.parametrize("seed", SEEDS)
def test_doors_join_all_rooms_and_none_through_a_bathroom(
    homes: dict[int, Apartment], seed: int
) -> None:
    home = homes[seed]
    pairs = joins(home)
    reached = {0}
    for _ in home.rooms:
        reached |= {room for pair in pairs if set(pair) & reached for room in pair}
    assert reached == set(range(len(home.rooms)))
    for index, room in enumerate(home.rooms):
        if room.kind in ("bathroom", "storage"):
            assert sum(index in pair for pair in pairs) == 1


def test_density_is_like_table_8(homes: dict[int, Apartment]) -> None:
    """15.4 to 22.4 nodes per m² of floor in the paper, at 0.03 m² each."""
    density = []
    for home in homes.values():
        area = sum(Polygon(room.polygon).area for room in home.rooms)
        density.append(reachable(home, 0.15).area / 0.03 / area)
    assert 15.0 <= np.median(density) <= 22.5
    assert min(density) > 11.0
    assert max(density) < 25.0


def test_furniture_leaves_doorways_free(homes: dict[int, Apartment]) -> None:
    for home in homes.values():
        solid = obstacles(home)
        for passage in home.passages:
            if not passage.closed:
                spot = shapely.Point(passage.position)
                assert solid.distance(spot) >= passage.width / 2 - 0.03


def test_homes_have_what_homes_have(homes: dict[int, Apartment]) -> None:
    for home in homes.values():
        kinds = [room.kind for room in home.rooms]
        assert "living_room" in kinds
        assert "bathroom" in kinds
        assert sum(passage.closed for passage in home.passages) == 1
        pieces = {piece.kind for piece in home.furniture}
        assert {"toilet"} <= pieces
        for room in home.rooms:
            shape = Polygon(room.polygon)
            assert any(shape.covers(shapely.Point(lamp.position)) for lamp in home.lamps)
            if room.kind in ("living_room", "bedroom", "office"):
                gaps = [shape.distance(shapely.Point(w.position)) for w in home.windows]
                assert min(gaps) < 0.2, room.name


def test_frames_follow_the_contrast(homes: dict[int, Apartment]) -> None:
    for home in homes.values():
        weights = (0.2126, 0.7152, 0.0722)
        frame = home.passages[0].frame
        assert frame is not None
        hub = next(room for room in home.rooms if room.kind == "living_room")
        wall = np.dot(resolve(home, hub.walls).colour, weights)
        difference = abs(np.dot(resolve(home, frame.material).colour, weights) - wall)
        low, high = {"low": (0.0, 0.06), "medium": (0.08, 0.5), "high": (0.4, 0.9)}[
            home.passageway_contrast
        ]
        assert low <= difference <= high


@pytest.mark.parametrize("seed", [0, 7, 2**40])
def test_same_seed_same_bytes(seed: int) -> None:
    first = apartment_to_json(generate_apartment(seed, rooms=4))
    assert apartment_to_json(generate_apartment(seed, rooms=4)) == first
    assert apartment_to_json(generate_apartment(seed + 1, rooms=4)) != first


def test_seeds_give_different_plans(homes: dict[int, Apartment]) -> None:
    shapes = {str([(room.kind, room.polygon) for room in home.rooms]) for home in homes.values()}
    assert len(shapes) == len(homes)
    floors = {room.floor for home in homes.values() for room in home.rooms}
    assert len(floors) > 6


def test_one_room_and_twelve() -> None:
    assert len(generate_apartment(1, rooms=1, area=20.0).rooms) == 1
    assert len(generate_apartment(1, rooms=12, area=150.0).rooms) == 12


def test_no_plan_is_said_in_one_line() -> None:
    with pytest.raises(SceneError, match=r"^rooms, area: .*5 rooms on 25 m².*expected") as caught:
        generate_apartment(0, rooms=5, area=25.0)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("wrong", "field"),
    [
        ({"rooms": 0}, "rooms"),
        ({"rooms": 13}, "rooms"),
        ({"rooms": 2.5}, "rooms"),
        ({"rooms": True}, "rooms"),
        ({"area": 5.0}, "area"),
        ({"area": 1e6}, "area"),
        ({"area": float("nan")}, "area"),
        ({"area": "50"}, "area"),
        ({"contrast": "loud"}, "contrast"),
        ({"lighting": "dark"}, "lighting"),
        ({"seed": -1}, "seed"),
    ],
)
def test_refused_values_in_one_line(wrong: dict, field: str) -> None:
    values = {"seed": 1, **wrong}
    with pytest.raises(SceneError) as caught:
        generate_apartment(values.pop("seed"), **values)
    message = str(caught.value)
    assert message.startswith(f"{field}: ")
    assert "expected" in message
    assert "\n" not in message


def test_plan_fills_the_rectangle_without_overlap() -> None:
    """Cells tile the rectangle of the outer centre lines exactly."""
    rng = np.random.default_rng(5)
    plans = [plan for plan in (draw_plan(rng, 6, 66.0) for _ in range(30)) if plan is not None]
    assert plans
    for plan in plans:
        cells = [shapely.box(c.x0, c.y0, c.x1, c.y1) for c in plan.cells]
        outline = shapely.box(0.0, 0.0, *plan.size)
        assert shapely.union_all(cells).symmetric_difference(outline).area < 1e-6
        assert sum(cell.area for cell in cells) == pytest.approx(outline.area, abs=1e-6)
