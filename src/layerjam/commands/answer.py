"""What a verb returns, and how its arguments become SI."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from layerjam.commands.quantities import (
    AnyBrake,
    brake_file,
    si,
    slip_within,
    vacuum_within,
)
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.simulate.quantities import CROSSHEAD_SPEED, ELONGATION, SLIP, VACUUM
from layerjam.units import QuantitySpec

__all__ = ["SLIP", "VACUUM", "AnyBrake", "si"]
Quantity = float | str
SPEED, TRAVEL = CROSSHEAD_SPEED, ELONGATION

NORMAL_FORCE = QuantitySpec("N", "normal force", open_lo=True)


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


def brake_at(brake: AnyBrake, atmosphere: Quantity | None) -> BrakeFile:
    """The brake, at the site's atmosphere if one is given."""
    return brake_file(brake, atmosphere)


def vacuum_of(value: Quantity, brake: Brake, name: str = "vacuum") -> float:
    """A vacuum [Pa] that the site allows."""
    return float(vacuum_within(si(value, VACUUM, name), brake, name))


def slip_of(value: Quantity, brake: Brake) -> tuple[float, list[str]]:
    """A slip [m] within the overlap, and what to say of one beyond the usable travel."""
    slip = si(value, SLIP, "slip")
    return slip, list(slip_within(slip, brake))
