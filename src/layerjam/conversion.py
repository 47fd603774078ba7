"""Conversion factors between units, and numbers from the quantity objects of other packages."""

import functools
import math
import re
from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from layerjam.errors import QuantityError

T = TypeVar("T")


class HasUnit(Protocol):
    """A pint quantity object."""

    @property
    def magnitude(self) -> Any:
        """Number or array."""

    @property
    def units(self) -> Any:
        """Unit of the number."""


class HasDtype(Protocol):
    """An array: NumPy, JAX, astropy, pandas or xarray."""

    @property
    def dtype(self) -> Any:
        """Type of the elements."""


class Quantity(Generic[T]):
    """Type of a record's field; the constructor also accepts text and objects with units."""

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: object) -> T: ...

        def __set__(self, instance: object, value: T | str | HasUnit | HasDtype) -> None: ...


_UNIT = re.compile(r"[A-Za-zµ°%\"'/*^·²³⁻¹\s()0-9-]{1,40}")

FACTORS = {
    "m": {"mm": "1e-3", "m": "1", "µm": "1e-6", "nm": "1e-9", "cm": "1e-2"},
    "Pa": {"kPa": "1e3", "Pa": "1", "MPa": "1e6", "GPa": "1e9", "mbar": "1e2", "bar": "1e5"},
    "N": {"N": "1", "mN": "1e-3", "kN": "1e3"},
    "N/m": {"kN/m": "1e3", "N/m": "1", "GN/m": "1e9", "MN/m": "1e6", "N/mm": "1e3"},
    "N/kg": {"kN/kg": "1e3", "N/kg": "1"},
    "kg": {"g": "1e-3", "kg": "1", "mg": "1e-6"},
    "m/s": {"mm/s": "1e-3", "m/s": "1", "cm/s": "1e-2", "mm/min": "1.6666666666667e-5"},
    "s": {"s": "1", "ms": "1e-3", "µs": "1e-6", "min": "60", "h": "3600"},
    "J": {"J": "1", "mJ": "1e-3", "kJ": "1e3"},
    "V": {"V": "1", "mV": "1e-3"},
    "m^2": {"cm^2": "1e-4", "m^2": "1", "mm^2": "1e-6"},
    "m^3": {"mL": "1e-6", "L": "1e-3", "m^3": "1"},
    "m^3/s": {
        "mL/s": "1e-6",
        "L/s": "1e-3",
        "µL/s": "1e-9",
        "L/min": "1.6666666666667e-5",
        "mL/min": "1.6666666666667e-8",
    },
    "m^3/Pa": {"mL/kPa": "1e-9", "µL/kPa": "1e-12"},
    "m^3/(s Pa)": {"L/(s bar)": "1e-8", "mL/(s bar)": "1e-11"},
}
"""{SI unit: {unit: factor}}, as in pint (a test compares them); importing pint takes 0.5 s.

Values are shown in these units, except for _TYPED; the usual unit comes first.
"""
_TYPED = {"cm", "mbar", "bar", "N/mm", "cm/s", "mm/min", "h", "kJ", "L/min", "mL/min"}


@functools.cache
def _unit_registry() -> Any:
    import pint

    try:
        return pint.UnitRegistry(cache_folder=":auto:")
    except Exception:  # the cache is read-only, or another process writes it: continue, but slowly
        return pint.UnitRegistry()


@functools.lru_cache(maxsize=512)
def unit_factor(unit: str, si: str) -> Fraction | None:
    """Return the factor from `unit` to the SI unit `si`, or None if no factor exists.

    The factor is the decimal that pint prints, so "mm" is exactly 1/1000.
    """
    if unit == si:
        return Fraction(1)
    factor = FACTORS.get(si, {}).get(unit)
    return Fraction(factor) if factor is not None else pint_factor(unit, si)


