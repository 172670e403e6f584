"""What stands beside the map: messages, rooms, suggestions, the image of a node (Bokeh)."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

from bokeh.layouts import column, row
from bokeh.models import (
    AllIndices,
    Button,
    Checkbox,
    CheckboxButtonGroup,
    ColumnDataSource,
    DataTable,
    Div,
    HTMLTemplateFormatter,
    InlineStyleSheet,
    NumberFormatter,
    RadioButtonGroup,
    Spinner,
    TableColumn,
    TextInput,
)

from roomseg.annotation.drawing import Room
from roomseg.annotation.plot import LAYERS, SHOWN_AT_FIRST
from roomseg.annotation.session import Annotation

__all__ = ["Panel"]

WIDTH = 350
STYLE = """
:host { font-family: system-ui, sans-serif; font-size: 13px; line-height: 1.4; color: #222 }
h1 { font-size: 16px; margin: 0; overflow-wrap: anywhere } h2 { font-size: 13px; margin: 4px 0 0 0 }
p { margin: 2px 0 } .quiet { color: #666 } .wrong, .leak { color: #B01010 }
.good { color: #00664A } img { display: block; margin-top: 4px; max-width: 100%; max-height: 190px;
image-rendering: auto; border-radius: 3px } kbd { background: #eee; padding: 0 3px;
border-radius: 3px } a { margin-right: 8px }
"""
HELP = """
<p class="quiet"><b>Drag</b> on the map draws a border, at its end or middle moves it.
<b>Click</b> selects a border, a suggestion or a room (<kbd>Shift</kbd>: two rooms).
<b>Wheel</b> zooms. <kbd>Ctrl Z</kbd> <kbd>Ctrl Y</kbd> undo, redo; <kbd>Del</kbd> deletes;
<kbd>A</kbd> accepts, <kbd>X</kbd> strikes out; <kbd>Ctrl S</kbd> saves.</p>
"""
UNCONFIRMED = """
<p class="quiet">Draw what is missing, or tick the box below. Until then Save keeps borders, but no
rooms.</p>
"""
SWATCH = '<div style="width:14px;height:14px;border-radius:7px;background:<%- value %>"></div>'
PANEL = {
    "background": "#F4F4F2",
    "padding": "6px 10px",
    "overflow-y": "auto",
    "overflow-x": "hidden",
}
ROW_HEIGHT = 24
SHOWN_ROOMS = (3, 10)
"""Rows of the list of rooms; with more it has its own scroll bar."""
MOST_LEAKS = 4
"""Told one by one; more are only counted."""


class Panel:
    """The side panel; `AnnotationPage` connects it with the annotation."""

    def __init__(
        self, annotation: Annotation, others: tuple[tuple[str, str], ...], *, has_images: bool
    ) -> None:
        self.is_showing = False
        """While the page itself changes fields, nothing is taken as the person's word."""
        topomap = annotation.topomap
        links = "".join(f'<a href="{escape(u)}">{escape(t)}</a>' for t, u in others)
        head = (
            f"<h1>{escape(annotation.path.name)}</h1><p class='quiet'>"
            f"{escape(topomap.title)}: {len(topomap.nodes)} nodes, "
            f"{len(annotation.canvas.edges)} edges</p>{links and f'<p>Other maps: {links}</p>'}"
        )
        hint = "Point at a node to see its image." if has_images else ""
        self.mode = RadioButtonGroup(labels=["Draw and move", "Pan"], active=0, name="mode")
        self.status, self.message = _text(name="status"), _text(annotation.notice, name="message")
        self.suggested, self.node = _text(), _text(hint, name="node")
        # Never seen; the browser writes pressed keys into its tags.
        self.keys = Div(visible=False, name="keys")
        self.buttons = {
            name: Button(label=label, button_type=kind, name=name, width=width)
            for name, label, kind, width in (
                ("undo", "Undo", "default", 56),
                ("redo", "Redo", "default", 56),
                ("delete", "Delete border", "default", 112),
                ("save", "Save", "success", 64),
                ("split", "Split room", "default", 100),
                ("merge", "Merge rooms", "default", 105),
                ("accept", "Accept", "default", 75),
                ("strike", "Strike out", "default", 85),
                ("accept_all", "Accept all", "default", 90),
            )
        }
        most = len(topomap.nodes)
        self.count = Spinner(low=1, high=most, step=1, width=70, name="count")
        self.automatic = Checkbox(label="as many as the borders cut off", active=True, name="auto")
        self.rooms = ColumnDataSource({"colour": [], "name": [], "nodes": []}, name="rooms")
        self._table = self._made_table()
        self.title = TextInput(
            placeholder="name of the selected room", width=WIDTH - 25, disabled=True, name="title"
        )
        self.layers = CheckboxButtonGroup(
            labels=list(LAYERS), active=[LAYERS.index(name) for name in SHOWN_AT_FIRST]
        )
        self.layout: Any = self._laid_out(head, bool(len(annotation.suggestions)))

    def _laid_out(self, head: str, with_suggestions: bool) -> Any:
        b = self.buttons
        suggestions = [self.suggested, row(b["accept"], b["strike"], b["accept_all"])]
        return column(
            _text(head),
            self.mode,
            row(b["undo"], b["redo"], b["delete"], b["save"]),
            self.message,
            self.status,
            _text("<h2>Rooms</h2>"),
            row(self.count, self.automatic),
            self._table,
            self.title,
            row(b["split"], b["merge"]),
            *(suggestions if with_suggestions else []),
            self.layers,
            self.node,
            _text(HELP),
            self.keys,
            width=WIDTH + 24,
            sizing_mode="stretch_height",
            styles=PANEL,
        )

    def _made_table(self) -> DataTable:
        columns = [
            TableColumn(
                field="colour",
                title="",
                width=24,
                formatter=HTMLTemplateFormatter(template=SWATCH),
                sortable=False,
            ),
            TableColumn(field="name", title="name", width=210, sortable=False),
            TableColumn(
                field="nodes", title="nodes", width=60, formatter=NumberFormatter(), sortable=False
            ),
        ]
        return DataTable(
            source=self.rooms,
            columns=columns,
            editable=False,
            index_position=None,
            reorderable=False,
            width=WIDTH - 25,
            height=_table_height(0),
            row_height=ROW_HEIGHT,
            autosize_mode="none",
        )

    def chosen_layers(self) -> set[str]:
        """Names of the layers that are switched on."""
        return {LAYERS[index] for index in self.layers.active}

    def say(self, text: str, *, wrong: bool = False) -> None:
        """Show a message; an empty one takes the last away."""
        self.message.text = f'<p class="{"wrong" if wrong else "good"}">{escape(text)}</p>'

    def show(self, annotation: Annotation, colour_of: Callable[[int], str]) -> None:
        """Show the state of the annotation."""
        self.is_showing = True
        try:
            self._show_rooms(annotation, colour_of)
            self.status.text = _status(annotation)
            self.count.value = annotation.count
            self.automatic.active = annotation.drawing.count is None
            self.buttons["undo"].disabled = not annotation.history.past
            self.buttons["redo"].disabled = not annotation.history.future
            is_saved = annotation.drawing.borders and not annotation.unsaved
            self.buttons["save"].label = "Saved" if is_saved else "Save"
        finally:
            self.is_showing = False

    def _show_rooms(self, annotation: Annotation, colour_of: Callable[[int], str]) -> None:
        rooms = annotation.drawing.active_rooms
        data = {
            "colour": [colour_of(room.id) for room in rooms],
            "name": [room.title for room in rooms],
            "nodes": [room.size for room in rooms],
        }
        if data != self.rooms.data:
            self.rooms.data = data
            self._table.height = _table_height(len(rooms))
            # Bokeh's table draws itself anew only if the number of rows or its view changes.
            self._table.view.filter = AllIndices()

    def show_title(self, room: Room | None) -> None:
        """Let the name of a room be typed; None: no single one is selected."""
        self.is_showing = True
        self.title.value = "" if room is None else room.name
        self.title.disabled = room is None
        self.is_showing = False

    def show_selected_rooms(self, count: int) -> None:
        """Enable what can be done with so many rooms."""
        self.buttons["split"].disabled = count != 1
        self.buttons["merge"].disabled = count != 2

    def show_selected(self, border: int | None, suggestion: int | None, left: int) -> None:
        """Enable what can be done with what is selected."""
        self.buttons["delete"].disabled = border is None
        for name in ("accept", "strike"):
            self.buttons[name].disabled = suggestion is None
        self.buttons["accept_all"].disabled = not left
        self.suggested.text = f"<h2>Suggestions: {left} left</h2>"


def _table_height(rooms: int) -> int:
    fewest, most = SHOWN_ROOMS
    return ROW_HEIGHT * (1 + min(max(rooms, fewest), most)) + 8


def _text(html: str = "", name: str = "") -> Div:
    return Div(text=html, name=name, width=WIDTH - 25, stylesheets=[InlineStyleSheet(css=STYLE)])


def _status(annotation: Annotation) -> str:
    """What is drawn, and what is wrong with it."""
    cut, confirmation = annotation.cut, annotation.confirmation
    borders, count = len(annotation.drawing.borders), annotation.count
    lines = [
        f"<p><b>{borders} border{'s' * (borders != 1)}, {count} room{'s' * (count != 1)}</b>, "
        f"{int(cut.edge_is_border.sum())} edges crossed</p>"
    ]
    for leak in cut.leaks[:MOST_LEAKS]:
        lines.append(
            f'<p class="leak">&#9888; Border {leak.border} leaks: a way round it of '
            f"{leak.length:.1f} m (red)</p>"
        )
    if len(cut.leaks) > MOST_LEAKS:
        lines.append(f'<p class="leak">&#9888; and {len(cut.leaks) - MOST_LEAKS} more leak</p>')
    for number in cut.idle[:MOST_LEAKS]:
        lines.append(f'<p class="leak">&#9888; Border {number} crosses no edge</p>')
    if confirmation is None:
        lines.append('<p class="quiet">clustering&hellip;</p>')
    elif confirmation.problem:
        lines.append(f'<p class="leak">&#9888; {escape(confirmation.problem)}.</p>{UNCONFIRMED}')
    elif not borders and count == 1:
        lines.append('<p class="quiet">Draw a line across every doorway.</p>')
    elif not cut.leaks:
        lines.append('<p class="good">&#10003; The clustering agrees: every border separates.</p>')
    return "".join(lines)
