"""``roomseg expose``: make the images anew from their radiance."""

from __future__ import annotations

from pathlib import Path

import click

from roomseg.cli.options import maps_argument
from roomseg.cli.output import follow, progress_bar, tell

EXAMPLE = """\b
Example:
  roomseg render maps/*.h5 --hdr
  roomseg expose maps/*.h5 --robot noisy.toml
"""


@click.command("expose", epilog=EXAMPLE)
@maps_argument
@click.option(
    "--robot",
    "robot_file",
    type=click.Path(path_type=Path),
    help="TOML of a robot whose camera's vignetting, blur and noise to take; see docs/robot.md. "
    "The map's own if absent.",
)
def command(*, maps: tuple[Path, ...], robot_file: Path | None) -> None:
    """Expose the images of maps again, without rendering.

    Needs maps whose radiance was kept (`roomseg render --hdr`). Exposure, vignetting,
    blur and noise are made anew; what the camera sees stays as it was rendered.
    """
    from dataset import MapFile
    from render import expose_map
    from simulator.camera_file import read_camera

    robot = None if robot_file is None else read_camera(robot_file)
    with progress_bar("images") as bar:
        for path in maps:
            with MapFile(path) as file:
                camera = file.topomap.camera
            # The blur is a part of the view, of however many pixels.
            scaled = None if robot is None else robot.scaled_flaws(camera)
            count = expose_map(path, scaled, on_progress=follow(bar, path.name))
            tell(bar, f"{path}: {count} images exposed")
