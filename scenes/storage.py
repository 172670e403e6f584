"""Apartments as JSON files: reading with one-line errors, writing without half files."""

from __future__ import annotations

import difflib
import json
import os
import tempfile
import typing
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from scenes.apartment import Apartment
from scenes.checks import check
from scenes.errors import SceneError
from scenes.faults import value_fault

__all__ = [
    "apartment_from_json",
    "apartment_to_json",
    "load_apartment",
    "reference_names",
    "save_apartment",
    "save_bytes",
    "save_text",
]


def reference_names() -> list[str]:
    """Names of the built-in reference places, sorted."""
    folder = resources.files("scenes").joinpath("reference")
    names = [item.name for item in folder.iterdir() if item.name.endswith(".json")]
    return sorted(name.removesuffix(".json") for name in names)


def load_apartment(source: str | Path, *, checked: bool = True) -> Apartment:
    """Read an apartment and check it.

    Parameters
    ----------
    source : str or Path
        A file, or the name of a reference place (`reference_names`). A name
        with a path separator or ``.json`` in it is always a file.
    checked : bool
        Whether to apply `scenes.checks.check` too.

    Raises
    ------
    SceneError
        If there is no such file or place, or what it says is not an
        apartment; one line that names the file, the field and the value.
    """
    name = str(source)
    if isinstance(source, str) and name in reference_names():
        item = resources.files("scenes").joinpath("reference", f"{name}.json")
        return apartment_from_json(item.read_text(encoding="utf-8"), origin=name, checked=checked)
    try:
        data = Path(source).read_bytes()
    except FileNotFoundError:
        known = ", ".join(reference_names()) or "none"
        message = f"{name}: no such file, nor a reference place ({known})"
        raise SceneError(message) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"{name!r}: cannot be read: {reason}") from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        message = f"{name}: byte {error.start} is not UTF-8; expected a JSON text file"
        raise SceneError(message) from None
    return apartment_from_json(text, origin=name, checked=checked)


def apartment_from_json(text: str, *, origin: str = "scene", checked: bool = True) -> Apartment:
    """An apartment from its JSON text.

    Parameters
    ----------
    text : str
    origin : str
        What errors call the text: its file name.
    checked : bool
        Whether to apply `scenes.checks.check` too.

    Raises
    ------
    SceneError
        If the text is not JSON, not an apartment, or an impossible one.
    """
    _parse(text, origin)
    try:
        apartment = Apartment.model_validate_json(text, strict=True)
    except ValidationError as error:
        faults = error.errors(include_url=False)
        raise _refusal(origin, [_describe(fault) for fault in faults]) from None
    if checked:
        problems = list(check(apartment))
        if problems:
            raise _refusal(origin, problems)
    return apartment


def apartment_to_json(apartment: Apartment) -> str:
    """Canonical JSON text, for people to read and edit.

    One thing (room, wall, piece) per line, fields in the model's order, without those
    that have their default.
    """
    data = apartment.model_dump(mode="json", exclude_defaults=True)
    head = {"format": apartment.format, "format_version": apartment.format_version}
    fields = [f'"{name}": {_lines(value)}' for name, value in (head | data).items()]
    return "{\n  " + ",\n  ".join(fields) + "\n}\n"


def save_apartment(apartment: Apartment, path: str | Path) -> None:
    """Write an apartment; a crash leaves the old file or the new one, never half of it.

    Raises
    ------
    SceneError
        If the file cannot be written, or its name does not end in ``.json``.
    """
    if Path(path).suffix.lower() != ".json":
        raise SceneError(f"{path}: not an apartment's name, expected one that ends in .json")
    save_text(apartment_to_json(apartment), path)


def save_text(text: str, path: str | Path) -> None:
    """Write a text file as `save_bytes` does, UTF-8."""
    save_bytes(text.encode("utf-8"), path)


