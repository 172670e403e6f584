"""The reference set: which cleaning runs stand for the paper's maps (§3.1, §3.4).

31 maps of the eight places of Table 8, three runs in each simulated place and five, eight
and three in the stand-ins of the real ones; five new runs in the simulated places; and five
in the additional place of §3.4. The paper leaves open where its runs began. Ours begin as a
real robot is set down: by a wall or a piece of furniture, in different rooms, looking about
anywhere. The first run of a place begins where the apartment says.

The real robot is the same as the simulated one (§3.1), on real wheels and floors: the
obstacle maps of Fig. 16 show walls slightly bent and doubled, so the stand-ins' wheels slip
more and their images relate less exactly. Its camera has 640 x 512 pixels, a lens that
darkens the rim, and noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from dataset.camera import REAL_CAMERA, SIMULATED_CAMERA, CameraFlaws, FisheyeCamera
from simulator.laser import SensorSpec
from simulator.robot import RobotSpec

__all__ = [
    "NEW_RUNS",
    "NOVEL_RUNS",
    "REFERENCE_RUNS",
    "STAND_IN_CAMERA",
    "STAND_IN_ROBOT",
    "ReferenceRun",
]

STAND_IN_ROBOT = RobotSpec(
    slip_bias=0.002,
    slip_noise=0.005,
    correction_position_noise=0.04,
    correction_heading_noise=0.02,
)
"""The robot of Real1 to Real3: carpet and worn wheels, and images that relate less exactly."""

STAND_IN_CAMERA = replace(
    REAL_CAMERA,
    flaws=CameraFlaws(vignetting=0.38, blur=0.6, full_well=10_000.0, read_noise=20.0),
)
"""The camera of Real1 to Real3; the paper says nothing of its flaws, so ours are usual ones.

An equidistant lens whose pupil looks equally large from all sides spreads the light of a
solid angle over an area that grows as zenith / sin(zenith): 38 % are missing at 92.5°. A
good lens of two megapixels or so blurs by about half a pixel of 640 x 512. Pixels of 5 µm
hold some 10,000 electrons and are read out with some 20: a noise of 1.9 grey levels at the
middle of the range, 0.5 in the dark.
"""


@dataclass(frozen=True)
class ReferenceRun:
    """One cleaning run of the reference set.

    Attributes
    ----------
    place : str
        Name of the apartment, as `scenes.load_apartment` takes it.
    name : str
        Of the run.
    seed : int
    start : tuple of float
        Where the robot begins: x m, y m, heading degrees.
    robot : RobotSpec
    sensor : SensorSpec
    camera : FisheyeCamera
    """

    place: str
    name: str
    seed: int
    start: tuple[float, float, float]
    robot: RobotSpec
    sensor: SensorSpec
    camera: FisheyeCamera

    @property
    def file_name(self) -> str:
        """Of its map."""
        return f"{self.place}-{self.name}.h5"


Starts = tuple[tuple[float, float, float], ...]

_STARTS: dict[str, Starts] = {
    "sim1": ((12.5, 5.95, 180.0), (7.55, 7.15, 71.0), (0.3, 5.25, -26.0)),
    "sim2": ((12.0, 5.4, 180.0), (10.6, 7.95, 26.0), (5.15, 7.6, -4.0)),
    "sim3": ((8.2, 3.65, 180.0), (7.2, 1.65, -143.0), (2.3, 4.85, -49.0)),
    "sim4": ((7.5, 4.3, 180.0), (5.6, 1.0, 165.0), (4.8, 4.95, 40.0)),
    "sim5": ((5.5, 7.7, -90.0), (7.5, 3.45, -103.0), (9.75, 5.7, 144.0)),
    "real1": (
        (6.2, 0.8, 90.0),
        (2.15, 3.8, 93.0),
        (6.3, 3.3, -76.0),
        (8.05, 0.6, 152.0),
        (1.45, 4.0, -153.0),
    ),
    "real2": (
        (4.9, 5.5, -90.0),
        (7.35, 0.4, -97.0),
        (3.05, 0.3, -107.0),
        (7.7, 5.35, -25.0),
        (1.85, 2.4, -167.0),
        (7.45, 0.35, 103.0),
        (3.85, 5.35, -84.0),
        (8.05, 5.4, -109.0),
    ),
    "real3": ((4.9, 0.4, 90.0), (7.0, 2.45, 133.0), (2.0, 2.9, 64.0)),
}

_NEW_STARTS: dict[str, Starts] = {
    "sim1": ((10.2, 11.3, -23.0),),
    "sim2": ((1.9, 3.5, 151.0),),
    "sim3": ((7.5, 5.25, -98.0),),
    "sim4": ((1.1, 3.6, 95.0),),
    "sim5": ((4.85, 5.8, 155.0),),
}

_NOVEL_STARTS: dict[str, Starts] = {
    "novel": (
        (9.5, 4.4, 180.0),
        (3.2, 1.85, -175.0),
        (8.95, 2.45, -47.0),
        (5.1, 5.9, -124.0),
        (0.8, 6.75, 29.0),
    ),
}


def _runs(starts: dict[str, Starts], kind: str, seed: int) -> tuple[ReferenceRun, ...]:
    """The runs of several places, named after their kind; seeds count on from ``seed``."""
    runs: list[ReferenceRun] = []
    for place, poses in starts.items():
        real = place.startswith("real")
        robot, camera = (
            (STAND_IN_ROBOT, STAND_IN_CAMERA) if real else (RobotSpec(), SIMULATED_CAMERA)
        )
        for number, start in enumerate(poses, 1):
            name = f"{kind}{number}"
            # Frame i is rendered with the run's seed + i: far enough apart that none is shared.
            run_seed = 100_000 * (seed + len(runs))
            runs.append(ReferenceRun(place, name, run_seed, start, robot, SensorSpec(), camera))
    return tuple(runs)


REFERENCE_RUNS = _runs(_STARTS, "run", 1)
"""The 31 maps that the classifier is trained and judged on (Table 8)."""

NEW_RUNS = _runs(_NEW_STARTS, "new", 101)
"""New runs in known places, one in each simulated one (§3.4)."""

NOVEL_RUNS = _runs(_NOVEL_STARTS, "run", 201)
"""Runs in the additional place (§3.4)."""