def pint_factor(unit: str, si: str) -> Fraction | None:
    """Return the factor from pint, which knows far more units but takes half a second to load."""
    text = unit.strip().replace("−", "-").replace("μ", "µ").replace('"', "inch")
    if not text or not _UNIT.fullmatch(text) or re.search(r"\d{2}|\*\*|\^\s*\(", text):
        return None
    text = re.sub(r"\b(k?)gf\b", r"\1gram_force", text).replace("kgram", "kilogram")
    if si == "1":
        return {"%": Fraction(1, 100), "percent": Fraction(1, 100)}.get(text)
    if re.fullmatch(r"[A-Za-zµ°]+ [A-Za-zµ°]+", text):
        text = text.replace(" ", "*")
    try:
        registry = _unit_registry()
        factor = registry.Quantity(1, registry.parse_units(text)).to(_to_pint_name(si)).magnitude
    except Exception:  # pint raises a dozen kinds of errors (and any parser error) for unknown text
        return None
    if not isinstance(factor, int | float) or not math.isfinite(factor) or factor <= 0:
        return None
    if registry.Quantity(0, registry.parse_units(text)).to(_to_pint_name(si)).magnitude != 0:
        return None  # a scale with a different zero, such as °C, has no factor
    # pint multiplies floats: 14 digits undo its rounding (g/cm^3 comes as 999.9999999999999)
    return Fraction(f"{factor:.14g}") if isinstance(factor, float) else Fraction(factor)


def _to_pint_name(si: str) -> str:
    return si.replace("(kg K)", "(kg*K)").replace("N s/m", "N*s/m").replace("(s Pa)", "(s*Pa)")


def shown_units(si: str) -> tuple[str, ...]:
    """Return the units in which a value is shown, the usual one first."""
    return tuple(unit for unit in FACTORS.get(si, (si,)) if unit not in _TYPED)


def strip_unit(value: Any, si: str, name: str) -> Any:
    """Return the SI number or array of a value that has a unit; other values are unchanged.

    Units are read from pint and astropy quantities, and from a DataArray or Series whose
    `attrs["units"]` names its unit. A DataArray remains a DataArray. Raises QuantityError for a
    unit with the wrong dimension, for an unknown unit, and for a table.
    """
    if hasattr(value, "columns") or hasattr(value, "data_vars"):
        kind = type(value).__name__
        raise QuantityError.of(name, f"a {kind} contains several quantities; give one column")
    if hasattr(value, "magnitude") and hasattr(value, "units"):  # a pint quantity from any registry
        return _convert_object(value, "magnitude", si, name)
    if hasattr(value, "to_value") and hasattr(value, "unit"):  # an astropy Quantity
        return _convert_object(value, "value", si, name)
    if hasattr(value, "dims") and hasattr(value, "copy"):
        data = strip_unit(value.data, si, name)
        plain = value if data is value.data else value.copy(data=data)
        return _convert_labelled(plain, "" if plain is not value else si, name)
    if hasattr(value, "attrs"):
        return _convert_labelled(value, si, name)
    unit = getattr(value, "unit", None) or getattr(value, "units", None)
    if unit is not None:
        raise QuantityError.of(
            name,
            f"{type(value).__name__} with unit '{unit}' is not understood; "
            "give text with a unit, a pint or astropy quantity, or a number in SI",
        )
    return value


def _convert_object(value: Any, number: str, si: str, name: str) -> Any:
    """Return the number of a quantity object in the SI unit `si`."""
    try:
        return getattr(value.to("" if si == "1" else _to_pint_name(si)), number)
    except Exception:  # each package raises its own errors
        goal = "a dimensionless number" if si == "1" else si
        raise QuantityError.of(name, f"{str(value)[:60]} cannot be converted to {goal}") from None


def _convert_labelled(value: Any, si: str, name: str) -> Any:
    """Return a labelled array, converted to SI if its attribute `units` names a different unit."""
    unit = value.attrs.get("units") if si else None
    if isinstance(unit, Mapping):
        unit = unit.get(value.name)
    if unit is None or unit == si:
        return value
    factor = unit_factor(str(unit), si)
    if factor is None:
        raise QuantityError.of(name, f"its attribute units, '{unit}', cannot be converted to {si}")
    return value * float(factor)
