"""The picture of a map's images and panoramas (``roomseg render --contact-sheet``)."""

from __future__ import annotations

from pathlib import Path

__all__ = ["write_contact_sheet"]

COUNT = 6


def write_contact_sheet(path: Path) -> Path | None:
    """Draw some images of a map, spread over its run, into ``NAME.png`` beside it.

    Returns
    -------
    Path or None
        Where it is; None if the map has no images.
    """
    import numpy as np

    from dataset import MapFile
    from dataset.atomic import replacing
    from roomseg.figures import contact_sheet_figure, png_bytes
    from roomseg.report.views import take_snapshot

    with MapFile(path) as file:
        topomap, done = file.topomap, np.flatnonzero(file.done)
        if not len(done):
            return None
        chosen = done[np.linspace(0, len(done) - 1, min(COUNT, len(done))).astype(int)].tolist()
        shots = [take_snapshot(node, file.image(node), topomap.camera) for node in chosen]
        views = [
            (f"node {shot.node}, gain {file.gain(shot.node):.3g}", shot.image, shot.panorama)
            for shot in shots
            if shot.panorama is not None
        ]
        preset = f", {file.preset}" if file.preset else ""
    title = f"{topomap.title}{preset}: {len(done)} images"
    output = path.with_suffix(".png")
    picture = png_bytes(contact_sheet_figure(title, views))
    with replacing(output) as part:
        part.write_bytes(picture)
    return output
