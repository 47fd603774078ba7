"""A campaign's TOML: read with file and line in every error, and written with comments."""

from __future__ import annotations

import re
from dataclasses import MISSING, Field, fields
from importlib.resources import files
from pathlib import Path
from typing import Any

from layerjam.device.file import BrakeFile
from layerjam.device.toml import line_of, parse_toml, read_text
from layerjam.errors import FileError, LayerjamError, QuantityError, UnknownNameError
from layerjam.lab.spec import TABLES, Spec, checked, places, value_checked
from layerjam.units import exact_text, parse

_HEADINGS = {
    "brakes": "One [[brakes]] for each brake: where it differs in truth from its file.",
    "pulls": "Pulls of each brake: every vacuum at every speed.",
    "friction": "Friction tests of each brake's film: a sled drawn over it by a string.",
    "scatter": "How the brake differs from pull to pull.",
    "machine": "The test machine and its faults; 0 for none.",
    "files": "What the files look like.",
    "practice": "How many of the pulls' files have a fault that should be found.",
}


def example() -> Spec:
    """A campaign to begin with: small, with the faults of an ordinary machine."""
    place = files("layerjam.lab") / "practice.toml"
    return parse_spec(place.read_text(encoding="utf-8"), "practice.toml")


def read_spec(path: str | Path) -> Spec:
    """The campaign in a TOML file; paths of brakes count from its folder.

    Raises FileError, with file and line, for broken TOML, an unknown key, a value without unit, of
    the wrong dimension or out of bounds, or values that contradict each other.
    """
    path = Path(path)
    return parse_spec(read_text(path), path, path.parent)


def parse_spec(text: str, path: object, folder: Path | None = None) -> Spec:
    """The campaign in a TOML text; `path` is what errors call it."""
    reader = _Reader(text, path)
    tables = parse_toml(text, path)
    values: dict[str, Any] = {}
    known = {f.name: f for f in fields(Spec)}
    for key, value in tables.items():
        if key not in known:
            raise reader.fail(key, UnknownNameError("key", key, known))
        if key == "brakes":
            values[key] = _brakes(reader, value, folder)
        elif key in TABLES:
            values[key] = reader.record(key, value)
        else:
            values[key] = reader.value(known[key], key, key, value)
    try:
        return checked(Spec(**values))
    except LayerjamError as error:
        raise reader.fail(str(error).split(":")[0], error) from None


def _brakes(reader: _Reader, value: object, folder: Path | None) -> tuple[Any, ...]:
    if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
        raise reader.fail("brakes", LayerjamError("brakes: each begins with a line [[brakes]]"))
    made = []
    for entry in value:
        name = entry.get("brake")
        is_file = folder is not None and isinstance(name, str) and name.endswith(".toml")
        placed = {"brake": str(folder / name)} if is_file and folder else {}
        made.append(reader.record("brakes", {**entry, **placed}))
    return tuple(made)


class _Reader:
    """Turns TOML values into the fields' own, with the line in every error."""

    def __init__(self, text: str, path: object) -> None:
        # line_of knows [table]; an array of tables is found as the first of them
        self.text, self.path = re.sub(r"(?m)^\s*\[\[(\w+)\]\]", r"[\1]", text), path

    def fail(self, key: str, error: LayerjamError) -> FileError:
        return FileError(self.path, str(error), line_of(self.text, key))

    def record(self, table: str, value: object) -> Any:
        cls = TABLES[table]
        if not isinstance(value, dict):
            raise self.fail(table, LayerjamError(f"{table} must be a table, [{table}]"))
        known = {f.name: f for f in fields(cls)}
        made = {}
        for key, inner in value.items():
            path = f"{table}.{key}"
            if key not in known:
                raise self.fail(
                    path, UnknownNameError("key", path, [f"{table}.{k}" for k in known])
                )
            made[key] = self.value(known[key], key, path, inner)
        for key, place in known.items():
            if place.default is MISSING and key not in made:
                about = place.metadata["text"]
                raise self.fail(table, LayerjamError(f"{table}.{key} is missing: {about}"))
        return cls(**made)

    def value(self, place: Field[Any], key: str, path: str, value: object) -> Any:
        several = place.metadata.get("several", False)
        try:
            if several and not isinstance(value, list):
                raise QuantityError(f"{path}: must be a list in [ ], such as [{value!r}]")
            made = [_single(place, path, v) for v in value] if several else None  # type: ignore[attr-defined]
            whole = tuple(made) if made is not None else _single(place, path, value)
            value_checked(place, whole, path)
            return whole
        except LayerjamError as error:
            raise self.fail(path, error) from None


def _single(place: Field[Any], path: str, value: object) -> Any:
    spec = place.metadata.get("quantity")
    if spec is None:
        if not isinstance(value, str):
            raise QuantityError(f"{path}: must be a text in quotes")
        return value
    if spec.whole:
        if isinstance(value, bool) or not isinstance(value, int):
            raise QuantityError(f"{path}: {value!r} is not allowed; it is a whole number")
        spec.check(value if abs(value) < 2**63 else float("inf"), path)
        return value
    return spec.check(parse(value, spec.unit, path), path)


def spec_text(spec: Spec) -> str:
    """The campaign as a commented file: every field, what it means and what is allowed."""
    lines = [
        "# A campaign of the virtual laboratory: layerjam lab THIS.toml --out DIR",
        "# Every quantity carries its unit; what is left out is as its comment says.",
        "",
    ]
    lines += _entries(spec, [f for f in fields(Spec) if f.name == "seed"])
    for table in TABLES:
        records = spec.brakes if table == "brakes" else (getattr(spec, table),)
        for record in records:
            head = "[[brakes]]" if table == "brakes" else f"[{table}]"
            lines += ["", f"# {_HEADINGS[table]}", head]
            lines += _entries(record, [f for f, _ in places(record)])
    return "\n".join([*lines, ""])


def _entries(record: Any, wanted: list[Field[Any]]) -> list[str]:
    lines = []
    for place in wanted:
        value = getattr(record, place.name)
        lines.append(f"# {_spec(place)}")
        if value is None:
            lines.append(f"# {place.name} =")
        elif place.metadata.get("several"):
            lines.append(f"{place.name} = [{', '.join(_text(place, v) for v in value)}]")
        else:
            lines.append(f"{place.name} = {_text(place, value)}")
    return lines


def _spec(place: Field[Any]) -> str:
    spec = place.metadata.get("quantity")
    if spec is not None:
        unit = "" if spec.unit == "1" else f" [{spec.unit}]"
        return f"{spec.text}{unit}; {spec.allowed()}"
    choices = place.metadata["choices"]
    among = f"; one of {', '.join(choices)}" if choices else ""
    return place.metadata["text"] + among


def _text(place: Field[Any], value: Any) -> str:
    spec = place.metadata.get("quantity")
    if isinstance(value, BrakeFile):
        value = value.name
    if spec is None:
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if spec.unit == "1":
        return repr(value)
    return f'"{exact_text(float(value), spec.unit)}"'
