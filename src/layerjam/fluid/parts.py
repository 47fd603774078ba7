"""The catalogue of pumps, valves and sensors, and what a line takes from an entry.

An entry's keys are the fields of the line's record (Pump, Valve, Sensor) where it has one; what
else a data sheet prints is kept beside it (`PRINTED`) and counts for nothing. What a line needs and
no source prints is assumed (`ASSUMED`) and says so.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any

from layerjam.errors import QuantityError, UnknownNameError
from layerjam.fluid.curve import CURVE, CurveSpec
from layerjam.fluid.line import Pump, Sensor, Valve
from layerjam.records.reader import Reader
from layerjam.records.source import Source
from layerjam.records.toml import parse_toml
from layerjam.records.values import Entry, TextSpec
from layerjam.units import QuantitySpec, quantities

FAMILIES: Mapping[str, type] = MappingProxyType({"pump": Pump, "valve": Valve, "sensor": Sensor})
NEEDED = {"pump": "flow", "valve": "conductance", "sensor": "range"}
"""Without which a part cannot stand in a line; a pump may have its curve instead."""
_BESIDE: dict[str, Any] = tomllib.loads(
    (files("layerjam.fluid") / "catalogue" / "beside.toml").read_text(encoding="utf-8")
)
ASSUMED: dict[str, dict[str, tuple[object, str]]] = _BESIDE["assumed"]
_TEXTS = {word: TextSpec(blank=word == "note") for word in ("name", "kind", "note")}
PRINTED: Mapping[str, QuantitySpec] = MappingProxyType(
    {name: QuantitySpec(**about) for name, about in _BESIDE["printed"].items()}
)
"""What data sheets print beside the fields of a line; each in its unit."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """One entry of the catalogue: its numbers in SI, each with its source."""

    name: str
    family: str
    title: str
    kind: str
    values: Mapping[str, Any]
    """Fields of the line's record, and what is assumed of it."""
    printed: Mapping[str, float]
    """What else its sources print (`PRINTED`)."""
    sources: Mapping[str, Source] = field(repr=False)
    entries: Mapping[str, object] = field(repr=False)
    """The fields as TOML has them, for a line's file."""
    note: str = ""

    @property
    def missing(self) -> str | None:
        """What no source prints and a line cannot do without."""
        need = NEEDED[self.family]
        return None if need in self.values or "curve" in self.values else need


def family_fields(family: str) -> dict[str, QuantitySpec | CurveSpec]:
    """Fields of a family's record, with a pump's curve."""
    found: dict[str, QuantitySpec | CurveSpec] = {
        name: spec for name, spec, _ in quantities(FAMILIES[family])
    }
    return {**found, "curve": CURVE} if family == "pump" else found


@cache
def parts(family: str) -> Mapping[str, Part]:
    """Every entry of a family, "pump", "valve" or "sensor", by name; read only."""
    if family not in FAMILIES:
        raise UnknownNameError("family of parts", family, FAMILIES)
    place = files("layerjam.fluid") / "catalogue" / f"{family}s.toml"
    read = read_parts(place.read_text(encoding="utf-8"), f"{family}s.toml", family)
    return MappingProxyType(read)


def read_parts(text: str, path: object, family: str) -> dict[str, Part]:
    """The parts of a catalogue's text; FileError with the line for what it cannot be."""
    tables = parse_toml(text, path)
    return {name: _part(name, table, text, path, family) for name, table in tables.items()}


def _part(name: str, table: Any, text: str, path: object, family: str) -> Part:
    own = family_fields(family)
    known = {f"{name}.{k}": Entry(spec) for k, spec in {**PRINTED, **own}.items()}
    reader = Reader(text, path, known)
    if not isinstance(table, dict):
        raise reader.fail(name, f"{name} must be a table, [{name}]")
    with reader.locate_errors(name):
        words = {k: spec.read(table.get(k, ""), f"{name}.{k}") for k, spec in _TEXTS.items()}
    entries = {k: _in_full(v, table) for k, v in table.items() if k not in _TEXTS}
    ends = entries.get("free_flow"), entries.get("ultimate_vacuum")
    if "curve" not in entries and all(isinstance(e, dict) and "value" in e for e in ends):
        entries["curve"] = _straight(*ends)
    for key, entry in entries.items():
        reader.entry(f"{name}.{key}", entry)
        if not reader.sources[f"{name}.{key}"].text:
            raise reader.fail(f"{name}.{key}", f"{name}.{key} names no source")
    for key, (value, why) in ASSUMED[family].items():
        if key not in entries and not (key == "ultimate" and "curve" in entries):
            entries[key] = assumed(value, why)
            reader.entry(f"{name}.{key}", entries[key])
    short = {k.removeprefix(f"{name}."): v for k, v in reader.values.items()}
    return Part(
        name=name,
        family=family,
        title=words["name"],
        kind=words["kind"],
        note=words["note"],
        values={k: v for k, v in short.items() if k in own},
        printed={k: v for k, v in short.items() if k not in own},
        sources={k.removeprefix(f"{name}."): s for k, s in reader.sources.items()},
        entries={k: v for k, v in entries.items() if k in own},
    )


def _in_full(entry: Any, table: Mapping[str, Any]) -> Any:
    """An entry whose source is "as KEY: ..." with that key's document named."""
    text = entry.get("source") if isinstance(entry, dict) else None
    match = re.match(r"as (\w+)(.*)", text, re.DOTALL) if isinstance(text, str) else None
    if match is None or match.group(1) not in table:
        return entry
    # an entry cannot refer to itself, and a catalogue's entries to earlier ones alone
    before = dict(list(table.items())[: list(table.values()).index(entry)])
    other = _in_full(before.get(match.group(1), ""), before)
    whole = str(other.get("source", "")) if isinstance(other, dict) else ""
    rest = match.group(2)
    return {**entry, "source": whole.split(": '", maxsplit=1)[0] + rest if rest else whole}


def assumed(value: object, why: str) -> dict[str, object]:
    """An entry of a number that no source prints."""
    return {"value": value, "kind": "assumed", "source": why}


def _straight(free: Any, greatest: Any) -> dict[str, object]:
    """A flow curve from what a data sheet prints of its ends."""
    spread = "; ".join(e["spread"] for e in (free, greatest) if "spread" in e)
    return {
        "value": [["0 Pa", free["value"]], [greatest["value"], "0 m^3/s"]],
        "kind": "assumed",
        "source": "straight from free_flow to ultimate_vacuum, the two ends that are printed: "
        f"{free.get('source', '')}; {greatest.get('source', '')}",
        **({"spread": spread} if spread else {}),
    }


def part_entries(family: str, name: object, beside: Mapping[str, object]) -> dict[str, object]:
    """A line's table for a part, with what its file says `beside` it in place of the part's own.

    Raises UnknownNameError, or QuantityError where a number is missing that no source prints.
    """
    known = parts(family)
    if not isinstance(name, str) or name not in known:
        raise UnknownNameError(family, str(name), known)
    part = known[name]
    if part.missing is not None and part.missing not in beside and "curve" not in beside:
        spec = family_fields(family)[part.missing]
        raise QuantityError.of(
            f"{family}.part",
            f"{name} has no {part.missing} ({spec.text}), which none of its "
            f"sources prints; give {family}.{part.missing} beside it",
        )
    taken = dict(part.entries)
    if "flow" in beside and taken.pop("curve", None) is not None:
        taken["ultimate"] = assumed(*ASSUMED["pump"]["ultimate"])
    if "curve" in beside:
        taken.pop("flow", None)
        taken.pop("ultimate", None)
    return {**taken, **beside}
