"""Random apartments: plan, openings, furniture, lamps and surfaces from one seed.

`wishes` says what may be asked for, `programme` and `sketch` divide the home
into rooms, `plan` gives them walls, `doorways` doors and windows; `site`,
`placing`, `groups` and `interiors` furnish, `finish` and `palettes` dress and
light. A draw that fails `scenes.checks.check` or leaves a room that the robot
cannot reach is thrown away and drawn again from the next sub-seed, so that a
seed always gives the same apartment. See ``docs/generator.md``.
"""

from __future__ import annotations

import numpy as np

from scenes.apartment import Apartment
from scenes.checks import check
from scenes.errors import SceneError
from scenes.generator.assembly import assemble
from scenes.generator.doorways import draw_doorways
from scenes.generator.plan import lay_out
from scenes.generator.sketch import draw_sketch
from scenes.generator.wishes import Brief, Contrast, Layout, Source, Wishes, draw_brief

__all__ = ["Wishes", "apartment_name", "generate", "generate_apartment"]

ATTEMPTS = 4000


def generate_apartment(
    seed: int,
    *,
    rooms: int | tuple[int, int] | None = None,
    area: float | tuple[float, float] | None = None,
    layout: Layout | None = None,
    wide_share: float | None = None,
    contrast: Contrast | None = None,
    lighting: Source | None = None,
    clutter: float | None = None,
    ceiling_steps: int | None = None,
    l_shapes: float | None = None,
) -> Apartment:
    """Draw a furnished apartment in which a robot reaches every room.

    The same values and seed give the same apartment; what is ``None`` is drawn
    from the seed.

    Parameters
    ----------
    seed : int
    rooms : int or (int, int)
        Number of rooms, 1 to 12, the corridor included; a pair is a range.
    area : float or (float, float)
        Clear floor area of all rooms together, m², met within 2 %; a pair is a range.
    layout : {"corridor", "hub", "open"}
        Rooms along a corridor; around a hall, or the living room of a small
        home; kitchen and living room joined by a wide opening.
    wide_share : float
        Share (0 to 1) of the passages between living room, kitchen, hall and
        such rooms that are wide, without door, frame and lintel.
    contrast : {"low", "medium", "high"}
        How far door frames stand out from the walls (Table 8).
    lighting : {"interior", "exterior", "mixed"}
        Lamps, sun and sky, or both (Table 8).
    clutter : float
        How much lies about on the floor, 0 to 1.
    ceiling_steps : int
        How many rooms have a step or beam of the ceiling where no border is, 0 to 6,
        as far as rooms have a place for one.
    l_shapes : float
        How readily rooms become L-shaped, 0 (none does) to 1.

    Returns
    -------
    Apartment

    Raises
    ------
    SceneError
        If a value is outside its range, or no valid apartment was found.
    """
    wishes = Wishes(
        rooms, area, layout, wide_share, contrast, lighting, clutter, ceiling_steps, l_shapes
    )
    return generate(seed, wishes)


def generate(seed: int, wishes: Wishes) -> Apartment:
    """`generate_apartment` for wishes that were made before.

    Raises
    ------
    SceneError
        If the seed is no whole number from 0, or no valid apartment was found.
    """
    whole = isinstance(seed, int | np.integer) and not isinstance(seed, bool)
    if not whole or not 0 <= seed < 2**63:
        raise SceneError(f"seed: {seed!r}; expected a whole number from 0 to {2**63 - 1}")
    brief = draw_brief(np.random.default_rng([seed]), wishes)
    for attempt in range(1, ATTEMPTS + 1):
        rng = np.random.default_rng([seed, attempt])
        apartment = _draw(rng, brief, apartment_name(seed, wishes))
        if apartment is not None and not any(check(apartment)):
            return apartment
    raise SceneError(
        f"rooms, area: no floor plan of {brief.rooms} rooms on {brief.area:g} m² found for seed "
        f"{seed}; expected another seed or about {13 * brief.rooms} m²"
    )


def apartment_name(seed: int, wishes: Wishes) -> str:
    """``home-SEED``, and what tells other wishes for the same seed apart."""
    return "-".join(filter(None, ("home", str(seed), wishes.tag())))


def _draw(rng: np.random.Generator, brief: Brief, name: str) -> Apartment | None:
    """One draw; None if its plan did not come out."""
    sketch = draw_sketch(rng, brief)
    plan = None if sketch is None else lay_out(rng, sketch, brief.area)
    doorways = None if plan is None else draw_doorways(rng, plan, brief)
    if plan is None or doorways is None:
        return None
    return assemble(rng, plan, doorways, brief, name)
