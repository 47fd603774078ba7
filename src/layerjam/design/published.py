"""Brakes, dampers and clutches that others make: mass and force, each with its source's words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any

from layerjam.errors import FileError
from layerjam.records.reader import DESCRIBING, Reader
from layerjam.records.source import Source
from layerjam.records.toml import parse_toml
from layerjam.records.values import Entry, TextSpec
from layerjam.units import QuantitySpec

FIELDS: Mapping[str, Entry] = MappingProxyType(
    {
        "mass": Entry(QuantitySpec("kg", "mass of the device", open_lo=True, hi=1e6), True),
        "force": Entry(QuantitySpec("N", "greatest force", open_lo=True, hi=1e9)),
        "torque": Entry(QuantitySpec("N m", "greatest torque", open_lo=True, hi=1e9)),
        "lever": Entry(QuantitySpec("m", "lever arm of the torque", open_lo=True, hi=100)),
    }
)
_DUE = dict.fromkeys(("name", "class", "words"), Entry(TextSpec(blank=False)))
_SHEET, _NONE = "paper-sheet", "looked_for"


@dataclass(frozen=True, kw_only=True)
class PublishedDevice:
    """A device: `kind` is its class, `words` are the source's own, `note` is ours."""

    name: str
    kind: str
    mass: float
    """[kg]"""
    force: float
    """[N]; of a rotary device its torque over the lever arm"""
    torque: float | None
    """[N m]; None for a linear device"""
    lever: float | None
    """[m]"""
    words: str
    note: str
    sources: Mapping[str, Source] = field(repr=False)

    @property
    def density(self) -> float:
        """Force over mass [N/kg]."""
        return self.force / self.mass

    def source(self) -> str:
        """Where mass and force were read, what contradicts them, and the words."""
        said = dict.fromkeys(s.text for s in self.sources.values())
        said |= dict.fromkeys(
            f"conflict: {s.conflict}" for s in self.sources.values() if s.conflict
        )
        return f"{'; '.join(said)}: '{self.words}'"


@dataclass(frozen=True, kw_only=True)
class PublishedDevices:
    """All of the catalogue: devices, what a sheet adds by the paper, classes without a device."""

    devices: tuple[PublishedDevice, ...]
    sheet: PublishedDevice
    looked_for: Mapping[str, str]
    """Class to what was looked at, for classes where no device had both numbers in a source."""


@cache
def published_devices() -> PublishedDevices:
    """The catalogue that comes with the package."""
    place = files("layerjam.design") / "catalogue" / "published_devices.toml"
    return read_published(place.read_text(encoding="utf-8"), "published_devices.toml")


def read_published(text: str, path: object) -> PublishedDevices:
    """Devices from TOML text.

    Raises FileError where a device lacks its name, class, words, mass, the source of a number, or
    a force (or a torque with its lever), or where a class is both found and looked for in vain.
    """
    tables = parse_toml(text, path)
    looked = tables.pop(_NONE, {})
    made = {key: _device(key, table, text, path) for key, table in tables.items()}
    if _SHEET not in made:
        raise FileError(path, f"[{_SHEET}] is missing")
    sheet = made.pop(_SHEET)
    both = {r.kind for r in made.values()} & set(looked)
    if both:
        raise FileError(path, f"{', '.join(sorted(both))}: found, and yet under [{_NONE}]")
    return PublishedDevices(
        devices=tuple(made.values()), sheet=sheet, looked_for=MappingProxyType(looked)
    )


def _device(key: str, table: Any, text: str, path: object) -> PublishedDevice:
    if not isinstance(table, dict):
        raise FileError(path, f"{key} must be a table, [{key}]")
    reader = Reader(text, path, FIELDS, {**DESCRIBING, **_DUE})
    reader.take(table)
    for name in _DUE:
        if name not in reader.words:
            raise FileError(path, f"[{key}] has no {name}")
    values, sources, words = reader.values, reader.sources, reader.words
    bare = [name for name, source in sources.items() if not source.text]
    if bare:
        raise FileError(path, f"[{key}] names no source for {', '.join(bare)}")
    turns = {"torque", "lever"} & set(values)
    if "mass" not in values or ("force" in values) == (len(turns) == 2) or len(turns) == 1:
        raise FileError(path, f"[{key}] needs a mass, and either a force or a torque with a lever")
    force = values["force"] if "force" in values else values["torque"] / values["lever"]
    return PublishedDevice(
        name=words["name"],
        kind=words["class"],
        mass=values["mass"],
        force=force,
        torque=values.get("torque"),
        lever=values.get("lever"),
        words=words["words"],
        note=words.get("note", ""),
        sources=sources,
    )