def save_bytes(data: bytes, path: str | Path) -> None:
    """Write a file; a crash leaves the old file or the new one, never half of it.

    A link stays, and the file that it leads to is replaced.

    Raises
    ------
    SceneError
        If the file cannot be written, or what is there is no regular file.
    """
    target = Path(path).resolve()
    if Path(path).exists() and not Path(path).is_file():
        raise SceneError(f"{path}: is no regular file, expected another file name")
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            Path(temporary).chmod(0o644)
            Path(temporary).replace(target)
        finally:
            # Gone already if all went well; not so after an error or Ctrl-C.
            Path(temporary).unlink(missing_ok=True)
    except OSError as error:
        raise SceneError(f"{path}: cannot be written: {error.strerror or error}") from None


def _lines(value: Any) -> str:
    """JSON text of a top-level value: a list of things, or a table of them, by lines."""
    flat = json.dumps(value, ensure_ascii=False)
    if isinstance(value, list):
        items, ends = [json.dumps(item, ensure_ascii=False) for item in value], "[]"
    elif isinstance(value, dict) and any(isinstance(item, dict) for item in value.values()):
        items = [f"{json.dumps(k)}: {json.dumps(v, ensure_ascii=False)}" for k, v in value.items()]
        ends = "{}"
    else:
        return flat
    return f"{ends[0]}\n    " + ",\n    ".join(items) + f"\n  {ends[1]}"


def _parse(text: str, origin: str) -> None:
    """Refuse what is not JSON, with its line and column, and fields given twice."""

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise SceneError(f"{origin}: field {key!r} is given twice; expected once")
            seen.add(key)
        return dict(pairs)

    def constant(name: str) -> Any:
        raise SceneError(f"{origin}: {name} is not a JSON number; expected a finite one")

    try:
        json.loads(text, object_pairs_hook=unique, parse_constant=constant)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise SceneError(f"{origin}: {where}: not JSON: {error.msg}") from None
    except (RecursionError, ValueError):
        raise SceneError(f"{origin}: nested too deeply or a number too long") from None


def _refusal(origin: str, problems: list[str]) -> SceneError:
    """An error that says the first problem, how many more there are, and knows them all."""
    more = len(problems) - 1
    others = f" (and {more} more problem{'s' * (more > 1)})" if more else ""
    return SceneError(f"{origin}: {problems[0]}{others}", problems)


def _describe(fault: ErrorDetails) -> str:
    """One fault of a validation error in one line."""
    place = _place(fault["loc"]) or "the file"
    if fault["type"] == "extra_forbidden":
        return f"{place}: unknown field{_suggest(fault['loc'])}"
    if fault["type"] == "missing":
        return f"{place}: missing; expected a value"
    value = repr(fault["input"])
    value = value if len(value) <= 60 else value[:57] + "..."
    return f"{place}: {value}; {value_fault(fault)}"


def _place(loc: tuple[int | str, ...]) -> str:
    """``rooms[0].polygon[2]`` from pydantic's location."""
    text = ""
    for item in loc:
        text += f"[{item}]" if isinstance(item, int) else f".{item}"
    return text.removeprefix(".")


def _suggest(loc: tuple[int | str, ...]) -> str:
    """What fields the unknown one's object has, the likeliest alone if there is one."""
    model = _model_at(Apartment, loc[:-1])
    if model is None:
        return ""
    fields = list(model.model_fields)
    close = difflib.get_close_matches(str(loc[-1]), fields, n=1)
    return f"; did you mean {close[0]!r}?" if close else f"; expected one of {', '.join(fields)}"


def _model_at(annotation: Any, loc: tuple[int | str, ...]) -> type[BaseModel] | None:
    """The model class that an annotation holds at a location."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        if not loc:
            return annotation
        field = annotation.model_fields.get(str(loc[0]))
        return None if field is None else _model_at(field.annotation, loc[1:])
    inner = loc if typing.get_origin(annotation) not in (tuple, dict) else loc[1:]
    found = (_model_at(item, inner) for item in typing.get_args(annotation))
    return next((model for model in found if model is not None), None)
