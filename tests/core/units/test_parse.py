"""Text to SI and back: exact, refused with the units that would do, never slow, never a crash."""

from __future__ import annotations

import math
import subprocess
import sys
import time
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.core import conversion
from layerjam.core.conversion import FACTORS, pint_factor, strip_unit, unit_factor
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.core.installation import install_command
from layerjam.core.units import QuantitySpec, exact_text, examples, parse, quantities, show

SI = ["m", "Pa", "N", "N/m", "kg", "kg/m^3", "m/s", "s", "J", "J/(kg K)", "N s/m", "m/s^2", "V"]


@pytest.mark.parametrize(
    ("text", "si", "value"),
    [
        ("0.254 mm", "m", 0.000254),
        ("94.5kPa", "Pa", 94500.0),
        ("94.5 kPa", "Pa", 94500.0),
        (" 131 kN/m ", "N/m", 131000.0),
        ("107 N/mm", "N/m", 107000.0),
        ("0.1 MPa", "Pa", 1e5),
        ("2.5 GPa", "Pa", 2.5e9),
        ("13 in", "m", 0.3302),
        ('13 "', "m", 0.3302),
        ("1e-3 m", "m", 0.001),
        ("+.5 m", "m", 0.5),
        ("-2 mm", "m", -0.002),
        ("20 g", "kg", 0.02),
        ("1090 J/(kg K)", "J/(kg K)", 1090.0),
        ("3 N s/m", "N s/m", 3.0),
        ("13 mm/s", "m/s", 0.013),
        ("2 min", "s", 120.0),
        ("9.80665 m/s^2", "m/s^2", 9.80665),
        ("9.80665 m/s²", "m/s^2", 9.80665),
        ("7 µm", "m", 7e-6),
        ("7 μm", "m", 7e-6),
        ("7 um", "m", 7e-6),
        ("1 atm", "Pa", 101325.0),
        ("32 %", "1", 0.32),
        ("0.875", "1", 0.875),
        (0.875, "1", 0.875),
        (11, "1", 11.0),
    ],
)
def test_exact_values(text, si, value):
    assert parse(text, si, "x") == value


@pytest.mark.parametrize(
    ("text", "si", "value"),
    [("10 psi", "Pa", 68947.57), ("760 mmHg", "Pa", 101325.0), ("1 lbf", "N", 4.4482216)],
)
def test_imperial_units(text, si, value):
    assert parse(text, si, "x") == pytest.approx(value, rel=1e-6)


def test_kilogram_force():
    assert parse("1 kgf", "N", "x") == pytest.approx(9.80665)


@given(st.decimals(-(10**9), 10**9, places=6, allow_nan=False))
def test_milli_is_exactly_a_thousandth(number):
    """No double rounding: the float nearest to the decimal that was written."""
    assert parse(f"{number} mm", "m", "x") == float(number / 1000)


@pytest.mark.parametrize("si", SI)
def test_a_bare_number_is_refused_and_units_are_named(si):
    for bare in (13, 1.5, "13", "1.5", float("nan")):
        with pytest.raises(QuantityError, match="has no unit; write") as caught:
            parse(bare, si, "sheets.width")
        assert str(caught.value).startswith("sheets.width: ")
        assert examples(si).split("'")[1].strip() in str(caught.value)


@pytest.mark.parametrize(
    ("text", "si", "says"),
    [
        ("13 kg", "m", "not in units of length"),
        ("13 mm", "Pa", "not in units of pressure"),
        ("1 kPa", "N", "not in units of force"),
        ("1 N m", "N", "not in units of force"),
        ("1 s", "kg", "not in units of mass"),
        ("1 mm", "s", "not in units of time"),
        ("1 mm", "N/m", "not in units of N/m"),
        ("3 mm", "1", "is not a pure number; give no unit or %"),
        ("3 quux", "m", "not in units of length"),
        ("1 degC", "m", "not in units of length"),
        ("1 mm + 2", "m", "not in units of length"),
        ("1 __import__('os')", "m", "not in units of length"),
        ("0x10 mm", "m", "not in units of length"),
        ("1,5 mm", "m", "decimal comma"),
        ("1_000 mm", "m", "not in units of length"),
        ("1 m^99999999", "m", "not in units of length"),
        ("1 m**9**9**9", "m", "not in units of length"),
        ("1 m^(9^9^9)", "m", "not in units of length"),
        ("mm", "m", "not a number with a unit"),
        ("", "m", "not a number with a unit"),
        ("−1 mm", "m", "not a number with a unit"),
        ("nan mm", "m", "not a number with a unit"),
        ("inf Pa", "Pa", "not a number with a unit"),
        ("1 mm\x00", "m", "not"),
        ("😀 mm", "m", "not a number with a unit"),
        ("1 😀", "m", "not in units of length"),
        ("1e999 m", "m", "not a finite number"),
        ("1e99999 m", "m", "not"),
        ("1" * 41 + " m", "m", "not"),
        (None, "m", "not a quantity"),
        ([1], "1", "not a quantity"),
        ({"value": 1}, "m", "not a quantity"),
        (float("nan"), "1", "not a finite number"),
        (float("inf"), "1", "not a finite number"),
        (10**400, "1", "not a finite number"),
        ("1e400", "1", "not a finite number"),
    ],
)
def test_refused_with_a_reason(text, si, says):
    with pytest.raises(QuantityError, match=says) as caught:
        parse(text, si, "the quantity")
    assert str(caught.value).startswith("the quantity: ") and len(str(caught.value)) < 200


