"""The same map on other processors: with other libraries' code paths, bit by bit."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from scenes import load_apartment
from scenes.generator import generate_apartment
from scenes.solids import obstacles
from simulator import simulate
from simulator.surfaces import boundary

OLD_LIBRARIES = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512DQ,-AVX2,-FMA,-FMA4,-AVX",
    "NPY_DISABLE_CPU_FEATURES": "SSSE3 SSE41 POPCNT SSE42 AVX F16C FMA3 AVX2 AVX512F AVX512CD "
    "AVX512_KNL AVX512_KNM AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL",
    "OPENBLAS_CORETYPE": "Prescott",
    "OPENBLAS_NUM_THREADS": "1",
    "OPENCV_CPU_DISABLE": "AVX2,AVX512-SKX,FP16,AVX,FMA3,SSE4.2",
}
"""A processor of 2004, as far as libraries can be made to believe it."""
OLD_COMPILER = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}


def digest() -> str:
    """Of the plans of places with round and slanted furniture, and of two runs."""
    found = hashlib.sha256()
    homes = [generate_apartment(seed) for seed in (1, 13)]
    places = [load_apartment(name) for name in ("real1", "real2", "sim2", "sim5")]
    for place in (*homes, *places):
        found.update(boundary(obstacles(place)).tobytes())
    for seed in (1, 2):
        topomap = simulate(load_apartment("demo1"), seed=seed)
        assert topomap.path is not None and topomap.nodes.tilt is not None
        for array in (
            *(topomap.nodes.position, topomap.nodes.tilt, topomap.edges),
            *(topomap.path.true_pose, topomap.path.estimate, topomap.obstacles.position),
        ):
            found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()


def elsewhere(environment: dict[str, str]) -> str:
    """The digest that a process with other settings of the libraries finds."""
    code = "from test_same_bits import digest; print(digest())"
    folder = str(Path(__file__).parent)
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code],
        env={**os.environ, **environment, "PYTHONPATH": os.pathsep.join([folder, *sys.path])},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


pytestmark = pytest.mark.skipif(
    platform.machine() != "x86_64" or platform.system() != "Linux",
    reason="the settings are of Linux on x86-64",
)


def test_the_settings_make_a_difference():
    """Otherwise the other tests would show nothing."""
    code = (
        "import numpy as np, math; x = np.random.default_rng(0).uniform(-7, 7, 300000)\n"
        "print(hash(tuple(map(math.sin, x))), hash(tuple(np.arctan2(x, 1.0))))"
    )
    shown = [
        subprocess.run(
            [sys.executable, "-W", "ignore", "-c", code],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for environment in ({}, OLD_LIBRARIES)
    ]
    if shown[0] == shown[1]:
        pytest.skip("this processor's library code is the old one's")


def test_the_same_bits_with_the_libraries_of_an_old_processor():
    assert elsewhere(OLD_LIBRARIES) == digest()


@pytest.mark.slow
def test_the_same_bits_with_code_compiled_for_an_old_processor(tmp_path):
    """Compiles everything anew."""
    assert elsewhere({**OLD_COMPILER, "NUMBA_CACHE_DIR": str(tmp_path)}) == digest()
