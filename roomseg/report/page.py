"""Write the report: draw its pictures, fill in the template, replace the page in one step.

The page needs nothing from elsewhere: styles and script are inside it, and
pictures lie beside it in ``images/`` under names made from their content. New
pictures are written first, then the page is replaced, and only then pictures
that it no longer shows are removed: a reader finds the old report or the new.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import jinja2

from dataset.atomic import replacing, write_text
from roomseg.report.contents import (
    PAPER_CLASSIFIER,
    PAPER_UNIFORM,
    Fact,
    MapResult,
    Place,
    Report,
    Snapshot,
)
from roomseg.report.pictures import (
    Picture,
    lintel_picture,
    place_pictures,
    result_pictures,
    room_pictures,
    snapshot_pictures,
)

__all__ = ["write_report"]

_OWN_PICTURE = re.compile(r"[a-z0-9-]*-[0-9a-f]{12}\.png")


@dataclass(frozen=True)
class _Section:
    """A place with its pictures, as the template reads it."""

    anchor: str
    place: Place
    facts: tuple[Fact, ...]
    pictures: tuple[Picture, ...]
    rooms: tuple[tuple[MapResult, tuple[Picture, ...]], ...]
    snapshots: tuple[tuple[Snapshot, tuple[Picture, ...]], ...]
    lintel: Picture | None

    def all_pictures(self) -> list[Picture]:
        groups = [self.pictures, *(p for _, p in self.rooms), *(p for _, p in self.snapshots)]
        pictures = [picture for group in groups for picture in group]
        return pictures if self.lintel is None else [*pictures, self.lintel]


def write_report(report: Report, folder: str | Path) -> Path:
    """Write the report as ``index.html`` with its pictures in ``images/``.

    Parameters
    ----------
    report : Report
    folder : path
        Made if absent. Pictures of an earlier report in it are removed.

    Returns
    -------
    Path
        Of the page.

    Raises
    ------
    OSError
        If the folder cannot be written; an earlier report is then as it was.
    """
    folder = Path(folder)
    images = folder / "images"
    images.mkdir(parents=True, exist_ok=True)
    sections = [_section(place, number) for number, place in enumerate(report.places, 1)]
    charts = tuple(result_pictures(report))
    pictures = [*charts, *(picture for section in sections for picture in section.all_pictures())]
    for picture in pictures:
        _write_picture(images / picture.file, picture.png)
    page = folder / "index.html"
    write_text(page, render_page(report, sections, charts))
    _remove_old(images, pictures)
    return page


def render_page(report: Report, sections: list[_Section], charts: tuple[Picture, ...]) -> str:
    """Fill in the template; everything that comes from data is escaped."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("roomseg", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("report.html").render(
        report=report,
        sections=sections,
        charts=charts,
        headline=_headline(report),
        has_results=bool(report.classifier or report.uniform or report.comparisons or charts),
        paper_classifier=PAPER_CLASSIFIER,
        paper_uniform=PAPER_UNIFORM,
        worst=max(
            [
                value
                for result in report.maps
                for value in (result.impurity, result.uniform_impurity)
                if value is not None
            ],
            default=0.0,
        ),
    )


def _section(place: Place, number: int) -> _Section:
    return _Section(
        f"place-{number}",
        place,
        _place_facts(place),
        tuple(place_pictures(place)),
        tuple((result, tuple(room_pictures(place, result))) for result in place.maps),
        tuple((shot, tuple(snapshot_pictures(place, shot))) for shot in place.snapshots),
        None if place.lintel is None else lintel_picture(place, place.lintel),
    )


def _place_facts(place: Place) -> tuple[Fact, ...]:
    """Return what the first map says by itself, then what the caller knows."""
    if not place.maps:
        return place.facts
    topomap = place.maps[0].topomap
    facts = [Fact("nodes", f"{len(topomap.nodes):,}"), Fact("edges", f"{len(topomap.edges):,}")]
    if place.maps[0].kept is not None:
        facts.append(Fact("edges kept", f"{len(place.maps[0].kept):,}"))
    if topomap.ground_truth is not None:
        facts.append(Fact("rooms", str(topomap.ground_truth.room_count)))
    return (*facts, *place.maps[0].facts, *place.facts)


def _headline(report: Report) -> list[Fact]:
    """Return the summary numbers at the top of the page."""
    nodes = sum(len(result.topomap.nodes) for result in report.maps)
    facts = [
        Fact("places", f"{len(report.places)}"),
        Fact("maps", f"{len(report.maps)}"),
        Fact("nodes", f"{nodes:,}"),
    ]
    rows = (
        ("mean impurity", report.classifier, PAPER_CLASSIFIER),
        ("impurity without classifier", report.uniform, PAPER_UNIFORM),
    )
    for label, ours, paper in rows:
        if ours is not None:
            facts.append(Fact(label, f"{100 * ours.mean:.2f} %", f"paper {100 * paper.mean:.2f} %"))
    return [*facts, *report.facts]


def _write_picture(path: Path, png: bytes) -> None:
    """Write it unless it is there: the name stands for the content."""
    if not path.exists():
        with replacing(path) as part:
            part.write_bytes(png)


def _remove_old(images: Path, pictures: Iterable[Picture]) -> None:
    """Remove pictures that an earlier report left, and nothing that a report did not name."""
    current = {picture.file for picture in pictures}
    for path in images.iterdir():
        if path.name not in current and _OWN_PICTURE.fullmatch(path.name):
            path.unlink(missing_ok=True)
