"""The report of a data set and its segmentation: a page to look at (`write_report`)."""

from roomseg.report.contents import (
    Comparison,
    Fact,
    LintelView,
    MapResult,
    Measure,
    Place,
    Report,
    Snapshot,
    Spread,
)
from roomseg.report.page import write_report
from roomseg.report.views import search_lintel, take_snapshot

__all__ = [
    "Comparison",
    "Fact",
    "LintelView",
    "MapResult",
    "Measure",
    "Place",
    "Report",
    "Snapshot",
    "Spread",
    "search_lintel",
    "take_snapshot",
    "write_report",
]
