"""Conversion of text to SI values and back, and `quantity` fields with units and bounds.

Every number inside is an SI float. Only this module reads text such as ``"0.254 mm"``; `conversion`
reads the units, and a simple pattern the number. Expressions in a file are never evaluated.
"""

import functools
import math
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from decimal import ROUND_CEILING, Context, Decimal
from fractions import Fraction
from numbers import Real
from typing import Any, TypeVar, dataclass_transform

from layerjam.core.conversion import explain_rare_unit, shown_units, strip_unit, unit_factor
from layerjam.core.errors import QuantityError, explain_arguments, short_text
from layerjam.core.record_classes import add_record

T = TypeVar("T")

_NUMBER = r"[+-]?(?:[0-9]{1,40}(?:\.[0-9]{0,40})?|\.[0-9]{1,40})(?:[eE][+-]?[0-9]{1,3})?"
_QUANTITY = re.compile(rf"({_NUMBER})\s*([^\d\s+.-].{{0,40}})?", re.DOTALL)
_LONGEST = 120

# units to suggest if a unit is missing and the first two are unsuitable
_HINTS = {
    "m": ("mm", "cm"),
    "Pa": ("kPa", "mbar"),
    "N": ("N", "kN"),
    "N/m": ("kN/m", "N/mm"),
    "kg": ("g", "kg"),
}


def usual_unit(si: str) -> str:
    """Return the unit in which a quantity is usually read and typed, such as kPa for Pa."""
    return "" if si == "1" else shown_units(si)[0]


def examples(si: str, number: str = "") -> str:
    """Return examples in units suitable for the SI unit `si`, as a phrase for an error message."""
    units = _HINTS.get(si) or shown_units(si)[:2]
    return " or ".join(f"'{number} {u}'".replace("' ", "'") for u in units)


def parse(text: object, si: str, name: str) -> float:
    """Return the SI value of a text such as ``"94.5 kPa"``.

    `si` is the expected SI unit ("1" for a pure number, which has no unit and no %) and `name` is
    the quantity's name in the error. Raises QuantityError if the unit is missing or has the wrong
    dimension, or if the text is not a finite number.
    """
    if si == "1" and isinstance(text, int | float) and not isinstance(text, bool):
        return _check_finite(float(text) if abs(text) < 1e300 else math.inf, text, name)
    if not isinstance(text, str):
        if isinstance(text, int | float) and not isinstance(text, bool):
            raise QuantityError.of(
                name, f"{short_text(text)} has no unit; write {examples(si, short_text(text))}"
            )
        raise QuantityError.of(
            name, f"{short_text(text)} is not a quantity such as {examples(si, '1')}"
        )
    match = _QUANTITY.fullmatch(text.strip()) if len(text) <= _LONGEST else None
    if re.match(r"\s*[+-]?[0-9]+,[0-9]", text[:60]):
        raise QuantityError.of(name, f"{short_text(text)} has a decimal comma; use a decimal point")
    if not match:
        kind = "a pure number" if si == "1" else f"a number with a unit such as {examples(si)}"
        raise QuantityError.of(name, f"{short_text(text)} is not {kind}")
    number, unit = match.group(1), (match.group(2) or "").strip()
    if not unit and si != "1":
        raise QuantityError.of(name, f"'{number}' has no unit; write {examples(si, number)}")
    factor = unit_factor(unit, si) if unit else Fraction(1)
    if factor is None:
        hint = "no unit or %" if si == "1" else f"a unit such as {examples(si)}"
        reason = None if si == "1" else explain_rare_unit(unit)
        reason = f"{reason}, or" if reason else f"{short_text(text)} is not {_name_dimension(si)};"
        raise QuantityError.of(name, f"{reason} give {hint}")
    exact = Fraction(number) * factor
    try:
        value = float(exact)
    except OverflowError:
        value = math.inf
    if exact and not value:
        raise QuantityError.of(name, f"{short_text(text)} is too small a number")
    return _check_finite(value, text, name)


