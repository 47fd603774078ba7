"""Units of time, length and force as machines spell them: `Sek.`, `lbF`, `кН`, `毫米`, `㎜`.

They have priority over the table of all units, which would interpret `Min` as megainches.
"""

import math
import re
import unicodedata
from fractions import Fraction
from functools import lru_cache

from layerjam.core.conversion import unit_factor
from layerjam.laboratory.measure.readers.words import VOCABULARY

ROLES = {"time": "s", "elongation": "m", "force": "N"}

_KNOWN = {
    word: (role, Fraction(size))
    for role, sizes in VOCABULARY["units"].items()
    if role in ROLES
    for size, words in sizes.items()
    for word in words.split()
}
CLOCK, DATE = "hh:mm:ss", "date and time"
"""Units of columns of time stamps; see stamps.py."""
_KNOWN |= dict.fromkeys((CLOCK, DATE), ("time", Fraction(1)))
# units in which upper and lower case differ in meaning
_CASED = {
    "N": ("force", Fraction(1)),
    "mN": ("force", Fraction(1, 1000)),
    "MN": ("force", Fraction(10**6)),
    "мН": ("force", Fraction(1, 1000)),
    "МН": ("force", Fraction(10**6)),
}
_WEIGHTS = {
    word: unit for unit, words in VOCABULARY["units"]["mass"].items() for word in words.split()
}
_SANE = (Fraction(1, 10**12), Fraction(10**8))


@lru_cache(maxsize=4096)
def unit_role(unit: str) -> tuple[str, Fraction] | None:
    """Return (role, factor to SI) of a unit; None for units of other quantities."""
    return common_unit(unit) or _look_up_unit(unit)


@lru_cache(maxsize=4096)
def common_unit(unit: str) -> tuple[str, Fraction] | None:
    """Return (role, factor to SI) of a unit as machines spell it; None for any other unit."""
    if not 0 < len(unit.strip()) <= 20:
        return None
    text = unicodedata.normalize("NFKC", unit).strip().replace("µ", "μ")
    text = re.sub(r"^(?:in|en|em|w|в) (?=\S)", "", text).rstrip(".").strip()
    if text in ("M", "H", "М"):
        return None  # ambiguous: mega, henry or a mass
    lower = text.lower()
    return _CASED.get(text) or _KNOWN.get(lower) or _KNOWN.get(re.sub(r"[ _]", "-", lower))


def force_unit_for(unit: str) -> str | None:
    """Return the force unit meant by a mass unit on a load cell, such as gf for g."""
    text = unicodedata.normalize("NFKC", unit).strip().rstrip(".").strip()
    return _WEIGHTS.get(text.lower()) if text not in ("G", "T") else None


def _look_up_unit(unit: str) -> tuple[str, Fraction] | None:
    """Return (role, factor) from the table of all units (pdl, dm, Å) if its size is plausible."""
    text = unicodedata.normalize("NFKC", unit).strip()
    if not 0 < len(text) <= 20 or "/" in text or any(c.isdigit() for c in text):
        return None  # units of other quantities, such as mm/min or mm2
    if force_unit_for(text) or len(text) == 1:
        return None
    for role, si in ROLES.items():
        factor = unit_factor(text, si)
        if factor is not None and _SANE[0] <= factor <= _SANE[1]:
            return role, factor
    return None


_STANDARD_GRAVITY = Fraction(980665, 100000)
_GRAVITIES = {
    prefix + name: _STANDARD_GRAVITY * factor
    for name in ("g", "gn", "g_n", "g0", "gs", "gee", "g's")
    for prefix, factor in (("", 1), ("m", Fraction(1, 1000)), ("milli-", Fraction(1, 1000)))
}
_KELVIN = (Fraction(1), 0.0)
_CELSIUS = (Fraction(1), 273.15)
_FAHRENHEIT = (Fraction(5, 9), 459.67 * 5 / 9)
_TEMPERATURES = dict.fromkeys(("k", "kelvin"), _KELVIN)
_TEMPERATURES |= dict.fromkeys(("°c", "c", "degc", "deg c", "celsius"), _CELSIUS)
_TEMPERATURES |= dict.fromkeys(("°f", "degf", "f"), _FAHRENHEIT)
_STRAINS = ("mm/mm", "m/m", "in/in", "-", "1")
_PRESSURES = {p.lower(): p for p in ("kPa", "MPa", "hPa", "mbar", "bar", "psi", "torr")}
PRESSURE = re.compile(
    r"(?P<unit>[a-z0-9]+?)(?: ?[(_.]?(?P<how>abs|absolute|gauge|gage|rel|a|g|ü)\)?)?", re.IGNORECASE
)


@lru_cache(maxsize=4096)
def convert_unit(unit: str, si: str) -> tuple[Fraction, float] | None:
    """Return (factor, offset) with SI value = factor * value + offset, or None.

    Besides all known units, it accepts machines' spellings of time, length and force, °C and °F, g
    and mg as accelerations, bara and barg.
    """
    text = re.sub(r"(?<=m)([23])$", r"^\1", unit.strip())  # for example: N/mm2
    role = next((role for role, of_role in ROLES.items() if of_role == si), None)
    if role is not None:
        unit_found = unit_role(text)
        return (unit_found[1], 0.0) if unit_found and unit_found[0] == role else None
    if si == "K":
        return _TEMPERATURES.get(text.lower())
    if si == "m/s^2" and text.lower() in _GRAVITIES:
        return _GRAVITIES[text.lower()], 0.0
    factor = unit_factor(text, si) if text else None
    if factor is None and si == "1" and text.lower() in _STRAINS:
        factor = Fraction(1)
    if factor is None and si == "Pa" and (match := PRESSURE.fullmatch(text)):
        factor = unit_factor(match["unit"], si)
        if factor is None and match["unit"].lower() in _PRESSURES:
            factor = unit_factor(_PRESSURES[match["unit"].lower()], si)
    return None if factor is None else (factor, 0.0)


def is_other_unit(file_unit: str, unit: str, si: str) -> bool:
    """Return whether the unit in a file is known and differs from the given one.

    It may differ in size or in dimension; for a force, g means gf. False for an unknown unit.
    """
    given_scale, file_scale = convert_unit(unit, si), convert_unit(file_unit, si)
    if file_scale is None and si == "N" and (weight := force_unit_for(file_unit)):
        file_scale = convert_unit(weight, si)
    if file_scale is None:
        return any(
            convert_unit(file_unit, si_unit) for si_unit in (*ROLES.values(), "Pa") if si_unit != si
        )
    return given_scale is not None and not (
        math.isclose(file_scale[0], given_scale[0], rel_tol=1e-6)
        and abs(file_scale[1] - given_scale[1]) < 1e-6
    )
