"""What a verb returns, and how its arguments become SI."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.device.load import load
from layerjam.device.mount import Site
from layerjam.errors import QuantityError
from layerjam.records.source import Source
from layerjam.units import QuantitySpec, show, spec_of

Quantity = float | str
AnyBrake = str | Path | BrakeFile

VACUUM = QuantitySpec("Pa", "vacuum, the atmosphere less the pressure inside,")
SLIP = QuantitySpec("m", "slip")
FORCE = QuantitySpec("N", "force")
NORMAL_FORCE = QuantitySpec("N", "normal force", open_lo=True)
SPEED = QuantitySpec("m/s", "crosshead speed", lo=1e-6, hi=100)
TRAVEL = QuantitySpec("m", "travel of the crosshead", lo=1e-6, hi=10)


@dataclass(frozen=True, kw_only=True)
class Answer:
    """The keys of the command's contract as attributes, in SI; `None` is what is not known.

    `units` maps a key to its unit, `warnings` are sentences, `refused` maps a file to why it was
    not used, and `record` is the full result where there is one (a simulation, a fit).
    """

    values: Mapping[str, Any]
    units: Mapping[str, str]
    warnings: Sequence[str] = ()
    refused: Mapping[str, str] = field(default_factory=dict)
    record: Any = field(default=None, repr=False)

    def __getattr__(self, name: str) -> Any:
        values = self.__dict__.get("values", {})
        if name in values:
            return values[name]
        raise AttributeError(f"no '{name}' here; there are {', '.join(values)}")


def si(value: Quantity, spec: QuantitySpec, name: str) -> float:
    """The SI value of text or of a number that is SI already, checked against its bounds."""
    if isinstance(value, str):
        return float(spec.read(value, name))
    return float(spec.check(float(value), name))


def brake_at(brake: AnyBrake, atmosphere: Quantity | None) -> BrakeFile:
    """The brake, at the site's atmosphere if one is given."""
    file = brake if isinstance(brake, BrakeFile) else load(brake)
    if atmosphere is None:
        return file
    pressure = si(atmosphere, spec_of(Site, "atmosphere"), "atmosphere")
    site = replace(file.brake.site, atmosphere=pressure)
    stated = {"site.atmosphere": Source(kind="unstated", text="given with the command")}
    return replace(file, brake=replace(file.brake, site=site), sources={**file.sources, **stated})


def vacuum_of(value: Quantity, brake: Brake, name: str = "vacuum") -> float:
    """A vacuum [Pa] that the site allows."""
    pressure = si(value, VACUUM, name)
    if pressure > brake.site.atmosphere:
        raise QuantityError(
            f"{name}: {show(pressure, 'Pa', 6)} is more than the atmosphere, "
            f"{show(brake.site.atmosphere, 'Pa', 6)}; a vacuum is at most that"
        )
    return pressure


def slip_of(value: Quantity, brake: Brake) -> tuple[float, list[str]]:
    """A slip [m] within the overlap, and what to say of one beyond the usable travel."""
    slip, sheets = si(value, SLIP, "slip"), brake.sheets
    if slip > sheets.overlap:
        raise QuantityError(
            f"slip: {show(slip, 'm')} is beyond the overlap of {show(sheets.overlap, 'm')}; "
            "the sheets would have separated"
        )
    if slip > sheets.usable_travel:
        return slip, [
            f"slip {show(slip, 'm')} is beyond the usable travel of "
            f"{show(sheets.usable_travel, 'm')}"
        ]
    return slip, []
