"""A map's images and panoramas as PNG, and a table of the nodes that they belong to."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from dataset.storage import MapFile
from roomseg.panorama import PanoramaParameters, Unfolding

__all__ = ["View", "node_table", "views"]


@dataclass(frozen=True)
class View:
    """What one node sees: PNG files, by name."""

    node: int
    image: bytes
    panorama: bytes

    @property
    def names(self) -> tuple[str, str]:
        """Of the files of the image and the panorama."""
        return f"node-{self.node:05d}.png", f"node-{self.node:05d}-panorama.png"


def views(file: MapFile) -> Iterator[View]:
    """Every image of a map with its panorama (§2.2.4), in order of the nodes."""
    unfold = Unfolding.of(file.topomap.camera, PanoramaParameters())
    for node in np.flatnonzero(file.done).tolist():
        image = file.image(node)
        yield View(node, _png(image), _png(unfold(image)))


def _png(image: NDArray[np.uint8]) -> bytes:
    data: bytes = cv2.imencode(".png", image)[1].tobytes()
    return data


def node_table(file: MapFile, pictures: Mapping[int, tuple[str, str]]) -> str:
    """CSV of all nodes (`dataset.tables`), and where their image and panorama are, if any."""
    columns = file.node_columns()
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["node", *columns, "image", "panorama"])
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    for node, row in enumerate(rows):
        values = ["" if math.isnan(value) else value for value in row]
        table.writerow([node, *values, *pictures.get(node, ("", ""))])
    return text.getvalue()