def _check_finite(value: float, text: object, name: str) -> float:
    if not math.isfinite(value):
        raise QuantityError.of(name, f"{short_text(text)} is not a finite number")
    return value


def is_traced(value: object) -> bool:
    """Return whether a value is traced by JAX; its number is then unknown."""
    core = getattr(sys.modules.get("jax"), "core", None)
    # a thread may be importing JAX at this moment
    return isinstance(value, getattr(core, "Tracer", ()))


def _name_dimension(si: str) -> str:
    names = {"m": "length", "Pa": "pressure", "N": "force", "kg": "mass", "s": "time"}
    return "a pure number" if si == "1" else f"in units of {names.get(si, si)}"


def show(value: float | None, si: str, digits: int = 4, like: float | None = None) -> str:
    """Return a value in a readable unit: ``show(0.013, "m") == "13 mm"``.

    If `like` is given, the unit suits `like`: an interval's ends then have the unit of its value.
    """
    if value is None:
        return "not known"
    if isinstance(value, bool):
        return str(value).lower()
    if not math.isfinite(value):
        return str(value)
    if si == "1":
        return f"{value:.0f}" if value == int(value) and abs(value) < 1e7 else f"{value:.{digits}g}"
    size = abs(value if like is None else like)
    best, factor = min(_shown_factors(si), key=lambda pair: _decades_outside_range(size / pair[1]))
    number = value / factor
    text = f"{number:.{digits}g}" if not 10**digits <= abs(number) < 1e7 else f"{number:.0f}"
    return f"{text} {best}"


@functools.cache
def _shown_factors(si: str) -> tuple[tuple[str, float], ...]:
    return tuple((unit, float(unit_factor(unit, si) or 1)) for unit in shown_units(si))


def show_at_least(value: float, si: str, limit: float = math.inf) -> str:
    """Return `show` of a value, rounded up to four digits or to as many as stay within `limit`."""
    unit = "" if si == "1" else show(value, si).split(" ", 1)[1]
    factor = (unit_factor(unit, si) if unit else None) or Fraction(1)
    exact = Fraction(value) / factor
    for digits in range(4, 18):
        context = Context(prec=digits, rounding=ROUND_CEILING)
        number = context.divide(Decimal(exact.numerator), Decimal(exact.denominator))
        if Fraction(number) * factor <= limit:
            return f"{number.normalize():f} {unit}".rstrip()
    return exact_text(value, si)


def _decades_outside_range(number: float) -> float:
    """Return the distance of a number from the range 0.1 to 1000, in decades."""
    if number == 0 or 0.1 <= number < 1000:
        return 0.0
    return abs(math.log10(number / (0.1 if number < 0.1 else 1000))) + 0.1


@functools.lru_cache(maxsize=4096, typed=True)
def exact_text(value: float, si: str) -> str:
    """Return the shortest text that `parse` reads as `value`, if possible in a usual unit."""
    if si == "1":
        return repr(value)
    usual_units = (*shown_units(si), *("mm/min" for _ in range(si == "m/s")))
    units = dict.fromkeys((show(value, si).split(" ", 1)[1], *usual_units, si))
    texts = [text for unit in units if (text := _exact_in_unit(value, unit, si))]
    # prefer a usual unit, even if the text is a few characters longer
    return next((t for t in texts if len(t) <= min(map(len, texts)) + 4), f"{value!r} {si}")


def _exact_in_unit(value: float, unit: str, si: str) -> str | None:
    """Return the shortest text in one unit, or None if even 17 digits do not give the value."""
    factor = unit_factor(unit, si) or Fraction(1)
    number = float(Fraction(value) / factor)
    for digits in range(1, 18):
        text = f"{number:.{digits}g}"
        if float(Fraction(text) * factor) == value:
            decimal_text = f"{float(text):.12f}".rstrip("0").rstrip(".")
            is_exact = Fraction(decimal_text) == Fraction(text)
            return f"{decimal_text if is_exact else text} {unit}"
    return None


