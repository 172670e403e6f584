"""Fisheye images of every map node by Blender Cycles (§3.1).

The only home of bpy, which is loaded in a child process when a frame is about to
be rendered, and never by importing this package.
"""

from render.exposure import expose
from render.job import expose_map, render_map
from render.map_work import Outcome, Wanted
from render.presets import PRESETS, Preset, preset_named

__all__ = [
    "PRESETS",
    "Outcome",
    "Preset",
    "Wanted",
    "expose",
    "expose_map",
    "preset_named",
    "render_map",
]
