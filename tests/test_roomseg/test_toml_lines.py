"""Lines of values in a TOML text: every value below says itself on which line it begins."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

import pytest

from roomseg.cli.toml_lines import dotted, line_of

TEXT = '''# a comment
first = 2
"quoted key" = 3

dotted.name.here = 5
many = [
  6, # = 6 ] """
  6,
]
text = """
10
key = 3
"""
[table]
inline = { a = 15, b = [15, 15] }
[table.below]
value = 17
[[list]]
value = 19
[[list]]
[list.options]
value = 22
  indented   =   23'''


def leaves(data: Any, keys: tuple[str | int, ...] = ()) -> Iterator[tuple[Any, Any]]:
    if isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from leaves(value, (*keys, key))
    else:
        yield keys, data


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_every_value_is_found_on_its_line(end):
    text = TEXT.replace("\n", end)
    found = dict(leaves(tomllib.loads(text)))
    assert len(found) == 13
    for keys, value in found.items():
        line = int(str(value).split()[0])
        assert line_of(text, keys) == line, keys


def test_what_is_missing_has_the_line_of_its_table():
    assert line_of(TEXT, ("list", 0, "none")) == 18
    assert line_of(TEXT, ("list", 1)) == 20
    assert line_of(TEXT, ("list", 1, "options", "none", 3)) == 21
    assert line_of(TEXT, ("none",)) == line_of("", ("none",)) == 1


def test_other_line_separators_do_not_count():
    """They are characters like others in a text."""
    assert line_of('a = "x\u2028y\u0085"\nb = 2', ("b",)) == 2


def test_dotted():
    assert dotted(("places", 1, "seeds")) == "places[1].seeds"