@dataclass(frozen=True)
class QuantitySpec:
    """Definition of one quantity: SI unit, meaning, bounds (inclusive) and symbol.

    `example` is text that a user could type. A number without a unit between zero and
    `unlikely_below` is allowed, but with a warning: its unit has probably been forgotten.
    """

    unit: str
    text: str
    lo: float = 0.0
    hi: float = math.inf
    symbol: str = ""
    whole: bool = False
    open_lo: bool = False
    example: str = ""
    unlikely_below: float = 0.0

    def limits(self) -> str:
        """Return the bounds as a phrase."""
        low = f"{'more than' if self.open_lo else 'at least'} {show(self.lo, self.unit)}"
        if self.lo == 0:
            low = "more than zero" if self.open_lo else "zero or more"
        if math.isinf(self.hi):
            return low
        return f"{low} and at most {show(self.hi, self.unit)}"

    def check(self, value: float, name: str) -> float:
        """Return `value` if it lies within the bounds; raises QuantityError otherwise."""
        low_ok = value > self.lo if self.open_lo else value >= self.lo
        if not (math.isfinite(value) and low_ok and value <= self.hi):
            reason = f"{show(value, self.unit)} is not allowed; {self.text} must be {self.limits()}"
            raise QuantityError.of(name, reason + self._suggest_percent(value))
        if self.whole and value != int(value):
            raise QuantityError.of(name, f"{value} is not allowed; {self.text} must be an integer")
        return value

    def _suggest_percent(self, value: float) -> str:
        """Return how to write a number that was meant in percent, or an empty text."""
        is_meant = self.example.endswith("%") and self.lo <= value / 100 <= self.hi < value
        return f"; write {show(value, '1')}% or {show(value / 100, '1')}" if is_meant else ""

    def read(self, text: object, name: str) -> Any:
        """Return the SI value of text with a unit, or of a pure number, within the bounds."""
        if self.whole and isinstance(text, bool):
            raise QuantityError.of(name, f"{text} is not allowed; {self.text} must be an integer")
        if self.whole and isinstance(text, str) and re.fullmatch(r"\s*[0-9]{1,40}\s*", text):
            text = int(text)
        if self.whole and isinstance(text, int):
            # read it exactly, beyond the precision of a float, because seeds may need that
            self.check(text if abs(text) < 2**63 else math.inf, name)
            return text
        value = self.check(parse(text, self.unit, name), name)
        return int(value) if self.whole else value

    def si(self, value: Any, name: str) -> Any:
        """Return the checked SI value of text or an object with a unit, or of a number in SI."""
        value = strip_unit(value, self.unit, name)
        if is_traced(value):
            return value
        value = value.item() if getattr(value, "shape", None) == () else value
        if isinstance(value, str) or (self.whole and isinstance(value, int)):
            return self.read(value, name)
        if isinstance(value, bool) or not isinstance(value, Real):
            kind = "a pure number" if self.unit == "1" else "a number or a text with a unit"
            example = f", such as {examples(self.unit, '1')}" if self.unit != "1" else ""
            raise QuantityError.of(name, f"{short_text(value)} is not {kind}{example}")
        huge = abs(value) > 1e300  # type: ignore[operator]
        number = self.check(math.inf if huge else float(value), name)
        return int(number) if self.whole else number

    def array(self, value: Any, name: str, bounded: bool = True) -> Any:
        """Return an array of SI numbers, within the bounds if `bounded`; a DataArray remains one.

        Elements may be text or quantity objects. Raises QuantityError.
        """
        import numpy as np

        if hasattr(value, "dims"):
            return value.copy(data=self.array(value.data, name, bounded))
        if isinstance(value, np.ma.MaskedArray) and np.ma.getmaskarray(value).any():
            raise QuantityError.of(name, "some elements are masked; omit them, or fill them")
        kind = getattr(getattr(value, "dtype", None), "kind", "O")
        if kind in "OSTU":
            objects = np.asarray(value, dtype=object)
            numbers = [self.si(element, name) for element in objects.ravel()]
            value, kind = np.array(numbers, dtype=float).reshape(objects.shape), "f"
        if kind not in ("fiub" if isinstance(self, FlagSpec) else "fiu"):
            raise QuantityError.of(name, f"elements of type {value.dtype} are not real numbers")
        values = np.asarray(value, dtype=None if self.whole else float)
        if bounded and not values.size:
            raise QuantityError.of(name, "the array is empty; give at least one number")
        for edge in (values.min(), values.max()) if bounded else ():
            self.check(edge.item(), name)
        return values

    def to_toml(self, value: Any) -> object:
        """Return the value for a TOML file: text with a unit, or a pure number."""
        if self.unit != "1":
            return exact_text(float(value), self.unit)
        return int(value) if self.whole else float(value)