def test_grams_per_cubic_centimetre_are_exact():
    assert parse("1.42 g/cm^3", "kg/m^3", "x") == 1420.0


@pytest.mark.parametrize("si", ["1", "m"])
def test_a_truth_value_is_no_number(si):
    with pytest.raises(QuantityError, match="not a quantity"):
        parse(True, si, "x")


def test_underflow_is_not_zero_in_silence():
    with pytest.raises(QuantityError):
        parse("1e-400 m", "m", "x")


@pytest.mark.parametrize("si", ["1", "m"])
def test_an_integer_too_long_to_print_is_refused(si):
    with pytest.raises(QuantityError):
        parse(1 << 20000, si, "x")


def test_long_white_space_is_not_slow():
    begun = time.process_time()
    with pytest.raises(QuantityError):
        parse("1" + " " * 1_000_000 + "#" * 60, "m", "x")
    assert time.process_time() - begun < 60  # hours if it grows with the square of the length


@given(st.text(max_size=60), st.sampled_from([*SI, "1"]))
def test_any_text_is_a_number_or_a_quantity_error(text, si):
    try:
        assert math.isfinite(parse(text, si, "x"))
    except QuantityError as err:
        assert str(err).startswith("x: ")


units = st.text(alphabet="mkgsNPaJKµ/*^·²³⁻¹ ()0123456789-°%", max_size=20)


@given(number=st.sampled_from(["1", "2.5", "-3e5"]), unit=units, si=st.sampled_from(SI))
def test_any_unit_text_is_known_or_refused(number, unit, si):
    try:
        value = parse(number + " " + unit, si, "x")
    except QuantityError:
        return
    assert math.isfinite(value) and value != 0


finite = st.floats(allow_nan=False, allow_infinity=False, min_value=1e-280, max_value=1e280)


@given(value=finite, si=st.sampled_from([*SI, "1"]), negative=st.booleans())
def test_exact_text_comes_back_bit_for_bit(value, si, negative):
    value = -value if negative else value
    assert parse(exact_text(value, si), si, "x") == value


def test_exact_text_of_thousands_of_everyday_values():
    rng = np.random.default_rng(1)
    for value in np.exp(rng.uniform(-18, 25, 400)):
        for si in ("m", "Pa", "N/m", "kg"):
            assert parse(exact_text(float(value), si), si, "x") == value
    assert exact_text(0.013, "m") == "13 mm"
    assert exact_text(0.0, "m") == "0 mm"
    assert exact_text(94500.0, "Pa") == "94.5 kPa"


@pytest.mark.parametrize(
    ("value", "si", "text"),
    [
        (0.013, "m", "13 mm"),
        (0.000254, "m", "0.254 mm"),
        (94500.0, "Pa", "94.5 kPa"),
        (2.5e9, "Pa", "2.5 GPa"),
        (131e3, "N/m", "131 kN/m"),
        (0.0004, "kg", "0.4 g"),
        (0.0, "m", "0 mm"),
        (-0.013, "m", "-13 mm"),
        (0.875, "1", "0.875"),
        (None, "m", "not known"),
        (math.inf, "m", "inf"),
        (5e-9, "m", "5 nm"),
        (1.676e-9, "m", "1.676 nm"),
        (71.95e6, "N/m", "71.95 MN/m"),
        (999e3, "N/m", "999 kN/m"),
        (2.5e9, "N/m", "2.5 GN/m"),
        (2e-5, "s", "20 µs"),
        (6.25e-4, "m^2", "6.25 cm^2"),
        (123456.0, "m", "123456 m"),
        (7.0, "V", "7 V"),
    ],
)
def test_show(value, si, text):
    assert show(value, si) == text


