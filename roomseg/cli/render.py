"""``roomseg render``: add camera images to maps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from roomseg.cli.contact_sheet import write_contact_sheet
from roomseg.cli.options import maps_argument
from roomseg.cli.output import follow, progress_bar, tell

if TYPE_CHECKING:
    from render.cycles import Device

EXAMPLE = """\b
Example:
  roomseg render maps/*.h5
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
@click.option("--threads", type=click.IntRange(1), help="Threads of the renderer; all if absent.")
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
    threads: int | None,
    device: Device,
    hdr: bool,
    contact_sheet: bool,
    force: bool,
) -> None:
    """Add camera images to maps.

    Images that are there are kept, each new one is safe as soon as it is
    finished, and a stopped command goes on where it was when called again.
    """
    from dataset import FrameJournal, discard_frames, read_map
    from render import preset_named, render_map, suited_preset

    wanted, presets = preset_named(preset), {}
    for path in maps:
        # All files are looked at before hours are spent on the first.
        chosen = presets[path] = suited_preset(path, wanted)
        camera = chosen.camera(read_map(path).camera)
        if not force:
            FrameJournal(path, camera, chosen.name, keep_radiance=hdr).close()
    with progress_bar("images") as bar:
        for path in maps:
            if force:
                discard_frames(path)
            show = follow(bar, path.name)
            if presets[path] != wanted:
                name = presets[path].name
                tell(bar, f"{path}: a 3D scene of another make, rendered as {name!r}", err=True)

            def tell_device(device: str, path: Path = path) -> None:
                tell(bar, f"{path}: rendering on {device}", err=True)

            def tell_bake(path: Path = path) -> None:
                tell(bar, f"{path}: baking the light, once per apartment", err=True)

            count = render_map(
                path,
                preset=presets[path],
                limit=limit,
                threads=threads,
                device=device,
                hdr=hdr,
                on_device=tell_device,
                on_bake=tell_bake,
                on_progress=show,
            )
            tell(bar, f"{path}: {count} new images")
            if contact_sheet and (picture := write_contact_sheet(path)) is not None:
                tell(bar, str(picture))
