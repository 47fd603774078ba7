"""Conversion factors between units, and numbers from the quantity objects of other packages."""

import functools
import importlib.util
import math
import re
import sys
from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from layerjam.core.errors import QuantityError
from layerjam.core.installation import install_command

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
"""{SI unit: {unit: factor}}, as in pint; a test compares them.

Values are shown in these units, except for _TYPED; the usual unit comes first.
"""
_TYPED = {"cm", "mbar", "bar", "N/mm", "cm/s", "mm/min", "h", "kJ", "L/min", "mL/min"}


_GRAVITY, _POUND = Fraction("9.80665"), Fraction("0.45359237")
_INCH = Fraction("0.0254")
_PSI = _POUND * _GRAVITY / _INCH**2
_BASES: dict[str, tuple[Fraction, tuple[int, int, int, int, int]]] = {
    "m": (Fraction(1), (1, 0, 0, 0, 0)),
    "g": (Fraction(1, 1000), (0, 1, 0, 0, 0)),
    "s": (Fraction(1), (0, 0, 1, 0, 0)),
    "A": (Fraction(1), (0, 0, 0, 1, 0)),
    "K": (Fraction(1), (0, 0, 0, 0, 1)),
    "rad": (Fraction(1), (0, 0, 0, 0, 0)),
    "Hz": (Fraction(1), (0, 0, -1, 0, 0)),
    "N": (Fraction(1), (1, 1, -2, 0, 0)),
    "Pa": (Fraction(1), (-1, 1, -2, 0, 0)),
    "bar": (Fraction(10**5), (-1, 1, -2, 0, 0)),
    "J": (Fraction(1), (2, 1, -2, 0, 0)),
    "W": (Fraction(1), (2, 1, -3, 0, 0)),
    "V": (Fraction(1), (2, 1, -3, -1, 0)),
    "L": (Fraction(1, 1000), (3, 0, 0, 0, 0)),
}
"""{unit: (factor to SI, powers of m, kg, s, A and K)}; these units take prefixes."""
_SPELLED = {
    "m": "meter meters metre metres",
    "g": "gram grams",
    "s": "sec second seconds",
    "N": "newton newtons",
    "Pa": "pascal pascals",
    "J": "joule joules",
    "W": "watt watts",
    "V": "volt volts",
    "L": "l liter liters litre litres",
    "Hz": "hertz",
    "rad": "radian radians",
    "K": "kelvin",
}
"""{unit: other names of it, with the same prefixes}."""
_OTHERS: dict[str, dict[str, int | Fraction]] = {
    "s": {"min minute minutes": 60, "h hr hour hours": 3600, "d day days": 86400},
    "m": {
        "in inch inches": _INCH,
        "ft foot feet": 12 * _INCH,
        "yd yard yards": 36 * _INCH,
        "thou": _INCH / 1000,
        "micron microns": Fraction(1, 10**6),
        "angstrom Å": Fraction(1, 10**10),
    },
    "g": {"lb lbs pound pounds": 1000 * _POUND, "oz ounce ounces": 1000 * _POUND / 16, "t": 10**6},
    "N": {
        "lbf": _POUND * _GRAVITY,
        "ozf": _POUND * _GRAVITY / 16,
        "gram_force": _GRAVITY / 1000,
        "kilogram_force": _GRAVITY,
        "dyn": Fraction(1, 10**5),
    },
    "Pa": {"psi": _PSI, "ksi": 1000 * _PSI, "atm": 101325, "torr": Fraction(101325, 760)},
    "L": {"cc": Fraction(1, 1000)},
}
"""{unit: {names: size in it}}; these names take no prefixes."""
_PREFIXES = {
    "p": -12, "n": -9, "µ": -6, "u": -6, "m": -3, "c": -2, "d": -1, "h": 2, "k": 3, "M": 6, "G": 9,
    "nano": -9, "micro": -6, "milli": -3, "centi": -2, "hecto": 2, "kilo": 3, "mega": 6, "giga": 9,
}  # fmt: skip
_OFFSETS = {"°C", "degC", "celsius", "°F", "degF", "fahrenheit"}
_SUPERSCRIPTS = str.maketrans("⁻¹²³", "-123")
_PART = re.compile(r"\s*([A-Za-zµ°Å_]+|1)(?:\^(-?[1-4]))?\s*")