def test_factors():
    from fractions import Fraction

    assert unit_factor("mm", "m") == Fraction(1, 1000)
    assert unit_factor("m", "m") == 1
    assert unit_factor("%", "1") == Fraction(1, 100)
    for unit in ("", "kg", "m^22", "m**2", "degC", "x" * 50, "1/0"):
        assert unit_factor(unit, "m") is None


def test_every_field_of_the_brake_round_trips_its_bounds():
    from layerjam.brake.device.brake import Brake

    for path, spec, _ in quantities(Brake):
        for bound in (spec.lo, spec.hi):
            if not math.isfinite(bound):
                continue
            text = spec.to_toml(bound)
            if spec.open_lo and bound == spec.lo:
                with pytest.raises(LayerjamError, match="more than"):
                    spec.read(text, path)
            else:
                assert spec.read(text, path) == bound
        with pytest.raises(QuantityError, match="is not allowed"):
            spec.check(spec.lo - abs(spec.lo) * 0.01 - 1e-9, path)


@pytest.mark.parametrize("si", FACTORS)
def test_the_table_of_factors_is_what_pint_says(si):
    assert FACTORS[si]
    for unit in FACTORS[si]:
        assert unit_factor(unit, si) == pint_factor(unit, si), unit


OTHERS = (
    "N/mm^2", "N/mm²", "kgf/cm^2", "N·m", "lbf*in", "in/min", "ft/s", "km/h", "cm^3/min", "in^3",
    "g/cm^3", "kg/m³", "s^-1", "m·s⁻²", "N mm", "kg cm^2", "mL/(min kPa)", "kPa/s", "Pa*s", "kN m",
    "°", "deg/s", "N/(m/s)", "m/s/s", "mm Hg", '"', "mm3", "mil", "hbar", "barA", "°C", "K/min",
    "C", "F", "G", "H", "T", "M", "k", "u", "a", "foo", "cd", "dm", "ccm", "kmin", "mlb", "m s-1",
)  # fmt: skip
"""Units beyond the table, and text that is not a unit of ours or of anyone."""
SIZES = (*FACTORS, "Hz", "1/s", "N s/m", "rad", "m/s^2", "W", "N m", "N m/rad", "Pa s", "K")


@pytest.mark.parametrize("si", SIZES)
def test_our_units_are_those_of_pint(si):
    for unit in (*conversion._known_units(), *OTHERS):
        own, theirs = unit_factor(unit, si), pint_factor(unit, si)
        assert own == (Fraction(1) if unit == si else theirs), unit


def test_what_is_not_in_the_table_is_asked_of_pint():
    assert unit_factor("furlong", "m") == pint_factor("furlong", "m") is not None
    assert unit_factor("kPa", "m") is None


@pytest.fixture
def no_pint(monkeypatch):
    """A machine without the extra."""
    monkeypatch.setattr(conversion, "_has_pint", lambda: False)
    unit_factor.cache_clear()
    yield
    unit_factor.cache_clear()


def test_without_pint_a_rare_unit_names_the_command(no_pint):
    assert parse("3 in", "m", "length") == 0.0762
    with pytest.raises(QuantityError) as caught:
        parse("3 furlong", "m", "length")
    assert str(caught.value) == (
        "length: the unit 'furlong' is not known without an optional package: "
        f"{install_command('units')}, or give a unit such as 'mm' or 'cm'"
    )
    for text in ("3 kPa", "3 °C", "3 N mm"):
        with pytest.raises(QuantityError, match="is not in units of length"):
            parse(text, "m", "length")
    with pytest.raises(QuantityError, match=r'\[units\]"$'):
        strip_unit(pd.Series([1.0], name="x").pipe(_with_unit, "furlong"), "m", "length")


def _with_unit(series, unit):
    series.attrs["units"] = unit
    return series


def test_a_catalogue_brake_is_read_without_loading_pint():
    code = (
        "import sys; from layerjam.brake.device.load import load; load('choi2018-kapton'); "
        "from layerjam.brake.fluid.line_file import load_line; load_line('choi2018'); "
        "sys.exit('pint' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("number", [95, "95", 99.5])
def test_a_percentage_without_its_sign_is_explained_in_words_that_work(number):
    spec = QuantitySpec("1", "share of tests", lo=0.5, hi=0.999, example="95%")
    with pytest.raises(QuantityError, match="write ") as caught:
        spec.read(number, "confidence")
    for word in str(caught.value).rpartition("write ")[2].split(" or "):
        assert spec.read(word, "confidence") == pytest.approx(float(number) / 100)
    with pytest.raises(QuantityError) as caught:
        spec.read(100, "confidence")
    assert "write" not in str(caught.value)
