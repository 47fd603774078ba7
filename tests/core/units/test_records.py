"""Records: bounds, whole numbers, nesting, building from dotted paths."""

from __future__ import annotations

import dataclasses
import math

import pint
import pytest

from layerjam.core.errors import QuantityError
from layerjam.core.units import (
    QuantitySpec,
    build,
    check,
    get,
    get_spec,
    nested,
    quantities,
    quantity,
    record,
)


@record
class Inner:
    size: float = quantity("m", "size of it", lo=1e-3, hi=1.0)
    note: float | None = quantity("1", "a note", default=None)


@record
class Outer:
    count: int = quantity("1", "how many", lo=2, hi=9, whole=True)
    rate: float = quantity("m/s", "how fast", open_lo=True, symbol="v", default=1.0)
    inner: Inner = nested(Inner)
    spare: Inner | None = nested(Inner, default=None)


def test_paths_meanings_and_required():
    found = {path: (m.unit, due) for path, m, due in quantities(Outer)}
    assert found["count"] == ("1", True) and found["rate"] == ("m/s", False)
    assert found["inner.size"] == ("m", True) and found["spare.note"] == ("1", False)
    assert get_spec(Outer, "rate").symbol == "v"


def test_build_get_and_absent_records():
    made = build(Outer, {"count": 3, "inner.size": 0.5})
    assert made == Outer(count=3, inner=Inner(size=0.5))
    assert get(made, "inner.size") == 0.5 and get(made, "spare.size") is None
    assert build(Outer, {"count": 3, "inner.size": 0.5, "spare.size": 0.1}).spare.size == 0.1
    with pytest.raises(QuantityError, match="count is missing: how many"):
        build(Outer, {"inner.size": 0.5})
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.count = 4


def test_check_names_the_nested_field():
    record = Outer(count=2, inner=Inner(size=1.0))
    check(record)
    record.inner.__dict__["size"] = 2.0  # as a step of an optimiser may, which builds no record
    with pytest.raises(QuantityError, match=r"inner\.size: 2 m is not allowed.*at most 1"):
        check(record)


def test_a_constructor_takes_what_a_file_may_hold():
    assert Inner(size="250 mm").size == 0.25
    assert Inner(size=pint.UnitRegistry().Quantity(3, "inch")).size == pytest.approx(0.0762)
    with pytest.raises(QuantityError, match=r"^size: 2 m is not allowed.*at most 1"):
        Inner(size=2.0)
    with pytest.raises(QuantityError, match="rate: 0 mm/s is not allowed.*more than zero"):
        Outer(count=2, rate=0.0, inner=Inner(size=0.1))
    with pytest.raises(QuantityError, match="size: '2' has no unit"):
        Inner(size="2")
    with pytest.raises(QuantityError, match=r"size: 2 kilogram cannot be converted to m"):
        Inner(size=pint.UnitRegistry().Quantity(2, "kg"))
    with pytest.raises(QuantityError, match="inner: 0.1 is not Inner"):
        Outer(count=2, inner=0.1)


@pytest.mark.parametrize("bad", [1, 10, 2.5, math.nan, math.inf, -math.inf])
def test_count_bounds_and_whole(bad):
    with pytest.raises(QuantityError, match="count"):
        Outer(count=bad, inner=Inner(size=0.1))


def test_whole_numbers_are_read_as_int():
    value = get_spec(Outer, "count").read(7.0, "count")
    assert value == 7 and isinstance(value, int)


def test_allowed_phrases():
    assert QuantitySpec("m", "x").limits() == "zero or more"
    assert QuantitySpec("m", "x", open_lo=True).limits() == "more than zero"
    assert QuantitySpec("m", "x", lo=1e-3, hi=0.5).limits() == "at least 1 mm and at most 500 mm"
