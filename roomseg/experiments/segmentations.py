"""The method on all maps, leaving each environment out (§3.2, Figs. 22 to 25)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roomseg.experiments import paper
from roomseg.experiments.maps import mean_and_median
from roomseg.experiments.room_figures import Judged, Plans, errors_said, room_drawing
from roomseg.experiments.tables import Cell, Drawing, Row, Table

__all__ = ["Segmentations"]

WORST_SHOWN = 3


@dataclass(frozen=True)
class Segmentations:
    """Every reference map with its result, in order."""

    maps: tuple[Judged, ...]

    @property
    def environments(self) -> tuple[str, ...]:
        """Names of the places, in order."""
        return tuple(dict.fromkeys(judged.item.environment for judged in self.maps))

    def of(self, environment: str) -> list[Judged]:
        """Maps of one place."""
        return [judged for judged in self.maps if judged.item.environment == environment]

    @property
    def overall(self) -> Table:
        """Mean and median impurity beside the paper's."""
        results = [judged.result for judged in self.maps]
        ours = mean_and_median(results)
        uniform = mean_and_median(results, uniform=True)
        cells = tuple(
            Cell(value, *expected) for value, expected in zip(ours, paper.IMPURITY, strict=True)
        )
        theirs = paper.VARIANTS["uniform"][4:]
        plain = tuple(Cell(*pair) for pair in zip(uniform, theirs, strict=True))
        return Table(
            "segmentation",
            "§3.2: impurity over all maps",
            ("weights", "mean v × 100", "median v × 100"),
            (Row("classifier", cells), Row("uniform", plain)),
        )

    @property
    def by_environment(self) -> Table:
        """How many maps of each place are segmented as in the ground truth."""
        rows = []
        for name in self.environments:
            maps = self.of(name)
            known = paper.ENVIRONMENTS.get(name)
            cells = (
                Cell(len(maps), None if known is None else known[0], digits=0),
                Cell(sum(judged.right for judged in maps), paper.MAPS_RIGHT.get(name), digits=0),
                Cell(float(np.mean([judged.impurity for judged in maps]))),
                Cell(float(np.mean([judged.uniform_impurity for judged in maps]))),
                Cell(float(np.mean([judged.errors.missed for judged in maps]))),
                Cell(float(np.mean([judged.errors.false for judged in maps]))),
            )
            rows.append(Row(name, cells))
        columns = (
            "environment",
            "maps",
            "like the ground truth",
            "mean v × 100",
            "uniform",
            "borders missed per map",
            "made up",
        )
        note = (
            "Like the ground truth: no room border is missed and none made up, and at most 5 % of "
            "the nodes are astray. A border is missed if both its rooms lie mostly in one found "
            "room, and made up if both found rooms lie mostly in one true one; one that is merely "
            "shifted is neither. The paper does not say how many maps of Sim4 are right."
        )
        return Table("environments", "§3.2: environment by environment", columns, tuple(rows), note)

    @property
    def by_map(self) -> Table:
        """Every map."""
        rows = [
            Row(
                judged.item.name,
                (
                    Cell(judged.impurity),
                    Cell(judged.uniform_impurity),
                    Cell(judged.errors.missed, digits=0),
                    Cell(judged.errors.false, digits=0),
                    Cell(100.0 * judged.result.borders.precision, digits=1),
                    Cell(100.0 * judged.result.borders.recall, digits=1),
                ),
            )
            for judged in self.maps
        ]
        columns = (
            "map",
            "v × 100",
            "uniform",
            "borders missed",
            "made up",
            "border edges: precision, %",
            "recall, %",
        )
        return Table("maps", "§3.2: map by map", columns, tuple(rows))

    @property
    def tables(self) -> tuple[Table, ...]:
        """All three."""
        return self.overall, self.by_environment, self.by_map

    @property
    def remarks(self) -> tuple[str, ...]:
        """What goes wrong, place by place."""
        remarks = []
        for name in self.environments:
            wrong = [judged for judged in self.of(name) if not judged.right]
            if wrong:
                worst = max(wrong, key=lambda judged: judged.impurity)
                remarks.append(
                    f"{name}: {len(wrong)} of {len(self.of(name))} maps differ from the ground "
                    f"truth; in the worst, {worst.item.run}, {errors_said(worst.errors)}."
                )
        if not remarks:
            remarks.append("No map differs from the ground truth by a whole room border.")
        return tuple(remarks)

    def drawings(self, plans: Plans) -> tuple[Drawing, ...]:
        """Fig. 22 is right and shows most rooms; Figs. 23 to 25 are the worst of three places."""
        right = [judged for judged in self.maps if judged.right] or list(self.maps)
        success = max(right, key=lambda judged: (judged.item.room_count, -judged.impurity))
        worst = [max(self.of(name), key=lambda judged: judged.impurity) for name in
                 self.environments]  # fmt: skip
        worst.sort(key=lambda judged: -judged.impurity)
        shown = [success, *(judged for judged in worst[:WORST_SHOWN] if judged is not success)]
        return tuple(
            room_drawing(f"fig{number}", f"Fig. {number}", judged, plans)
            for number, judged in enumerate(shown, 22)
        )
