"""Records in other units: a result must change as its own unit says, whatever the units are."""

from __future__ import annotations

import dataclasses
import re
from typing import Any, NamedTuple

from layerjam.core.evolve import evolve

BASE = {
    "m": (1, 0, 0, 0), "kg": (0, 1, 0, 0), "s": (0, 0, 1, 0), "K": (0, 0, 0, 1),
    "N": (1, 1, -2, 0), "Pa": (-1, 1, -2, 0), "J": (2, 1, -2, 0), "W": (2, 1, -3, 0),
    "Hz": (0, 0, -1, 0), "1": (0, 0, 0, 0), "rad": (0, 0, 0, 0), "°C": (0, 0, 0, 1),
}  # fmt: skip
"""{unit: powers of length, mass, time and temperature}"""


class Units(NamedTuple):
    """Numbers of new units in one metre, kilogram, second and kelvin."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0
    temperature: float = 1.0

    def factor(self, unit: str) -> float:
        """Return the number of new units in one of an SI unit such as "kg/m^3" or "N s/m"."""
        unit = re.sub(r"/\(([^)]*)\)", lambda m: "/" + m[1].replace(" ", "/"), unit)
        out, sign = 1.0, 1
        for separator, name, power in re.findall(r"([/ ]?)([^/ ^]+)(?:\^(-?\d+))?", unit):
            sign = -1 if separator == "/" else 1
            powers = BASE[name]
            one = 1.0
            for base, exponent in zip(self, powers, strict=True):
                one *= base**exponent
            out *= one ** (sign * int(power or 1))
        return out

    def scale(self, rec: Any) -> Any:
        """Return a record with each quantity in the new units; nested records too."""
        changes = {}
        for field in dataclasses.fields(rec):
            value = getattr(rec, field.name)
            if value is None or isinstance(value, str):
                continue
            if "quantity" in field.metadata:
                unit = field.metadata["quantity"].unit
                changes[field.name] = value if unit == "1" else value * self.factor(unit)
            elif dataclasses.is_dataclass(value):
                changes[field.name] = self.scale(value)
        return evolve(rec, **changes)


OTHER = (Units(length=1e3, time=1e3), Units(mass=7.0), Units(3.0, 0.2, 11.0, 1.0))
"""Millimetres and milliseconds, a unit of mass that changes forces alone, and all of them."""