Size = tuple[Fraction, tuple[int, ...]]
"""Factor to SI units, and powers of m, kg, s, A and K."""


@functools.cache
def _known_units() -> dict[str, Size]:
    """Return {name with its prefix: size} of the units that layerjam knows itself."""
    factors: dict[str, Size] = {}
    for unit, (factor, powers) in _BASES.items():
        for name in (unit, *_SPELLED.get(unit, "").split()):
            factors[name] = factor, powers
            for prefix, power in _PREFIXES.items():
                # "mm" or "millimeter", "mbar", "krad", but not "mmeter", "millim" or "hbar"
                is_word = len(name) > 3 or name == "sec"
                if (len(prefix) > 1) == is_word and prefix + name != "hbar":
                    factors.setdefault(prefix + name, (factor * Fraction(10) ** power, powers))
    for unit, others in _OTHERS.items():
        factor, powers = _BASES[unit]
        for names, ratio in others.items():
            factors |= dict.fromkeys(names.split(), (factor * Fraction(ratio), powers))
    factors |= dict.fromkeys(("deg", "degree", "degrees", "°"), (Fraction(math.pi) / 180, (0,) * 5))
    return factors


def _read_size(text: str) -> Size | None:
    """Return the size of a product of units such as "N s/m" or "m^3/(s Pa)"; None if unknown."""
    text = re.sub("[⁻¹²³]+", lambda m: "^" + m[0].translate(_SUPERSCRIPTS), text.replace("·", "*"))
    if (match := re.fullmatch(r"([^()]*/)\s*\(([^()]*)\)", text)) is not None:
        numerator = _read_size(match[1].rstrip().removesuffix("/"))
        denominator = _read_size(match[2])
        return (
            None
            if numerator is None or denominator is None
            else _multiply(numerator, denominator, -1)
        )
    size: Size = Fraction(1), (0,) * 5
    place, sign = 0, 1
    while (part := _PART.match(text, place)) is not None:
        unit = (Fraction(1), (0,) * 5) if part[1] == "1" else _known_units().get(part[1])
        if unit is None:
            return None
        size = _multiply(size, unit, sign * int(part[2] or 1))
        place = part.end()
        if place == len(text):
            return size
        sign = -1 if text[place] == "/" else 1
        place += text[place] in "/*"
    return None


def _multiply(size: Size, unit: Size, power: int) -> Size:
    powers = tuple(a + power * b for a, b in zip(size[1], unit[1], strict=True))
    return size[0] * unit[0] ** power, powers


@functools.cache
def _unit_registry() -> Any:
    import pint

    try:
        return pint.UnitRegistry(cache_folder=":auto:")
    except ImportError:
        raise
    except Exception:  # the cache is read-only, or another process writes it: continue, but slowly
        return pint.UnitRegistry()


@functools.lru_cache(maxsize=512)
def unit_factor(unit: str, si: str) -> Fraction | None:
    """Return the factor from `unit` to the SI unit `si`, or None if no factor exists.

    The factor is a decimal of 14 digits, so "mm" is exactly 1/1000. pint, if it is installed, knows
    the units that layerjam does not know itself.
    """
    if unit == si:
        return Fraction(1)
    factor = FACTORS.get(si, {}).get(unit)
    if factor is not None:
        return Fraction(factor)
    text = _clean_unit(unit)
    if text is None or si == "1":
        return {"%": Fraction(1, 100), "percent": Fraction(1, 100)}.get(text or "")
    if text in _OFFSETS:
        return None  # a scale with a different zero has no factor
    size, target = _read_size(text), _read_size(si)
    if size is None or target is None:
        return pint_factor(unit, si)
    return _round_factor(size[0] / target[0]) if size[1] == target[1] else None