@dataclass(frozen=True, kw_only=True)
class FlagSpec(QuantitySpec):
    """A switch; arrays and sweeps store it as 1 and 0."""

    unit: str = "1"
    text: str
    hi: float = 1.0

    def limits(self) -> str:
        """Return the two allowed words."""
        return "true or false"

    def check(self, value: Any, name: str) -> bool:
        """Return `value` as a bool; raises QuantityError for a number other than 1 and 0."""
        if value not in (0, 1):
            raise QuantityError.of(name, f"{short_text(value)} is not allowed; write true or false")
        return bool(value)

    def read(self, text: object, name: str) -> bool:
        """Return the switch that a file states."""
        if not isinstance(text, bool):
            raise QuantityError.of(name, "must be true or false")
        return text

    def si(self, value: str | float, name: str) -> bool:
        """Return the switch from text or a bool; raises QuantityError for a number."""
        words = {"true": True, "false": False}
        return self.read(words.get(value.strip(), value) if isinstance(value, str) else value, name)

    def to_toml(self, value: Any) -> bool:
        """Return the value for a TOML file."""
        return bool(value)


def flag(text: str, *, default: Any = MISSING) -> Any:
    """Return a dataclass field that is true, false or None (unknown), treated as a quantity."""
    return field(default=default, metadata={"quantity": FlagSpec(text=text)})


def quantity(
    unit: str,
    text: str,
    *,
    lo: float = 0.0,
    hi: float = math.inf,
    symbol: str = "",
    whole: bool = False,
    open_lo: bool = False,
    default: Any = MISSING,
) -> Any:
    """Return a dataclass field with unit, meaning, bounds and symbol; None means unknown."""
    spec = QuantitySpec(unit, text, lo, hi, symbol, whole, open_lo)
    return field(default=default, metadata={"quantity": spec})


def like(spec: QuantitySpec, text: str = "", *, default: Any = MISSING) -> Any:
    """Return a field for a quantity that is defined elsewhere, with a different description."""
    return field(default=default, metadata={"quantity": replace(spec, text=text or spec.text)})


@dataclass_transform(
    kw_only_default=True, frozen_default=True, field_specifiers=(quantity, flag, like, field)
)
def record(cls: type[T]) -> type[T]:
    """Return a frozen, keyword-only dataclass of quantities (SI floats) and nested records.

    Its constructor reads text and quantity objects, and raises QuantityError for a number that
    would be invalid in a file. An array may contain any numbers, with NaN for a case without a
    value. Values traced by JAX are not checked. The `validate` method of the class detects
    contradictory fields. `evolve` changes numbers without checks, such as steps of a fit.
    """
    cls.__post_init__ = _convert_quantities  # type: ignore[attr-defined]
    dataclass_type = explain_arguments(dataclass(frozen=True, kw_only=True)(cls))
    add_record(dataclass_type)
    return dataclass_type


