"""The paper's experiments, one module for each section, and all of them (`reproduce`)."""

from roomseg.experiments.cache import Cache
from roomseg.experiments.reproduction import (
    FULL_SETTINGS,
    QUICK_SETTINGS,
    Reproduction,
    Section,
    Settings,
    reproduce,
)
from roomseg.experiments.room_figures import FloorPlan

__all__ = [
    "FULL_SETTINGS",
    "QUICK_SETTINGS",
    "Cache",
    "FloorPlan",
    "Reproduction",
    "Section",
    "Settings",
    "reproduce",
]
