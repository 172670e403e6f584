"""``roomseg replay``: a cleaning run as a film."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roomseg.cli.options import FiniteRange, output_option

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Image = NDArray[np.uint8]

CODECS: dict[str, tuple[str, dict[str, str]]] = {
    ".mp4": ("libx264", {"crf": "23", "preset": "veryfast"}),
    ".webm": ("libvpx-vp9", {"crf": "36", "b": "0", "deadline": "realtime", "cpu-used": "8"}),
}
"""What browsers play, at a quality at which the lines stay clean."""
KEY_DISTANCE = 250
"""Pictures from one that stands for itself to the next: few, as little changes between."""
FILMS = (*CODECS, ".gif")
RATE = 25.0
GIF_RATE = 10.0
"""Pictures per second; a GIF knows hundredths of a second only, and grows large."""

EXAMPLE = """\b
Example:
  roomseg replay maps/sim4-run1.h5 -o run.webm
  roomseg replay maps/sim4-run1.h5 --speed 120 --height 360 -o run.gif
"""


@click.command("replay", epilog=EXAMPLE)
@click.argument("map_file", metavar="MAP", type=click.Path(path_type=Path))
@output_option("The film.", *FILMS)
@click.option(
    "--speed",
    type=FiniteRange(1.0, 1000.0),
    default=60.0,
    show_default=True,
    help="Times as fast as the robot.",
)
@click.option("--height", type=click.IntRange(120, 2160), default=540, show_default=True, help="px")
def command(*, map_file: Path, output: Path, speed: float, height: int) -> None:
    """Show a run with beams, estimate and truth, and the covered floor filling in."""
    from dataset import read_map
    from roomseg.cli.output import follow, progress_bar
    from roomseg.cli.panels import coverage_of, outlines_of
    from roomseg.figures.replay import replay_frames

    kind = output.suffix.lower()
    topomap = read_map(map_file)
    rate = GIF_RATE if kind == ".gif" else RATE
    frames = replay_frames(
        topomap,
        outlines_of(topomap.scene),
        speed=speed,
        rate=rate,
        height=height - height % 2,
        covered=coverage_of(topomap),
    )
    last = 0.0 if topomap.path is None or not len(topomap.path.time) else topomap.path.time[-1]
    with progress_bar("pictures") as bar:
        show, total = follow(bar, output.name), int(last * rate / speed) + 2
        counted = _counted(frames, show, total)
        (_write_gif if kind == ".gif" else _write_video)(output, counted, rate)
    click.echo(str(output))


def _counted(
    frames: Iterator[Image], show: Callable[[int, int], None], total: int
) -> Iterator[Image]:
    for done, frame in enumerate(frames, 1):
        show(min(done, total), total)
        yield frame


def _write_video(output: Path, frames: Iterator[Image], rate: float) -> None:
    """Encode with FFmpeg; the old file stays until the new one is whole."""
    import av

    from dataset.atomic import replacing

    kind = output.suffix.lower()
    codec, options = CODECS[kind]
    first = next(frames)
    with replacing(output) as part, av.open(part, "w", format=kind.removeprefix(".")) as film:
        stream: Any = film.add_stream(codec, rate=int(rate), options=options)
        stream.height, stream.width = first.shape[:2]
        stream.pix_fmt = "yuv420p"
        stream.codec_context.gop_size = KEY_DISTANCE
        for frame in chain([first], frames):
            film.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="bgr24")))
        film.mux(stream.encode())


def _write_gif(output: Path, frames: Iterator[Image], rate: float) -> None:
    """Encode with Pillow, one palette for all pictures."""
    from PIL import Image as Picture

    from dataset.atomic import replacing
    from roomseg.figures.replay import COLOURS

    palette = Picture.new("P", (1, 1))
    palette.putpalette([value for colour in COLOURS for value in colour[::-1]])
    pictures = (
        Picture.fromarray(frame[..., ::-1]).quantize(palette=palette, dither=Picture.Dither.NONE)
        for frame in frames
    )
    first = next(pictures)
    with replacing(output) as part:
        first.save(part, "GIF", save_all=True, append_images=pictures, duration=1000 / rate, loop=0)