def explain_rare_unit(unit: str) -> str | None:
    """Return that only pint may know a unit, and how to install it; None for any other unit."""
    text = _clean_unit(unit)
    if text is None or text in _OFFSETS or _read_size(text) is not None or _has_pint():
        return None
    if not any(sign.isalpha() for sign in text):
        return None
    return (
        f"the unit '{unit[:40]}' is not known without an optional package: "
        f"{install_command('units')}"
    )


def _has_pint() -> bool:
    return importlib.util.find_spec("pint") is not None


def _clean_unit(unit: str) -> str | None:
    """Return the text of a unit with the usual signs, or None if it cannot be one."""
    text = unit.strip().replace("−", "-").replace("μ", "µ").replace('"', "inch")
    if not text or not _UNIT.fullmatch(text) or re.search(r"\d{2}|\*\*|\^\s*\(", text):
        return None
    return re.sub(r"\b(k?)gf\b", r"\1gram_force", text).replace("kgram", "kilogram")


def _round_factor(factor: float | Fraction) -> Fraction:
    return Fraction(f"{float(factor):.14g}")


def pint_factor(unit: str, si: str) -> Fraction | None:
    """Return the factor from pint, or None if it does not know the unit or is not installed.

    pint knows far more units, but takes half a second to load.
    """
    text = _clean_unit(unit)
    if text is None or not _has_pint():
        return None
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
    return _round_factor(factor)


def _to_pint_name(si: str) -> str:
    return si.replace("(kg K)", "(kg*K)").replace("N s/m", "N*s/m").replace("(s Pa)", "(s*Pa)")


def shown_units(si: str) -> tuple[str, ...]:
    """Return the units in which a value is shown, the usual one first."""
    return tuple(unit for unit in FACTORS.get(si, (si,)) if unit not in _TYPED)


def refuse_traced(value: Any, name: str) -> None:
    """Raise QuantityError for a value that JAX traces; JAX is not loaded for it."""
    tracer = getattr(getattr(sys.modules.get("jax"), "core", None), "Tracer", None)
    if tracer is not None and isinstance(value, tracer):
        raise QuantityError.of(
            name,
            "is traced by JAX, but a command checks its input and cannot be differentiated or "
            "compiled; use a law of layerjam.laws, such as layerjam.laws.brake_force",
        )


def strip_unit(value: Any, si: str, name: str) -> Any:
    """Return the SI number or array of a value that has a unit; other values are unchanged.

    Units are read from pint and astropy quantities, and from a DataArray or Series whose
    `attrs["units"]` names its unit. A DataArray remains a DataArray. Raises QuantityError for a
    unit with the wrong dimension, for an unknown unit, and for a table.
    """
    if hasattr(value, "columns") or hasattr(value, "data_vars"):
        kind = type(value).__name__
        raise QuantityError.of(name, f"a {kind} contains several quantities; give one column")
    if hasattr(value, "magnitude") and hasattr(
        value, "units"
    ):  # this is a pint quantity, from any registry
        return _convert_object(value, "magnitude", si, name)
    if hasattr(value, "to_value") and hasattr(value, "unit"):  # this is an astropy Quantity
        return _convert_object(value, "value", si, name)
    if hasattr(value, "dims") and hasattr(value, "copy"):
        data = strip_unit(value.data, si, name)
        bare_value = value if data is value.data else value.copy(data=data)
        return _convert_labelled(bare_value, "" if bare_value is not value else si, name)
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
        reason = f"its attribute units, '{unit}', cannot be converted to {si}"
        raise QuantityError.of(name, explain_rare_unit(str(unit)) or reason)
    return value * float(factor)
