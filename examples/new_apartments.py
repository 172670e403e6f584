"""Make up apartments, clean each once, and print what came of it.

Change `WISHES` (`docs/generator.md` says what can be wished for), and the count.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from dataset import write_map
from roomseg.ground_truth import label_rooms
from scenes import floor_area, save_apartment
from scenes.generator import generate_apartment
from simulator import coverage_report, simulate

WISHES = {"rooms": (2, 3), "clutter": 0.2}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("homes"))
    parser.add_argument("--count", type=int, default=1)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for seed in range(arguments.count):
        home = generate_apartment(seed, **WISHES)
        save_apartment(home, arguments.output / f"{home.name}.json")
        topomap = label_rooms(simulate(home, seed=seed))
        write_map(arguments.output / f"{home.name}-run1.h5", topomap)
        report = coverage_report(topomap, home)
        print(
            f"{home.name}: {len(home.rooms)} rooms, {floor_area(home):.1f} m², "
            f"{report.nodes} nodes, {100 * report.coverage:.1f} % covered"
        )


if __name__ == "__main__":
    main()
