"""Lamps, sun, sky and windows (Table 8: interior, exterior or mixed light).

The paper says only that some environments are lit mostly by interior lamps and
others mostly through windows. Chosen here: 'interior' has all lamps on and the
sky at dusk (a tenth), 'exterior' the lamps off, 'mixed' daylight with dimmed lamps
(a tenth), since a sky of radiance 1 W/m²/sr brings only a few watts through a
window. The exposure of §3.1 removes the common factor; only ratios matter. The watts of
a lamp are those on the box of an incandescent bulb (13.4 lm each), and shine as if all
of them were light: measured by them, a sky of 1 W/m²/sr in 'mixed' is one of 134 cd/m²,
as around sunset, when lamps are on and windows still light a room.

A lamp is its glowing body: every face of it shines, so that the ceiling around it is
lit as well. Windows are open holes. The sky is only seen; what it sheds enters through
an area light in each window that no camera sees, so that the light tree can choose
among windows (portals are all sampled alike, however many walls lie between). Below
the horizon there is ground, a quarter as bright as the sky.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from shapely import Point as ShapelyPoint
from shapely import Polygon

from render.nodes import add_math
from scenes.apartment import Apartment, Window
from scenes.openings import place

__all__ = [
    "SHARES",
    "add_lighting",
    "add_outdoor_light",
    "lamp_radiance",
    "missing_light",
    "window_frame",
]

SHARES = {"interior": (1.0, 0.1), "exterior": (0.0, 1.0), "mixed": (0.1, 1.0)}
"""Share of the lamps' power and of the daylight, by `Lighting.source`."""

SKY_COLOUR = (0.80, 0.92, 1.10)
GROUND_COLOUR = (0.26, 0.25, 0.22)
SUN_DIAMETER = float(np.radians(0.53))
WINDOW_INSET = 0.01


def add_lighting(
    bpy: Any, scene: Any, apartment: Apartment, *, windows_gleam: bool = False
) -> None:
    """Add sun, sky and windows of ``apartment`` to the Blender ``scene``.

    ``windows_gleam``: what shines mirrors the lights in the windows instead of the sky
    behind them. That is the same, and much quieter where gloss is broad: lights are
    aimed at, the sky is met by chance.
    """
    light = apartment.lighting
    strength = SHARES[light.source][1] * light.sky_strength
    _set_sky(bpy, scene, strength, gleams=not windows_gleam)
    _add_sun(bpy, scene, apartment)
    if strength > 0.0:
        for window in apartment.windows:
            _add_window(bpy, scene, apartment, window, strength, gleams=windows_gleam)


def add_outdoor_light(bpy: Any, scene: Any, apartment: Apartment, *, sky: bool) -> None:
    """Add the sun, and perhaps a sky that lights by itself, to a scene of unknown windows."""
    _add_sun(bpy, scene, apartment)
    if sky:
        strength = SHARES[apartment.lighting.source][1] * apartment.lighting.sky_strength
        _set_sky(bpy, scene, strength, lights=True)


def missing_light(apartment: Apartment) -> str | None:
    """What an apartment without a scene of its own needs, so that its images are not black.

    ``None`` if lamps that are on, or windows by day or at dusk, light it. 'interior' is
    the light of lamps; the dusk alone is not what was asked for.
    """
    light = apartment.lighting
    if apartment.lamps and SHARES[light.source][0] > 0.0:
        return None
    if light.source == "interior":
        return "`lamps`; or `windows`, with the source 'exterior' or 'mixed'"
    if not any(window_frame(apartment, window) is not None for window in apartment.windows):
        both = "`lamps` or `windows` to the outside"
        alone = "`windows` to the outside; or `lamps`, with the source 'interior' or 'mixed'"
        return both if light.source == "mixed" else alone
    sun_is_up = light.sun_strength > 0.0 and light.sun_elevation_deg > 0.0
    if light.sky_strength > 0.0 or sun_is_up:
        return None
    return "a `sky_strength` above 0, or a sun"


def lamp_radiance(apartment: Apartment, index: int, area: float) -> float:
    """Radiance of lamp ``index`` whose body has ``area`` m² of surface, W/m²/sr.

    A diffusely shining surface of radiance L and area A sends out pi L A watts.
    """
    power = SHARES[apartment.lighting.source][0] * apartment.lamps[index].power
    return power / (np.pi * area)


def _add_light(bpy: Any, scene: Any, kind: str, name: str) -> Any:
    """A new light object of ``kind``; its data is ``object.data``."""
    made = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
    scene.collection.objects.link(made)
    return made


