"""Train the room-border classifier on some maps, and segment another one with it.

The last map is the test; it should be of a place that is not among the others. With images,
take `SUBSETS["all"]`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import dataset
from roomseg.classifier import ClassifierParameters, save_model
from roomseg.evaluation import judge, train_on
from roomseg.features import SUBSETS, edge_features
from roomseg.labelled_map import LabelledMap

PARAMETERS = ClassifierParameters(C=1.0, gamma=0.25, class_weight=10.0, rho=60.0)


def labelled(path: Path) -> LabelledMap:
    with dataset.open(path) as m:
        return LabelledMap.of(m.topomap, edge_features(m, SUBSETS["no-camera"]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("maps", nargs="+", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("model.skops"))
    arguments = parser.parse_args()
    if len(arguments.maps) < 2:
        parser.error("two maps at least, expected some to train on and one to test")
    *training, test = [labelled(path) for path in arguments.maps]
    model = train_on(training, PARAMETERS)
    save_model(model, arguments.output)
    result = judge(test, model)
    dataset.write_rooms(
        arguments.maps[-1], result.labels, model=arguments.output.name, rooms=test.room_count
    )
    print(
        f"{arguments.maps[-1]}: impurity {100 * result.quality.impurity:.2f} %, "
        f"with equal weights {100 * result.uniform_quality.impurity:.2f} %"
    )


if __name__ == "__main__":
    main()