def _convert_quantities(rec: Any) -> None:
    """Check the fields of a new record, and convert text and quantity objects to SI numbers."""
    for name, spec, kind, optional in _fields_to_check(rec.__class__):
        value = getattr(rec, name)
        if value is None and optional:
            continue
        if spec is None:
            if not isinstance(value, kind):
                raise QuantityError.of(name, f"{short_text(value)} is not {kind.__name__}")
        elif isinstance(value, Real):
            spec.check(value, name)  # type: ignore[arg-type]
        elif hasattr(value := strip_unit(value, spec.unit, name), "dtype"):
            values = value if is_traced(value) else spec.array(value, name, bounded=False)
            object.__setattr__(rec, name, values)
        else:
            object.__setattr__(rec, name, spec.si(value, name))
    if hasattr(rec, "validate") and not _has_arrays(rec):
        rec.validate()


def _has_arrays(value: Any) -> bool:
    if is_dataclass(value):
        return any(_has_arrays(getattr(value, f.name)) for f in fields(value))
    return getattr(value, "ndim", 0) > 0 or is_traced(value)


@functools.cache
def _fields_to_check(cls: type) -> list[tuple[str, QuantitySpec | None, type, bool]]:
    """Return (name, specification or None, class of a nested record, whether None is allowed)."""
    return [
        (f.name, f.metadata.get("quantity"), f.metadata.get("record", object), f.default is None)
        for f in fields(cls)  # type: ignore[arg-type]
        if "quantity" in f.metadata or "record" in f.metadata
    ]


def get_spec(cls: type, name: str) -> QuantitySpec:
    """Return the QuantitySpec of a field of a record class."""
    return next(f.metadata["quantity"] for f in fields(cls) if f.name == name)  # type: ignore[arg-type]


def quantities(cls: type, prefix: str = "") -> Iterator[tuple[str, QuantitySpec, bool]]:
    """Yield (dotted path, specification, required) of each quantity of a record and nested ones."""
    for f in fields(cls):  # type: ignore[arg-type]
        if "quantity" in f.metadata:
            yield prefix + f.name, f.metadata["quantity"], f.default is MISSING
        elif "record" in f.metadata:
            yield from quantities(f.metadata["record"], f"{prefix}{f.name}.")


def nested(cls: type, *, default: Any = MISSING) -> Any:
    """Return a field that contains another record."""
    return field(default=default, metadata={"record": cls})


def get(rec: Any, path: str) -> Any:
    """Return the value at a dotted path, or None if the path ends in an absent record."""
    for name in path.split("."):
        rec = None if rec is None else getattr(rec, name)
    return rec


def build(cls: type[T], values: Mapping[str, Any]) -> T:
    """Return a record from {dotted path: SI value}; nested records without values become None."""
    arguments: dict[str, Any] = {}
    for f in fields(cls):  # type: ignore[arg-type]
        if "record" in f.metadata:
            inner = {k.split(".", 1)[1]: v for k, v in values.items() if k.startswith(f.name + ".")}
            if inner or f.default is MISSING:
                arguments[f.name] = build(f.metadata["record"], inner)
        elif f.name in values:
            arguments[f.name] = values[f.name]
        elif f.default is MISSING and f.default_factory is MISSING:
            spec = f.metadata.get("quantity") or f.metadata["value"]
            raise QuantityError(f"{f.name} is missing: {spec.text}", quantity=f.name)
    return cls(**arguments)


def check(rec: Any, prefix: str = "") -> None:
    """Raise QuantityError for the first field of a record that lies outside its bounds."""
    for f in fields(rec):
        value = getattr(rec, f.name)
        if value is None or is_traced(value):
            continue
        spec = f.metadata.get("quantity") or f.metadata.get("value")
        if spec is not None:
            spec.check(value, prefix + f.name)
        elif is_dataclass(value):
            check(value, f"{prefix}{f.name}.")
