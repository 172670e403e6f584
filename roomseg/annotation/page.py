"""The page on which borders are drawn (Bokeh); all of its logic is in `Annotation`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.events import Pan, PanEnd, PanStart, Tap
from bokeh.layouts import column, row
from bokeh.models import CustomJS, HoverTool
from numpy.typing import NDArray
from scipy.spatial import KDTree

from dataset.errors import RoomsegError
from roomseg.annotation.panel import Panel
from roomseg.annotation.plot import MapPlot
from roomseg.annotation.pointer import Drag, border_at, line_at, pressed
from roomseg.annotation.session import Annotation

__all__ = ["AnnotationPage"]

GRIP = 9.0
"""px; so near to a border the mouse takes it."""
SHORTEST_DRAG = 4.0
"""px; less is a click."""
KEYS = {
    "ctrl+z": "undo",
    "ctrl+y": "redo",
    "ctrl+shift+Z": "redo",
    "ctrl+s": "save",
    "Delete": "delete",
    "Backspace": "delete",
    "a": "accept",
    "x": "strike",
    "Escape": "nothing",
}
SHOW_NODE = """
const node = cb_data.index.indices[0]
if (node === undefined || node === div.tags[0]) return
div.tags = [node]
const {lane, part, image} = nodes.data
const views = ["fisheye", "panorama"].map((view) => `<img src="${base}/${node}/${view}.png">`)
div.text = `<b>Node ${node}</b>, lane ${lane[node]} of part ${part[node]}<br>` +
  (image[node] ? views.join("") : "no image")
