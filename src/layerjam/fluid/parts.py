"""The catalogue of pumps, valves and sensors, and what a line takes from an entry.

An entry's keys are the fields of the line's record (Pump, Valve, Sensor) where it has one; what
else a data sheet prints is kept beside it (`PRINTED`) and counts for nothing. What a line needs and
no source prints is assumed (`ASSUMED`) and says so.
"""

from __future__ import annotations

import re
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
ASSUMED: dict[str, dict[str, tuple[object, str]]] = {
    "pump": {"ultimate": ("0 Pa", "not printed: no gas is taken to be kept back")},
    "valve": {
        "critical_ratio": (0.528, "not printed: that of a nozzle without losses is taken"),
        "delay": ("0 s", "not printed: taken to open at once"),
    },
    "sensor": {
        "lag": ("0 s", "not printed: taken to follow at once"),
        "noise": ("0 Pa", "not printed: taken as none"),
        "resolution": ("0 Pa", "not printed: taken as exact"),
        "offset": ("0 Pa", "not printed: taken as none"),
    },
}
_TEXTS = {word: TextSpec(blank=word == "note") for word in ("name", "kind", "note")}
_ANY = float("-inf")
PRINTED: Mapping[str, QuantitySpec] = MappingProxyType(
    {
        "free_flow": QuantitySpec("m^3/s", "free air without vacuum", open_lo=True),
        "ultimate_vacuum": QuantitySpec("Pa", "greatest vacuum", open_lo=True, hi=101325.0),
        "flow_in_all": QuantitySpec("m^3/s", "flow of all pumps", open_lo=True),
        "vacuum_reached": QuantitySpec("Pa", "a vacuum that was reached"),
        "voltage": QuantitySpec("V", "rated voltage"),
        "tube_bore": QuantitySpec("m", "inner diameter of its tube"),
        "tube_outer": QuantitySpec("m", "outer diameter of its tube"),
        "mass": QuantitySpec("kg", "mass"),
        "cv": QuantitySpec("1", "flow coefficient Cv"),
        "nominal_flow": QuantitySpec("m^3/s", "free air from 6 to 5 bar gauge"),
        "rated_flow": QuantitySpec("m^3/s", "flow between pressures that are not printed"),
        "bore": QuantitySpec("m", "nominal width"),
        "pressure_least": QuantitySpec("Pa", "least working pressure, gauge", lo=_ANY),
        "pressure_most": QuantitySpec("Pa", "greatest working pressure, gauge", lo=_ANY),
        "power": QuantitySpec("W", "electric power"),
        "range_least": QuantitySpec("Pa", "least pressure it shows", lo=_ANY),
        "range_most": QuantitySpec("Pa", "greatest pressure it shows", lo=_ANY),
        "error": QuantitySpec("Pa", "greatest error"),
        "accuracy": QuantitySpec("1", "accuracy, of the full scale"),
        "offset_stability": QuantitySpec("1", "stability of its offset, of the full scale"),
        "response": QuantitySpec("s", "10 to 90 % of a step"),
        "update": QuantitySpec("s", "time between readings"),
        "warm_up": QuantitySpec("s", "time to warm up"),
        "span_output": QuantitySpec("V", "output over the full range"),
        "output_at_atmosphere": QuantitySpec("V", "output at the atmosphere"),
        "sensitivity": QuantitySpec("V/Pa", "output per pressure"),
        "supply": QuantitySpec("V", "supply voltage"),
        "overpressure": QuantitySpec("Pa", "pressure it stands"),
    }
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
    with reader.located(name):
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
