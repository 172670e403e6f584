"""Write the report of the experiments: a page, figures as PDF and PNG, tables as CSV.

As for the other report, files are written first, then the page is replaced, and at last
figures and tables go that no longer belong to it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2

from dataset.atomic import replacing, write_text
from roomseg.experiments.reproduction import Reproduction, Section
from roomseg.experiments.tables import Cell, Drawing, Table
from roomseg.figures import figure_bytes
from roomseg.report.contents import Fact

__all__ = ["write_reproduction"]

_OWN = re.compile(r"[a-z0-9-]+\.(png|pdf|csv)")
FIGURES, TABLES = "figures", "tables"


@dataclass(frozen=True)
class _Picture:
    drawing: Drawing
    width: int
    height: int


@dataclass(frozen=True)
class _Head:
    software: str
    description: str
    facts: Sequence[Fact]


@dataclass(frozen=True)
class _Part:
    anchor: str
    section: Section
    pictures: tuple[_Picture, ...]


def write_reproduction(
    reproduction: Reproduction,
    folder: str | Path,
    *,
    software: str,
    description: str = "",
    facts: Sequence[Fact] = (),
) -> Path:
    """Write ``index.html`` with ``figures/`` and ``tables/``.

    Parameters
    ----------
    reproduction : Reproduction
    folder : path
        Made if absent.
    software, description : str
        What made it, and a sentence for the head of the page.
    facts : sequence of Fact
        Numbers for the head of the page, after those of the results.

    Returns
    -------
    Path
        Of the page.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    folder = Path(folder)
    for name in (FIGURES, TABLES):
        (folder / name).mkdir(parents=True, exist_ok=True)
    parts = []
    for number, section in enumerate(reproduction.sections, 1):
        pictures = tuple(_write_figure(folder / FIGURES, d) for d in section.drawings)
        parts.append(_Part(f"section-{number}", section, pictures))
    tables = [table for part in parts for table in part.section.tables]
    for table in tables:
        write_text(folder / TABLES / f"{table.name}.csv", table.csv())
    page = folder / "index.html"
    write_text(page, _rendered(reproduction, parts, tables, _Head(software, description, facts)))
    names = {picture.drawing.name for part in parts for picture in part.pictures}
    _remove_old(folder / FIGURES, names)
    _remove_old(folder / TABLES, {table.name for table in tables})
    return page


def _write_figure(folder: Path, drawing: Drawing) -> _Picture:
    """Write a figure for the page and for print."""
    figure = drawing.draw()
    png = figure_bytes(figure, ".png", dpi=200)
    for suffix, content in ((".png", png), (".pdf", figure_bytes(figure, ".pdf", dpi=300))):
        with replacing(folder / f"{drawing.name}{suffix}") as part:
            part.write_bytes(content)
    width, height = (int.from_bytes(png[at : at + 4], "big") for at in (16, 20))
    return _Picture(drawing, width, height)


def _remove_old(folder: Path, names: set[str]) -> None:
    """Remove what an earlier report left, and nothing that a report did not name."""
    for path in folder.iterdir():
        if path.stem not in names and _OWN.fullmatch(path.name):
            path.unlink(missing_ok=True)


def _rendered(
    reproduction: Reproduction,
    parts: list[_Part],
    tables: list[Table],
    head: _Head,
) -> str:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("roomseg", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    judged = [cell for cell in _cells(tables) if cell.agrees is not None]
    within = sum(bool(cell.agrees) for cell in judged)
    verdict = Fact("within what we accept", f"{within} of {len(judged)}")
    return environment.get_template("reproduction.html").render(
        parts=parts,
        misses=[(table, sentence) for table in tables for sentence in table.misses],
        description=head.description,
        software=head.software,
        headline=[*_headline(reproduction), verdict, *head.facts],
        folders={"figures": FIGURES, "tables": TABLES},
    )


def _cells(tables: list[Table]) -> Iterator[Cell]:
    for table in tables:
        for row in table.rows:
            yield from row.cells


def _headline(reproduction: Reproduction) -> list[Fact]:
    """The result in a few numbers."""
    mean, median = reproduction.segmentations.overall.rows[0].cells
    maps = reproduction.segmentations.maps
    right = sum(judged.right for judged in maps)
    return [
        Fact("mean impurity × 100", mean.written, f"paper {mean.paper_written}"),
        Fact("median", median.written, f"paper {median.paper_written}"),
        Fact("maps like the ground truth", f"{right} of {len(maps)}"),
    ]
