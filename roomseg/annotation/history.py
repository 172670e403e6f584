"""Undo and redo of drawings that never change."""

from __future__ import annotations

from dataclasses import dataclass, replace

from roomseg.annotation.drawing import Drawing

__all__ = ["History"]


@dataclass(frozen=True)
class History:
    """What was drawn before, what is there, and what was undone (next one last)."""

    present: Drawing
    past: tuple[Drawing, ...] = ()
    future: tuple[Drawing, ...] = ()

    def then(self, drawing: Drawing) -> History:
        """After an edit; what was undone before is gone."""
        return History(drawing, (*self.past, self.present))

    def undone(self) -> History:
        """One edit back; the same if there is none."""
        if not self.past:
            return self
        return History(self.past[-1], self.past[:-1], (*self.future, self.present))

    def redone(self) -> History:
        """One undone edit forth; the same if there is none."""
        if not self.future:
            return self
        return History(self.future[-1], (*self.past, self.present), self.future[:-1])

    def corrected(self, drawing: Drawing) -> History:
        """The present in other words; nothing that could be undone."""
        return replace(self, present=drawing)
