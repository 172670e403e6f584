"""A run to be replayed in a page: a slider, a button that moves it, and the robot (Bokeh)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from bokeh.layouts import row
from bokeh.models import (
    CheckboxGroup,
    ColumnDataSource,
    CustomJS,
    NumeralTickFormatter,
    Slider,
    Toggle,
)
from numpy.typing import NDArray

from roomseg.browser.map_layers import MapLayers
from roomseg.browser.shell import WIDTH

__all__ = ["SECONDS", "replay_controls", "robot_sources"]

Floats = NDArray[np.float64]

SECONDS = 30
"""How long a run is when it is played."""
MOUTH = 0.45
"""Half of the angle that is left out of the robot's disc where it looks, rad."""
NOT_YET = 0.12
"""Opacity of nodes that are not there yet."""
REPLAY = """
const now = slider.value
const over = now >= slider.end
const count = (times) => over ? times.length : times.findLastIndex((time) => time <= now) + 1
const first = (values, end) => new Float64Array(values.buffer, values.byteOffset, end)
for (const [source, times, x, y] of tracks) {
  const end = count(times)
  source.data = {x: first(x, end), y: first(y, end)}
}
const made = Array.from(nodes.data.time, (time) => over || time <= now ? 1 : not_yet)
nodes.data = {...nodes.data, made}
if (!over) layers.active = [...new Set([...layers.active, ...paths])]
const at = Math.max(0, count(pose_times) - 1)
for (const [source, x, y, heading] of robots) {
  const data = {x: [], y: [], start: [], end: []}
  if (!over) {
    data.x.push(x[at])
    data.y.push(y[at])
    data.start.push(heading[at] + mouth)
    data.end.push(heading[at] + 2 * Math.PI - mouth)
  }
  source.data = data
}
"""
PLAY = """
toggle.label = toggle.active ? "\\u23f8 Pause" : "\\u25b6 Play"
if (!toggle.active) return
if (slider.value >= slider.end) slider.value = slider.start
let last = performance.now()
const step = (now) => {
  if (!toggle.active) return
  const moved = slider.value + (now - last) / 1000 * slider.end / seconds
  last = now
  slider.value = Math.min(slider.end, moved)
  if (slider.value >= slider.end) toggle.active = false
  else requestAnimationFrame(step)
}
requestAnimationFrame(step)
"""


def robot_sources(layers: MapLayers) -> dict[str, ColumnDataSource]:
    """Where the robot is shown, by the layer of its path; nowhere at first."""
    empty: dict[str, list[float]] = {key: [] for key in ("x", "y", "start", "end")}
    return {name: ColumnDataSource(dict(empty), name=f"robot, {name}") for name in layers.poses}


def replay_controls(
    layers: MapLayers,
    nodes: ColumnDataSource,
    switch: CheckboxGroup,
    robots: Mapping[str, ColumnDataSource],
) -> list[Any]:
    """Slider and button; nothing if the map does not know the driven path.

    Parameters
    ----------
    layers : MapLayers
    nodes : ColumnDataSource
        With the columns ``time``, s, and ``made``, the opacity.
    switch : CheckboxGroup
        Of the layers.
    robots : mapping of ColumnDataSource
        Of `robot_sources`.
    """
    if not robots:
        return []
    end = float(np.ceil(layers.pose_times[-1])) or 1.0
    slider = Slider(
        start=0.0,
        end=end,
        step=1.0,
        value=end,
        title="time of the run",
        format=NumeralTickFormatter(format="00:00:00"),
        width=WIDTH - 125,
        name="time",
    )
    # The first of them is drawn above the others: where the robot really was.
    shown = "true path" if "true path" in robots else "estimated path"
    arguments = {
        "slider": slider,
        "tracks": [
            [track.source, track.time, track.source.data["x"], track.source.data["y"]]
            for track in layers.tracks.values()
        ],
        "nodes": nodes,
        "layers": switch,
        "paths": [switch.labels.index(shown)],
        "pose_times": layers.pose_times,
        "robots": [
            [source, *np.ascontiguousarray(layers.poses[name].T)] for name, source in robots.items()
        ],
        "mouth": MOUTH,
        "not_yet": NOT_YET,
    }
    slider.js_on_change("value", CustomJS(args=arguments, code=REPLAY))
    toggle = Toggle(label="▶ Play", width=90, name="play", margin=(14, 5, 5, 5))
    playing = {"toggle": toggle, "slider": slider, "seconds": SECONDS}
    toggle.js_on_change("active", CustomJS(args=playing, code=PLAY))
    return [row(toggle, slider)]
