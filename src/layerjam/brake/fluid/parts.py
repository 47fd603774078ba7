"""The catalogue of pumps, valves and sensors, and the values that a line uses from an entry.

An entry's keys are the fields of the line's record (Pump, Valve, Sensor). Other values in a data
sheet are kept for reference (`PRINTED`) and have no effect. Values that a line needs but no source
states are marked as assumed (`ASSUMED`).
"""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any

from layerjam.brake.fluid.line import Pump, Sensor, Valve
from layerjam.brake.fluid.pump_curve import CURVE, CurveSpec
from layerjam.core.brief import brief
from layerjam.core.errors import QuantityError, UnknownNameError
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.toml import parse_toml
from layerjam.core.toml_files.values import Entry, TextSpec
from layerjam.core.units import QuantitySpec, quantities

FAMILIES: Mapping[str, type] = MappingProxyType({"pump": Pump, "valve": Valve, "sensor": Sensor})
NEEDED = {"pump": "flow", "valve": "conductance", "sensor": "range"}
"""{kind of part: value without which a line cannot use it}; a pump may have a curve instead."""
_EXTRA: dict[str, Any] = tomllib.loads(
    (files("layerjam.brake.fluid") / "catalogue" / "beside.toml").read_text(encoding="utf-8")
)
ASSUMED: dict[str, dict[str, tuple[object, str]]] = _EXTRA["assumed"]
_TEXTS = {word: TextSpec(blank=word == "note") for word in ("name", "kind", "note")}
PRINTED: Mapping[str, QuantitySpec] = MappingProxyType(
    {name: QuantitySpec(**spec) for name, spec in _EXTRA["printed"].items()}
)
"""Values stated in data sheets that are not fields of a line, with their units."""


@brief
@dataclass(frozen=True, kw_only=True)
class Part:
    """One entry of the catalogue: its values in SI, each with its source."""

    name: str
    family: str
    title: str
    kind: str
    values: Mapping[str, Any]
    """Fields of the line's record, including assumed ones."""
    printed: Mapping[str, float]
    """Other values that its sources state (`PRINTED`)."""
    sources: Mapping[str, Source] = field(repr=False)
    entries: Mapping[str, object] = field(repr=False)
    """Fields as TOML values, for a line file."""
    note: str = ""

    @property
    def missing(self) -> str | None:
        """Return the name of a value that a line needs but no source states, or None."""
        need = NEEDED[self.family]
        return None if need in self.values or "curve" in self.values else need


def family_fields(family: str) -> dict[str, QuantitySpec | CurveSpec]:
    """Return the fields of a family's record, including a pump's curve."""
    specs: dict[str, QuantitySpec | CurveSpec] = {
        name: spec for name, spec, _ in quantities(FAMILIES[family])
    }
    return {**specs, "curve": CURVE} if family == "pump" else specs


@cache
def parts(family: str) -> Mapping[str, Part]:
    """Return the entries of a family ("pump", "valve" or "sensor") by name, read-only."""
    if family not in FAMILIES:
        raise UnknownNameError("family of parts", family, FAMILIES)
    place = files("layerjam.brake.fluid") / "catalogue" / f"{family}s.toml"
    read = read_parts(place.read_text(encoding="utf-8"), f"{family}s.toml", family)
    return MappingProxyType(read)


def read_parts(text: str, path: object, family: str) -> dict[str, Part]:
    """Return the parts in the text of a catalogue; FileError with the line if it is invalid."""
    tables = parse_toml(text, path)
    return {name: _read_part(name, table, text, path, family) for name, table in tables.items()}


