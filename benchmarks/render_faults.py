"""Kills workers and the writer of a rendering job over and over, and compares the bytes.

    python benchmarks/render_faults.py -o out/faults [--images 500] [--kills 20]

Renders some runs in demo3 (48-pixel disc, `quick`) undisturbed, with one process. Then
again with `--jobs 2`, while a worker is killed after every few images, and the
`roomseg render` itself after some more, each ``--kills`` times; it is called again until
nothing is missing. All signals are SIGKILL. Prints what it cost, and whether the files are
the same. A stopped benchmark goes on with the undisturbed maps that are there.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import click

from dataset import MapFile
from dataset.journal import journal_path
from dataset.records import records

ROBOT = "[camera]\ndisc_diameter = 48.0\nimage_size = [48, 48]\ndisc_centre = [24.0, 24.0]\n"
ENV = {**os.environ, "PYTHONPATH": str(ROOT)}


def roomseg(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "roomseg.cli", *map(str, arguments)]


def made(folder: Path, images: int) -> list[Path]:
    """Maps with so many nodes together; the last one may exceed it."""
    folder.mkdir(parents=True, exist_ok=True)
    robot = folder / "robot.toml"
    robot.write_text(ROBOT)
    paths: list[Path] = []
    count = runs = 0
    while count < images:
        runs += 1
        command = roomseg("simulate", "demo3", "--runs", runs, "--robot", robot, "-o", folder)
        subprocess.run(command, check=True, env=ENV, stdout=subprocess.DEVNULL)
        paths = [folder / f"demo3-run{i + 1}.h5" for i in range(runs)]
        count = sum(nodes(path) for path in paths)
    return paths


def nodes(path: Path) -> int:
    with MapFile(path) as file:
        return len(file.done)


def finished(paths: list[Path]) -> int:
    """Images that are safe, in maps or journals."""
    count = 0
    for path in paths:
        try:
            with MapFile(path) as file:
                done = set(file.done.nonzero()[0].tolist())
            with journal_path(path).open("rb") as stream:
                stream.readline()
                done |= {index for index, _ in records(stream)}
        except FileNotFoundError:
            pass
        count += len(done)
    return count


def workers(pid: int) -> list[int]:
    """The Dask workers that a process has started."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
            command = (stat.parent / "cmdline").read_bytes()
        except OSError:
            continue
        if parent == pid and b"spawn_main" in command:
            found.append(int(stat.parent.name))
    return found


def disturbed(paths: list[Path], kills: int, share: int) -> tuple[int, int, int]:
    """Render with kills; workers and writers that were killed, and calls that it took."""
    rng, dead_workers, dead_writers, calls = random.Random(1), 0, 0, 0
    while True:
        calls += 1
        begun = last = finished(paths)
        command = roomseg("render", *paths, "--preset", "quick", "--jobs", 2)
        writer = subprocess.Popen(command, env=ENV, stdout=subprocess.DEVNULL)
        while writer.poll() is None:
            time.sleep(0.2)
            now = finished(paths)
            here = workers(writer.pid)
            if here and dead_workers < kills and now - last >= share // 3:
                os.kill(rng.choice(here), signal.SIGKILL)
                dead_workers, last = dead_workers + 1, now
            if dead_writers < kills and now - begun >= share:
                writer.kill()
                dead_writers += 1
                writer.wait()
                if finished(paths) < now:
                    raise SystemExit(f"images that were safe are gone: {now}, {finished(paths)}")
        if writer.returncode == 0:
            return dead_workers, dead_writers, calls
        if writer.returncode != -signal.SIGKILL:
            raise SystemExit(f"roomseg render ended with {writer.returncode}")
        print(f"{finished(paths)} images, {dead_workers} and {dead_writers} killed", flush=True)


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True)
@click.option("--images", default=500, show_default=True)
@click.option("--kills", default=20, show_default=True, help="Of workers, and of the writer.")
def main(output: Path, images: int, kills: int) -> None:
    """Kill workers and the writer of a rendering job, and compare what comes of it."""
    bare = made(output / "bare", images)
    whole, faulty = output / "whole", output / "faulty"
    whole.mkdir(exist_ok=True)
    shutil.rmtree(faulty, ignore_errors=True)
    faulty.mkdir()
    for path in bare:
        shutil.copy(path, faulty)
        if not (whole / path.name).exists():
            shutil.copy(path, whole)
    subprocess.run(
        roomseg("render", *(whole / path.name for path in bare), "--preset", "quick"),
        check=True,
        env=ENV,
    )
    paths = [faulty / path.name for path in bare]
    total, begun = sum(map(nodes, paths)), time.perf_counter()
    # What is killed is rendered again: half of the images leave time for all kills.
    share = max(3, total // (2 * kills + 2))
    dead_workers, dead_writers, calls = disturbed(paths, kills, share)
    same = sum((whole / path.name).read_bytes() == path.read_bytes() for path in paths)
    print(f"{total} images, {len(paths)} maps, {time.perf_counter() - begun:.0f} s, {calls} calls")
    print(f"workers killed {dead_workers}, writers killed {dead_writers}")
    print(f"files equal to the undisturbed ones: {same} of {len(paths)}")
    print(f"left beside the maps: {sorted(set(faulty.iterdir()) - set(paths))}")


if __name__ == "__main__":
    main()
