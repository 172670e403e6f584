"""``roomseg render``: add camera images to maps."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roomseg.cli.contact_sheet import write_contact_sheet
from roomseg.cli.options import jobs_option, maps_argument
from roomseg.cli.output import progress_bar, tell
from roomseg.cli.rendering import ImageBar, rendered, scheduler_option, threads_option

if TYPE_CHECKING:
    from render import Wanted
    from render.cycles import Device

EXAMPLE = """\b
Example:
  roomseg render maps/*.h5
  roomseg render maps/*.h5 --jobs 4
  roomseg render maps/home-7-run1.h5 --preset preview --limit 20 --contact-sheet
"""


@click.command("render", epilog=EXAMPLE)
@maps_argument
@click.option(
    "--preset",
    default="fast",
    show_default=True,
    help="Render settings: fast (light baked once), reference (light traced for each image), "
    "draft and quick (the same, noisier), preview (small).",
)
@click.option("--limit", type=click.IntRange(1), help="At most so many new images per map.")
@jobs_option
@scheduler_option
@threads_option
@click.option(
    "--device",
    type=click.Choice(["auto", "cpu", "gpu"]),
    default="auto",
    show_default=True,
    help="What renders.",
)
@click.option(
    "--hdr",
    is_flag=True,
    help="Keep the radiance of the images, too, for `roomseg expose`: about four times the space.",
)
@click.option(
    "--contact-sheet",
    is_flag=True,
    help="Also draw some images and their panoramas into MAP.png beside the map.",
)
@click.option("--force", is_flag=True, help="Throw away the images that are there.")
def command(
    *,
    maps: tuple[Path, ...],
    preset: str,
    limit: int | None,
    jobs: int,
    scheduler: str | None,
    threads: int | None,
    device: Device,
    hdr: bool,
    contact_sheet: bool,
    force: bool,
) -> None:
    """Add camera images to maps.

    Images that are there are kept, each new one is safe as soon as it is
    finished, and a stopped command goes on where it was when called again.
    Several processes (--jobs, --scheduler) return images in chunks, of about 15 s.
    """
    from render import Wanted, preset_named

    if scheduler is not None and jobs > 1:
        raise click.UsageError("--jobs starts workers here, --scheduler uses those of a cluster")
    wanted = Wanted(preset_named(preset), limit, threads, device, hdr, force)
    counts = _looked_at(maps, wanted)
    with progress_bar("images") as bar:
        images = ImageBar(bar, counts)
        with closing(rendered(maps, wanted, images, jobs=jobs, scheduler=scheduler)) as outcomes:
            for outcome in outcomes:
                if outcome.problem is not None:
                    raise outcome.problem
                tell(bar, f"{outcome.path}: {outcome.count} new images")
                if contact_sheet and (picture := write_contact_sheet(outcome.path)) is not None:
                    tell(bar, str(picture))


def _looked_at(maps: Sequence[Path], wanted: Wanted) -> dict[Path, tuple[int, int]]:
    """Look at all files before hours are spent on the first.

    Returns
    -------
    dict of Path to (int, int)
        Images that each map has, and will have.
    """
    from dataset import FrameJournal, read_map

    counts = {}
    for path in maps:
        topomap, done = read_map(path), 0
        if not wanted.force:
            camera, name = wanted.preset.camera(topomap.camera), wanted.preset.name
            with FrameJournal(path, camera, name, keep_radiance=wanted.hdr) as journal:
                done = len(journal.done)
        nodes = len(topomap.nodes)
        counts[path] = (done, nodes if wanted.limit is None else min(nodes, done + wanted.limit))
    return counts
