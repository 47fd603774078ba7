"""Published brakes, dampers and clutches with mass and force, each quoted from its source."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any

from layerjam.core.brief import brief
from layerjam.core.errors import FileError
from layerjam.core.toml_files.reader import DESCRIBING, Reader
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.toml import parse_toml
from layerjam.core.toml_files.values import Entry, TextSpec
from layerjam.core.units import QuantitySpec

FIELDS: Mapping[str, Entry] = {
    "mass": Entry(QuantitySpec("kg", "mass of the device", open_lo=True, hi=1e6), True),
    "force": Entry(QuantitySpec("N", "maximum force", open_lo=True, hi=1e9)),
    "torque": Entry(QuantitySpec("N m", "maximum torque", open_lo=True, hi=1e9)),
    "lever": Entry(QuantitySpec("m", "lever arm of the torque", open_lo=True, hi=100)),
}
_REQUIRED = dict.fromkeys(("name", "class", "words"), Entry(TextSpec(blank=False)))
_SHEET, _NONE = "paper-sheet", "looked_for"


@dataclass(frozen=True, kw_only=True)
class PublishedDevice:
    """Published device: `kind` is its class, `words` a quotation, `note` a remark by layerjam."""

    name: str
    kind: str
    mass: float
    """Mass [kg]."""
    force: float
    """Force [N]; for a rotary device, the torque divided by the lever arm."""
    torque: float | None
    """Torque [N m]; None for a linear device."""
    lever: float | None
    """Lever arm [m]."""
    words: str
    note: str
    sources: Mapping[str, Source] = field(repr=False)

    @property
    def density(self) -> float:
        """Force per mass [N/kg]."""
        return self.force / self.mass

    def source(self) -> str:
        """Return the sources of mass and force, conflicts between them, and the quotation."""
        notes = dict.fromkeys(s.text for s in self.sources.values())
        notes |= dict.fromkeys(
            f"conflict: {s.conflict}" for s in self.sources.values() if s.conflict
        )
        return f"{'; '.join(notes)}: '{self.words}'"


@brief
@dataclass(frozen=True, kw_only=True)
class PublishedDevices:
    """The catalogue: devices, the paper's effect of one more sheet, and empty classes."""

    devices: tuple[PublishedDevice, ...]
    sheet: PublishedDevice
    looked_for: Mapping[str, str]
    """{class: search history} of classes without a device whose mass and force are published."""


@cache
def published_devices() -> PublishedDevices:
    """Return the catalogue that is part of the package."""
    place = files("layerjam.workshop.design") / "catalogue" / "published_devices.toml"
    return read_published_devices(place.read_text(encoding="utf-8"), "published_devices.toml")


def read_published_devices(text: str, path: object) -> PublishedDevices:
    """Return devices from TOML text.

    Raises FileError if a device lacks its name, class, words, mass, the source of a number, or a
    force (or a torque with its lever), or if a class that has a device is also listed as empty.
    """
    tables = parse_toml(text, path)
    searches = tables.pop(_NONE, {})
    devices = {key: _read_device(key, table, text, path) for key, table in tables.items()}
    if _SHEET not in devices:
        raise FileError(path, f"[{_SHEET}] is missing")
    sheet = devices.pop(_SHEET)
    found_kinds = {r.kind for r in devices.values()} & set(searches)
    if found_kinds:
        raise FileError(
            path, f"{', '.join(sorted(found_kinds))}: listed here and again under [{_NONE}]"
        )
    return PublishedDevices(
        devices=tuple(devices.values()), sheet=sheet, looked_for=MappingProxyType(searches)
    )


def _read_device(key: str, table: Any, text: str, path: object) -> PublishedDevice:
    if not isinstance(table, dict):
        raise FileError(path, f"{key} must be a table, [{key}]")
    reader = Reader(text, path, FIELDS, {**DESCRIBING, **_REQUIRED})
    reader.read_all(table)
    for name in _REQUIRED:
        if name not in reader.words:
            raise FileError(path, f"[{key}] has no {name}")
    values, sources, words = reader.values, reader.sources, reader.words
    bare_names = [name for name, source in sources.items() if not source.text]
    if bare_names:
        raise FileError(path, f"[{key}] names no source for {', '.join(bare_names)}")
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