def _read_part(name: str, table: Any, text: str, path: object, family: str) -> Part:
    specs = family_fields(family)
    fields = {f"{name}.{k}": Entry(spec) for k, spec in {**PRINTED, **specs}.items()}
    reader = Reader(text, path, fields)
    if not isinstance(table, dict):
        raise reader.make_error(name, f"{name} must be a table, [{name}]")
    with reader.locate_errors(name):
        words = {k: spec.read(table.get(k, ""), f"{name}.{k}") for k, spec in _TEXTS.items()}
    entries = {k: _read_entry(v, table) for k, v in table.items() if k not in _TEXTS}
    ends = entries.get("free_flow"), entries.get("ultimate_vacuum")
    if "curve" not in entries and all(isinstance(e, dict) and "value" in e for e in ends):
        entries["curve"] = _straight_curve(*ends)
    for key, entry in entries.items():
        reader.read_entry(f"{name}.{key}", entry)
        if not reader.sources[f"{name}.{key}"].text:
            raise reader.make_error(f"{name}.{key}", f"{name}.{key} names no source")
    for key, (value, reason) in ASSUMED[family].items():
        if key not in entries and not (key == "ultimate" and "curve" in entries):
            entries[key] = assumed_entry(value, reason)
            reader.read_entry(f"{name}.{key}", entries[key])
    values = {k.removeprefix(f"{name}."): v for k, v in reader.values.items()}
    return Part(
        name=name,
        family=family,
        title=words["name"],
        kind=words["kind"],
        note=words["note"],
        values={k: v for k, v in values.items() if k in specs},
        printed={k: v for k, v in values.items() if k not in specs},
        sources={k.removeprefix(f"{name}."): s for k, s in reader.sources.items()},
        entries={k: v for k, v in entries.items() if k in specs},
    )


def _read_entry(entry: Any, table: Mapping[str, Any]) -> Any:
    """Return an entry in which a source that refers to a KEY is replaced by that key's document."""
    text = entry.get("source") if isinstance(entry, dict) else None
    match = re.match(r"as (\w+)(.*)", text, re.DOTALL) if isinstance(text, str) else None
    if match is None or match.group(1) not in table:
        return entry
    # an entry can refer only to earlier entries of the catalogue, never to itself
    before = dict(list(table.items())[: list(table.values()).index(entry)])
    source = _read_entry(before.get(match.group(1), ""), before)
    document = str(source.get("source", "")) if isinstance(source, dict) else ""
    detail = match.group(2)
    return {
        **entry,
        "source": document.split(": '", maxsplit=1)[0] + detail if detail else document,
    }


def assumed_entry(value: object, reason: str) -> dict[str, object]:
    """Return an entry for a value that no source states."""
    return {"value": value, "kind": "assumed", "source": reason}


def _straight_curve(free: Any, greatest: Any) -> dict[str, object]:
    """Return a straight flow curve between the two end points that a data sheet states."""
    spread = "; ".join(e["spread"] for e in (free, greatest) if "spread" in e)
    return {
        "value": [["0 Pa", free["value"]], [greatest["value"], "0 m^3/s"]],
        "kind": "assumed",
        "source": "linear from free_flow to ultimate_vacuum, the two published ends: "
        f"{free.get('source', '')}; {greatest.get('source', '')}",
        **({"spread": spread} if spread else {}),
    }


def part_entries(family: str, name: object, overrides: Mapping[str, object]) -> dict[str, object]:
    """Return a line's table for a part; `overrides` replace the part's own entries.

    Raises UnknownNameError, or QuantityError if a value is missing that no source states.
    """
    entries = parts(family)
    if not isinstance(name, str) or name not in entries:
        raise UnknownNameError(family, str(name), entries)
    part = entries[name]
    if part.missing is not None and part.missing not in overrides and "curve" not in overrides:
        spec = family_fields(family)[part.missing]
        raise QuantityError.of(
            f"{family}.part",
            f"{name} has no {part.missing} ({spec.text}), which none of its sources "
            f"publishes; also give {family}.{part.missing}",
        )
    values = dict(part.entries)
    if "flow" in overrides and values.pop("curve", None) is not None:
        values["ultimate"] = assumed_entry(*ASSUMED["pump"]["ultimate"])
    if "curve" in overrides:
        values.pop("flow", None)
        values.pop("ultimate", None)
    return {**values, **overrides}
