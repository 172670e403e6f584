"""The 2D cleaning-robot simulator: from an apartment to a topo-metric map (§2.1)."""

from simulator.cleaning_run import simulate
from simulator.laser import SensorSpec
from simulator.reference_set import NEW_RUNS, NOVEL_RUNS, REFERENCE_RUNS, ReferenceRun
from simulator.report import CoverageReport, coverage_report
from simulator.robot import RobotSpec
from simulator.spec_file import read_specs, settings_of, specs_of
from simulator.start import base_pose, random_start

__all__ = [
    "NEW_RUNS",
    "NOVEL_RUNS",
    "REFERENCE_RUNS",
    "CoverageReport",
    "ReferenceRun",
    "RobotSpec",
    "SensorSpec",
    "base_pose",
    "coverage_report",
    "random_start",
    "read_specs",
    "settings_of",
    "simulate",
    "specs_of",
]
