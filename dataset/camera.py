"""The equidistant fisheye camera of §3.1, as one object for every stage.

The camera looks straight up from the middle of the robot. In the equidistant
projection a ray at the angle ``zenith`` from the optical axis falls at the
radius ``zenith / (field_of_view / 2) * disc_radius`` from the disc centre.
Rendering, unfolding and the lintel search all take their pixels from here, so
that a smaller preview disc scales everything together.

Frames and pixels: azimuth is counted counter-clockwise from the robot's
heading, as seen from above. Image rows run down and columns run right; pixel
(r, c) has its centre at (r + 0.5, c + 0.5). The heading points to the right
of the image (+column). The camera looks *up*, so the scene is mirrored: what
is left of the robot (azimuth +90°) appears at the *bottom* (+row).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["REAL_CAMERA", "SIMULATED_CAMERA", "CameraFlaws", "FisheyeCamera"]


@dataclass(frozen=True)
class CameraFlaws:
    """What a real camera does to the light, beyond the projection; nothing by default.

    Attributes
    ----------
    vignetting : float
        Share of the light that is lost at the rim of the disc, 0..1; the loss grows
        with the square of the zenith angle.
    blur : float
        Standard deviation of the lens's blur, px.
    full_well : float
        Electrons of a pixel at grey level 255; their number has shot noise. At 0 no
        electrons are counted, and there is no noise.
    read_noise : float
        Standard deviation of the noise of reading a pixel out, electrons.
    """

    vignetting: float = 0.0
    blur: float = 0.0
    full_well: float = 0.0
    read_noise: float = 0.0

    def __post_init__(self) -> None:
        for setting in fields(self):
            value = getattr(self, setting.name)
            if not (np.isfinite(value) and value >= 0.0):
                raise ValueError(f"{setting.name}: {value}, expected a finite number >= 0")
        if self.vignetting > 1.0:
            raise ValueError(f"vignetting: {self.vignetting}, expected 0..1")
        if self.read_noise > 0.0 and self.full_well == 0.0:
            raise ValueError(
                f"read_noise: {self.read_noise} electrons without full_well, "
                "the electrons of grey level 255"
            )


@dataclass(frozen=True)
class FisheyeCamera:
    """An upward equidistant fisheye camera.

    Attributes
    ----------
    field_of_view : float
        Full opening angle of the image disc, rad.
    disc_diameter : float
        Diameter of the image disc, px.
    image_size : tuple of int
        (rows, columns), px.
    disc_centre : tuple of float
        (row, column) of the optical axis, px; integer + 0.5 is a pixel centre.
    height : float
        Height of the lens above the floor, m.
    flaws : CameraFlaws
        None by default.
    """

    field_of_view: float = float(np.radians(190.0))
    disc_diameter: float = 464.0
    image_size: tuple[int, int] = (464, 464)
    disc_centre: tuple[float, float] = (232.0, 232.0)
    height: float = 0.10
    flaws: CameraFlaws = CameraFlaws()

    def __post_init__(self) -> None:
        if not 0.0 < self.field_of_view <= 2.0 * np.pi:
            raise ValueError(f"field_of_view: {self.field_of_view}, expected 0 < rad <= 2 pi")
        if not 0.0 < self.disc_diameter < np.inf:
            raise ValueError(f"disc_diameter: {self.disc_diameter}, expected > 0 px")
        if min(self.image_size) < 1:
            raise ValueError(f"image_size: {self.image_size}, expected at least (1, 1) px")
        if not all(0.0 <= c <= s for c, s in zip(self.disc_centre, self.image_size, strict=True)):
            raise ValueError(
                f"disc_centre: {self.disc_centre}, expected (row, column) in the image, "
                f"{self.image_size} px"
            )
        if not 0.0 < self.height < np.inf:
            raise ValueError(f"height: {self.height}, expected > 0 m")

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> FisheyeCamera:
        """The camera whose `dataclasses.asdict` went through JSON."""
        given = dict(values)
        for name in ("image_size", "disc_centre"):
            given[name] = tuple(given[name])
        return cls(**given | {"flaws": CameraFlaws(**given.get("flaws", {}))})

    @property
    def pixels_per_radian(self) -> float:
        """Radius on the image per zenith angle, px/rad."""
        return self.disc_diameter / self.field_of_view

    def averaging_mask(self, side: int = 7) -> int:
        """Side of a mask, px, odd, that is ``side`` in the simulated camera (§2.2.4)."""
        scale = self.pixels_per_radian / SIMULATED_CAMERA.pixels_per_radian
        return max(1, 2 * round((side * scale - 1) / 2) + 1)

    def resized(self, disc_diameter: int) -> FisheyeCamera:
        """The same lens with another, tightly cropped disc of that many pixels."""
        size = int(disc_diameter)
        small = replace(
            self,
            disc_diameter=float(size),
            image_size=(size, size),
            disc_centre=(size / 2, size / 2),
        )
        return replace(small, flaws=self.scaled_flaws(small))

    def scaled_flaws(self, other: FisheyeCamera) -> CameraFlaws:
        """The flaws of this camera for one of other pixels; the blur is an angle."""
        scale = other.pixels_per_radian / self.pixels_per_radian
        return replace(self.flaws, blur=self.flaws.blur * scale)

    def project(
        self, azimuth: NDArray[np.float64], zenith: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Image points of rays.

        Parameters
        ----------
        azimuth, zenith : array, shape (...)
            rad; azimuth from the heading, zenith from the optical axis.

        Returns
        -------
        array, shape (..., 2)
            (row, column), px.
        """
        radius = np.asarray(zenith) * self.pixels_per_radian
        row = self.disc_centre[0] + radius * np.sin(azimuth)
        column = self.disc_centre[1] + radius * np.cos(azimuth)
        return np.stack([row, column], axis=-1)

    def unproject(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Azimuth and zenith (rad) of image points (..., 2) in (row, column), px."""
        offset = np.asarray(points, dtype=float) - np.asarray(self.disc_centre)
        zenith = np.hypot(offset[..., 0], offset[..., 1]) / self.pixels_per_radian
        return np.arctan2(offset[..., 0], offset[..., 1]), zenith

    def pixel_zenith(self) -> NDArray[np.float64]:
        """Zenith angle of every pixel centre, rad, shape ``image_size``."""
        rows, columns = np.indices(self.image_size)
        return self.unproject(np.stack([rows + 0.5, columns + 0.5], axis=-1))[1]

    def panorama_map(
        self, width: int = 288, height: int = 48, top_elevation: float = float(np.radians(75.0))
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Where the pixels of the unfolded panorama lie in the image (§2.2.4).

        Columns are azimuths, rows are elevations from ``top_elevation`` (row 0)
        down to 0° at the horizon; both are sampled at pixel centres.

        Returns
        -------
        map_x, map_y : arrays, shape (height, width), float32
            Column and row for ``cv2.remap``, which counts pixel centres as integers.
        """
        azimuth = (np.arange(width) + 0.5) / width * 2.0 * np.pi
        elevation = top_elevation * (1.0 - (np.arange(height) + 0.5) / height)
        grid_azimuth, grid_elevation = np.meshgrid(azimuth, elevation)
        points = self.project(grid_azimuth, np.pi / 2 - grid_elevation) - 0.5
        return points[..., 1].astype(np.float32), points[..., 0].astype(np.float32)

    def shows(self, map_x: NDArray[np.float32], map_y: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Which of the points of `panorama_map` lie in the disc and in the image."""
        points = np.stack([map_y, map_x], axis=-1) + 0.5
        _, zenith = self.unproject(points)
        inside = ((points >= 0.0) & (points <= self.image_size)).all(axis=-1)
        shown: NDArray[np.bool_] = inside & (zenith <= 0.5 * self.field_of_view)
        return shown


SIMULATED_CAMERA = FisheyeCamera()
"""The simulated robot's camera: a 464-pixel disc for 190° (§3.1)."""

REAL_CAMERA = FisheyeCamera(
    field_of_view=float(np.radians(185.0)),
    disc_diameter=450.0,
    image_size=(512, 640),
    disc_centre=(256.0, 320.0),
)
"""The prototype's camera: a disc of about 450 pixels for about 185° in 640 x 512 (§3.1)."""