def _add_sun(bpy: Any, scene: Any, apartment: Apartment) -> None:
    """The sun, if it is up; its azimuth is counted counter-clockwise from +x."""
    light = apartment.lighting
    by_day = SHARES[light.source][1] == 1.0
    if not by_day or light.sun_strength <= 0.0 or light.sun_elevation_deg <= 0.0:
        return
    made = _add_light(bpy, scene, "SUN", "sun")
    made.data.energy = light.sun_strength
    made.data.angle = SUN_DIAMETER
    made.data.color = (1.0, 0.93, 0.84)
    # A light shines along its -z axis; tilt it by the zenith angle, then turn it.
    zenith = np.radians(90.0 - light.sun_elevation_deg)
    made.rotation_euler = (0.0, zenith, np.radians(light.sun_azimuth_deg))


def _set_sky(
    bpy: Any, scene: Any, strength: float, *, lights: bool = False, gleams: bool = True
) -> None:
    """The sky, W/m²/sr; mostly it is only seen, and the window lights do the lighting."""
    world = bpy.data.worlds.new("sky")
    if world.node_tree is None:
        world.use_nodes = True
    world.cycles.sampling_method = "AUTOMATIC" if lights else "NONE"
    scene.world = world
    tree = world.node_tree
    tree.nodes.clear()
    direction = tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"]
    background = tree.nodes.new("ShaderNodeBackground")
    tree.links.new(_sky_colour(tree, direction, upward=1.0), background.inputs["Color"])
    if lights:
        background.inputs["Strength"].default_value = strength
    else:
        path = tree.nodes.new("ShaderNodeLightPath")
        seen = path.outputs["Is Camera Ray"]
        if gleams:
            seen = add_math(tree, "MAXIMUM", seen, path.outputs["Is Glossy Ray"])
        tree.links.new(add_math(tree, "MULTIPLY", seen, strength), background.inputs["Strength"])
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])


def _sky_colour(tree: Any, direction: Any, upward: float) -> Any:
    """Uniform sky over a darker ground; ``direction`` times ``upward`` points at them."""
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(direction, split.inputs[0])
    ramp = tree.nodes.new("ShaderNodeMapRange")
    ramp.inputs["From Min"].default_value = -0.05 * upward
    ramp.inputs["From Max"].default_value = 0.05 * upward
    tree.links.new(split.outputs["Z"], ramp.inputs["Value"])
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    mix.inputs[6].default_value = (*GROUND_COLOUR, 1.0)
    mix.inputs[7].default_value = (*SKY_COLOUR, 1.0)
    tree.links.new(ramp.outputs[0], mix.inputs["Factor"])
    return mix.outputs[2]


def window_frame(
    apartment: Apartment, window: Window
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Middle of a window's outer face (2,), m, and the unit normal into the room (2,).

    ``None`` if there is a room on both sides or on neither: such a window sees no sky.
    """
    opening = place(apartment, window.position, window.width)
    reach = 0.5 * opening.thickness + 0.05
    inside = [
        any(
            Polygon(room.polygon).covers(ShapelyPoint(opening.centre + s * reach * opening.across))
            for room in apartment.rooms
        )
        for s in (1.0, -1.0)
    ]
    if inside[0] == inside[1]:
        return None
    inward = opening.across if inside[0] else -opening.across
    return opening.centre - (0.5 * opening.thickness + WINDOW_INSET) * inward, inward


def _add_window(
    bpy: Any,
    scene: Any,
    apartment: Apartment,
    window: Window,
    strength: float,
    *,
    gleams: bool,
) -> None:
    """The sky's light through one window: an area light that no camera sees."""
    frame = window_frame(apartment, window)
    if frame is None:
        return
    middle, inward = frame
    made = _add_light(bpy, scene, "AREA", "window")
    made.visible_camera = False
    made.visible_glossy = gleams
    made.location = (*middle, 0.5 * (window.sill_height + window.head_height))
    # Turned upright (x stays horizontal), -z of the light must point along `inward`.
    turn = float(np.arctan2(inward[1], inward[0])) - np.pi / 2.0
    made.rotation_euler = (np.pi / 2.0, 0.0, turn)
    light = made.data
    light.shape = "RECTANGLE"
    light.size = window.width
    light.size_y = window.head_height - window.sill_height
    # An area light of P watts has the radiance P / (pi area).
    light.energy = np.pi * light.size * light.size_y * strength
    if light.node_tree is None:
        light.use_nodes = True
    _colour_window(light.node_tree)


def _colour_window(tree: Any) -> None:
    """Let a window's light have the colour of the sky or the ground behind it."""
    tree.nodes.clear()
    towards = tree.nodes.new("ShaderNodeNewGeometry").outputs["Incoming"]
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(_sky_colour(tree, towards, upward=-1.0), emission.inputs["Color"])
    output = tree.nodes.new("ShaderNodeOutputLight")
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