"""
TAKE_KEY = """
document.addEventListener("keydown", (event) => {
  const field = event.composedPath()[0]
  const key = (event.ctrlKey || event.metaKey ? "ctrl+" : "") +
    (event.ctrlKey && event.shiftKey ? "shift+" : "") + event.key
  if (!keys.includes(key)) return
  if (/INPUT|TEXTAREA|SELECT/.test(field.tagName)) {
    if (key != "ctrl+s") return
    field.blur()  // what was typed counts, too
  }
  event.preventDefault()
  div.tags = [key, Date.now()]
})
"""


class AnnotationPage:
    """One browser tab that shows an annotation and edits it.

    Parameters
    ----------
    annotation : Annotation
    image_url : str
        Where the server has the images of the map's nodes.
    has_image : array, shape (n,)
    others : sequence of (title, url)
        The other maps that the server has.
    """

    def __init__(
        self,
        annotation: Annotation,
        image_url: str,
        has_image: NDArray[np.bool_],
        others: tuple[tuple[str, str], ...] = (),
    ) -> None:
        self._annotation = annotation
        self.plot = MapPlot(annotation.canvas, has_image)
        self.panel = Panel(annotation, others, has_images=bool(has_image.any()))
        self._drag: Drag | None = None
        self._border: int | None = None
        self._suggestion: int | None = None
        self._tree = KDTree(annotation.canvas.position)
        self._document: Document | None = None
        self._image_url = image_url

    def show_in(self, document: Document) -> None:
        """Fill a document; it follows the annotation as long as its browser tab is open."""
        self._document = document
        # Bokeh takes callbacks of mouse events only before their model is in a document.
        self._connect()
        document.title = f"{self._annotation.path.name} - roomseg annotate"
        document.add_root(
            row(
                column(self.plot.figure, sizing_mode="stretch_both"),
                self.panel.layout,
                sizing_mode="stretch_both",
            )
        )
        self._annotation.watchers.append(self._changed)
        document.on_session_destroyed(lambda _: self._leave())
        self.refresh()

    def _leave(self) -> None:
        self._annotation.watchers.remove(self._changed)

    def _changed(self) -> None:
        assert self._document is not None
        self._document.add_next_tick_callback(self.refresh)

    def _connect(self) -> None:
        plot, panel = self.plot.figure, self.panel
        plot.on_event(Pan, self._pan)
        plot.on_event(PanEnd, self._release)
        plot.on_event(Tap, self._tap)
        arguments = {"div": panel.node, "nodes": self.plot.nodes, "base": self._image_url}
        plot.add_tools(
            HoverTool(
                renderers=[self.plot.node_glyphs],
                tooltips=None,
                visible=False,
                callback=CustomJS(args=arguments, code=SHOW_NODE),
            )
        )
        plot.on_event(PanStart, self._press)
        for name, button in panel.buttons.items():
            button.on_click(partial(self._do, name))
        panel.mode.on_change("active", self._set_mode)
        panel.count.on_change("value_throttled", self._give_count)
        panel.automatic.on_change("active", self._give_count)
        panel.rooms.selected.on_change("indices", self._show_title)
        panel.title.on_change("value", self._rename)
        panel.layers.on_change("active", self._set_layers)
        assert self._document is not None
        self._document.js_on_event(
            "document_ready", CustomJS(args={"div": panel.keys, "keys": [*KEYS]}, code=TAKE_KEY)
        )
        panel.keys.on_change("tags", self._key)

    # What is shown.

    def refresh(self) -> None:
        """Show the annotation as it is now; the browser draws it once."""
        with self._at_once():
            self._refresh()

    @contextmanager
    def _at_once(self) -> Iterator[None]:
        assert self._document is not None
        self._document.hold("combine")
        try:
            yield
        finally:
            self._document.unhold()

    def _refresh(self) -> None:
        annotation = self._annotation
        if self._border not in {border.id for border in annotation.drawing.borders}:
            self._border = None
        self.plot.show_cut(annotation.drawing, annotation.cut)
        self.plot.show_rooms(annotation.drawing)
        self._show_selected()
        self.panel.show(annotation, self.plot.colour_of)
        self._show_chosen()

    def _show_selected(self) -> None:
        annotation = self._annotation
        open_ones = annotation.open_suggestions()
        if self._suggestion not in open_ones:
            self._suggestion = None
        self.plot.show("suggestions", annotation.suggestions[open_ones])
        chosen = np.zeros((0, 2, 2))
        if self._border is not None:
            chosen = np.array(annotation.drawing.border(self._border).ends)
        elif self._suggestion is not None:
            chosen = annotation.suggestions[self._suggestion]
        self.plot.show("selected", chosen)
        self.panel.show_selected(self._border, self._suggestion, len(open_ones))

    # The mouse.

    def _press(self, event: PanStart) -> None:
        self._drag = None
        self.panel.say("")

    def _pan(self, event: Pan) -> None:
        if self.panel.mode.active != 0:
            return
        scale = self.plot.metres_per_pixel()
        if self._drag is None:
            # The browser tells of a drag only once the mouse has moved a little.
            x, y = event.x - event.delta_x * scale, event.y + event.delta_y * scale
            self._drag = pressed(self._annotation.drawing.borders, x, y, GRIP * scale)
        line = np.array(self._drag.to(event.x, event.y)).reshape(1, 2, 2)
        with self._at_once():
            self.plot.show("preview", line)
            self.plot.show_edges("touched", self._annotation.canvas.crossings(line)[1])

    def _release(self, event: PanEnd) -> None:
        drag, self._drag = self._drag, None
        with self._at_once():
            self.plot.show("preview", np.zeros((0, 2, 2)))
            self.plot.show("touched", np.zeros((0, 2, 2)))
            if drag is not None:
                self._end(drag, event)

    def _end(self, drag: Drag, event: PanEnd) -> None:
        line = drag.to(event.x, event.y)
        shift = float(np.hypot(event.x - drag.start[0], event.y - drag.start[1]))
        if shift < SHORTEST_DRAG * self.plot.metres_per_pixel():
            return
        if drag.border is None:
            self._try(lambda: self._annotation.draw(line))
            self._select_border(self._annotation.drawing.borders[-1:])
        else:
            number = drag.border
            self._try(lambda: self._annotation.move(number, line))

    def _select_border(self, borders: tuple[Any, ...]) -> None:
        self._border = borders[0].id if borders else None
        self._suggestion = None
        self._show_selected()

    def _tap(self, event: Tap) -> None:
        annotation, reach = self._annotation, GRIP * self.plot.metres_per_pixel()
        border = border_at(annotation.drawing.borders, event.x, event.y, reach)
        self._border = self._suggestion = None
        self.panel.say("")
        if border is not None:
            self._border = border.id
        else:
            open_ones = annotation.open_suggestions()
            found = line_at(annotation.suggestions[open_ones], event.x, event.y, reach)
            if found is not None:
                self._suggestion = int(open_ones[found])
            else:
                self._select_room(event, reach)
        self._show_selected()

    def _select_room(self, event: Tap, reach: float) -> None:
        """Select the room of the node under the mouse; with shift beside those selected."""
        distance, node = self._tree.query((event.x, event.y))
        chosen = self.panel.rooms.selected
        if distance > 2 * reach:
            chosen.indices = []
            return
        numbers = [room.id for room in self._annotation.drawing.active_rooms]
        number = int(self._annotation.room_of_node[node])
        if number in numbers:
            index = numbers.index(number)
            shift = bool(event.modifiers and event.modifiers["shift"])
            kept = set(chosen.indices) if shift else set()
            chosen.indices = sorted(kept ^ {index}) if shift else [index]

    # Buttons, keys and fields.

    def _do(self, name: str) -> None:
        action: Callable[[], Any] = getattr(self, f"_{name}")
        self._try(action)

    def _try(self, action: Callable[[], Any]) -> None:
        """Do something; what goes wrong is told on the page."""
        try:
            self.panel.say(action() or "")
        except RoomsegError as error:
            self.panel.say(str(error), wrong=True)

    def _key(self, attribute: str, old: Any, new: Any) -> None:
        if new and isinstance(new[0], str):
            self._do(KEYS.get(new[0], "nothing"))

    def _undo(self) -> None:
        self._annotation.undo()

    def _redo(self) -> None:
        self._annotation.redo()

    def _save(self) -> str:
        return self._annotation.save()

    def _delete(self) -> None:
        if self._border is None:
            raise RoomsegError("Nothing to delete: click on a border first.")
        self._annotation.delete([self._border])

    def _accept(self) -> None:
        if self._suggestion is None:
            raise RoomsegError("Nothing to accept: click on a dashed suggestion first.")
        self._annotation.accept([self._suggestion])

    def _accept_all(self) -> None:
        self._annotation.accept(self._annotation.open_suggestions())

    def _strike(self) -> None:
        if self._suggestion is None:
            raise RoomsegError("Nothing to strike out: click on a dashed suggestion first.")
        self._annotation.strike(self._suggestion)

    def _split(self) -> None:
        (number,) = self._chosen_rooms(1)
        self._annotation.split(number)
        self._select_border(self._annotation.drawing.borders[-1:])

    def _merge(self) -> None:
        first, second = self._chosen_rooms(2)
        self._annotation.merge(first, second)

    def _nothing(self) -> None:
        self._border = self._suggestion = None
        self._show_selected()

    def _chosen_rooms(self, count: int) -> list[int]:
        rooms = self._annotation.drawing.active_rooms
        chosen = [rooms[i].id for i in self.panel.rooms.selected.indices if i < len(rooms)]
        if len(chosen) != count:
            some = "one room" if count == 1 else "two rooms (the second with shift)"
            raise RoomsegError(f"Click on {some} first, on the map or in the list.")
        return chosen

    def _set_mode(self, attribute: str, old: int, new: int) -> None:
        self.plot.figure.toolbar.active_drag = self.plot.pan if new else None

    def _set_layers(self, attribute: str, old: Any, new: Any) -> None:
        for name, renderer in self.plot.layers.items():
            renderer.visible = name in self.panel.chosen_layers()

    def _give_count(self, attribute: str, old: Any, new: Any) -> None:
        if self.panel.is_showing:
            return
        automatic = bool(self.panel.automatic.active)
        value = self.panel.count.value
        count = None if automatic else int(value or self._annotation.count)
        self._try(lambda: self._annotation.give_count(count))
        self.panel.show(self._annotation, self.plot.colour_of)

    def _show_chosen(self) -> None:
        """Ring the selected rooms, and enable what can be done with them."""
        rooms = self._annotation.drawing.active_rooms
        chosen = [rooms[i] for i in self.panel.rooms.selected.indices if i < len(rooms)]
        self.panel.show_selected_rooms(len(chosen))
        self.plot.show_selected_rooms(chosen)

    def _show_title(self, attribute: str, old: Any, new: Any) -> None:
        rooms = self._annotation.drawing.active_rooms
        single = len(new) == 1 and new[0] < len(rooms)
        self.panel.show_title(rooms[new[0]] if single else None)
        self._show_chosen()

    def _rename(self, attribute: str, old: Any, new: Any) -> None:
        if not self.panel.is_showing:
            (number,) = self._chosen_rooms(1)
            self._try(lambda: self._annotation.rename(number, str(new)))
