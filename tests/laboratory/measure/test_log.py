"""Time logs: units outrank names, nothing is guessed, a mapping says what a file does not."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from laboratory.measure.layouts import REAL
from layerjam.core.errors import FileError, LayerjamError, QuantityError
from layerjam.laboratory.measure.log import (
    ACCELERATION,
    PRESSURE,
    TEMPERATURE,
    TIME,
    find_reference,
    read_log,
)
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.header import Column
from layerjam.laboratory.measure.readers.unit_words import convert_unit

WANTS = (TIME, PRESSURE)


def write(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "log.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(
    "text",
    [
        "time [s],pressure [kPa]\n0,101\n0.5,50.25\n1,25\n",
        "Druck (bar);Zeit (ms)\n1,01;0\n0,5025;500\n0,25;1000\n",
        "# logger 7\n# volume: 12 mL\ntime_s\tp_mbar\n0\t1010\n0.5\t502.5\n1\t250\n",
        "t / s;T / °C;p / Pa\n0;20;101000\n0.5;20;50250\n1;20;25000\n",
        '"Time","Chamber"\n"(s)","(kPa)"\n"0","101"\n"0.5","50.25"\n"1","25"\n',
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_names_and_units_in_many_forms(tmp_path, text, encoding):
    log = read_log(write(tmp_path, text, encoding), WANTS)
    np.testing.assert_allclose(log["time"], [0, 0.5, 1])
    np.testing.assert_allclose(log["pressure"], [101e3, 50.25e3, 25e3])
    assert len(log.understood) == 2


def test_the_unit_outranks_the_name_and_the_name_decides_among_equals(tmp_path):
    odd = read_log(write(tmp_path, "pressure (s),time (kPa)\n0,100\n1,90\n2,80\n"), WANTS)
    np.testing.assert_allclose(odd["pressure"], [100e3, 90e3, 80e3])
    two = "time (s),line (kPa),chamber pressure (kPa)\n0,1,100\n1,2,90\n2,3,80\n"
    np.testing.assert_allclose(read_log(write(tmp_path, two), WANTS)["pressure"][0], 100e3)


def test_columns_by_place_and_by_name(tmp_path):
    path = write(tmp_path, "0;3.6;7.3\n100;3.6;7.2\n200;3.6;7.1\n")
    log = read_log(path, WANTS, ReadingOptions(columns="time:ms,skip,pressure:bar"))
    np.testing.assert_allclose(log["time"], [0, 0.1, 0.2])
    np.testing.assert_allclose(log["pressure"], [730e3, 720e3, 710e3])
    two = write(tmp_path, "time (s),pressure A,pressure B\n0,1,100\n1,2,90\n2,3,80\n")
    log = read_log(two, WANTS, ReadingOptions(columns="pressure:psi=pressure B"))
    assert log["pressure"][0] == pytest.approx(689475.7)


def test_a_mapping_outranks_a_header(tmp_path):
    path = write(tmp_path, "time (s),pressure (kPa)\n0,1\n1,2\n2,3\n")
    log = read_log(path, WANTS, ReadingOptions(columns="time:min,pressure:MPa"))
    assert (log["time"][-1], log["pressure"][-1]) == (120.0, 3e6)


@pytest.mark.parametrize(
    ("cells", "factor"), [(("0.000", "903.000", "1.002.000"), 1), (("0.5", "1.5", "1.002.5"), 1)]
)
def test_a_point_that_groups_and_divides(tmp_path, cells, factor):
    path = write(tmp_path, "".join(f"{c};{k}\n" for k, c in enumerate(cells)))
    log = read_log(path, WANTS, ReadingOptions(columns="time:ms,pressure:bar"))
    due = [float(c.replace(".", "", c.count(".") - 1)) / 1e3 for c in cells]
    np.testing.assert_allclose(log["time"], due)
    assert any("the last point is the decimal sign" in s for s in log.understood)


def test_points_that_could_be_either_are_asked_for(tmp_path):
    path = write(tmp_path, "1.001.000;1\n1.002.000;2\n1.003.000;3\n")
    with pytest.raises(FileError, match="--decimal"):
        read_log(path, WANTS, ReadingOptions(columns="time:ms,pressure:bar"))
    log = read_log(path, WANTS, ReadingOptions(columns="time:ms,pressure:bar", decimal="."))
    np.testing.assert_allclose(log["time"], [1.001, 1.002, 1.003])
    log = read_log(path, WANTS, ReadingOptions(columns="time:ms,pressure:bar", decimal=","))
    np.testing.assert_allclose(log["time"], [1001.0, 1002.0, 1003.0])


@pytest.mark.parametrize(
    ("text", "columns", "words"),
    [
        ("0;1\n1;2\n2;3\n", None, "--columns time:s,pressure:kPa"),
        ("time,pressure\n0,1\n1,2\n2,3\n", None, "'time' has no unit; time needs a unit"),
        ("time (s),pressure\n0,1\n1,2\n2,3\n", None, "'pressure' has no unit; pressure needs"),
        ("t (s),pressure A (kPa),pressure B (kPa)\n0,1,2\n1,2,3\n2,3,4\n", None, "which column"),
        ("time (s),pressure (kPa)\n1,1\n0,2\n2,3\n", None, "backwards"),
        ("time (s),pressure (kPa)\n1,1\n1,2\n1,3\n", None, "never increases"),
        ("time (s),pressure (kPa)\n1,1\n2,x\n3,3\n", None, "'x'"),
        ("time (s),pressure (kPa)\n1,1\n2,nan\n3,3\n", None, "not a finite number"),
        ("0;1;2\n1;2;3\n2;3;4\n", "time:s,pressure:bar", "has 3 columns, but --columns lists 2"),
        ("0;1\n1;2\n2;3\n", "time:s,skip", "no column of pressure"),
        ("words only here\n", "time:s,pressure:bar", "no row of numbers"),
    ],
)
def test_what_is_refused_and_how(tmp_path, text, columns, words):
    with pytest.raises(FileError, match=words):
        read_log(write(tmp_path, text), WANTS, ReadingOptions(columns=columns))


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ("time:s,force:N", "not of the form"),
        ("time:s,pressure", "pressure has no unit"),
        ("time:s,pressure:mm", "'mm' is not a unit of pressure"),
        ("time:s,time:s", "given twice"),
        ("skip,skip", "does not name a column"),
        ("pressure:kPa=", "not of the form"),
        ("", "not of the form"),
    ],
)
def test_a_mapping_that_is_none(tmp_path, columns, words):
    with pytest.raises(QuantityError, match=words):
        read_log(write(tmp_path, "0;1\n1;2\n2;3\n"), WANTS, ReadingOptions(columns=columns))


@pytest.mark.parametrize(
    ("unit", "si", "value"),
    [
        ("bara", "Pa", 1e5), ("bar(g)", "Pa", 1e5), ("kPa abs", "Pa", 1e3),
        ("psig", "Pa", 6894.757),
        ("mmHg", "Pa", 133.3224), ("g", "m/s^2", 9.80665), ("m/s²", "m/s^2", 1.0),
        ("N/mm2", "Pa", 1e6), ("%", "1", 0.01), ("Sek", "s", 1.0),
    ],
)  # fmt: skip
def test_units_beyond_the_table(unit, si, value):
    assert float(convert_unit(unit, si)[0]) == pytest.approx(value, rel=1e-6)


def test_temperatures_have_another_zero(tmp_path):
    assert convert_unit("°C", "K") == (1.0, 273.15)
    assert convert_unit("°F", "K")[0] * 212 + convert_unit("°F", "K")[1] == pytest.approx(373.15)
    path = write(tmp_path, "t (s),T (°C),p (kPa)\n0,20,1\n1,21,2\n2,22,3\n")
    log = read_log(path, (*WANTS, TEMPERATURE))
    np.testing.assert_allclose(log["temperature"], [293.15, 294.15, 295.15])


@pytest.mark.parametrize(
    ("name", "unit", "kind"),
    [
        ("p", "bara", "absolute"), ("p", "psig", "gauge"), ("Absolutdruck", "kPa", "absolute"),
        ("gauge pressure", "kPa", "gauge"), ("vacuum", "kPa", "vacuum"), ("Unterdruck", "mbar",
        "vacuum"), ("p", "bar", None), ("pressure", "Pa", None),
    ],
)  # fmt: skip
def test_what_a_pressure_counts_from_is_read_or_unknown(name, unit, kind):
    assert find_reference(Column("pressure", 0, name, unit, Fraction(1))) == kind


@pytest.mark.parametrize(
    ("cell", "kind"),
    [("Pressure_kPa_abs", "absolute"), ("Druck_kPa abs", "absolute"), ("p, kPa gauge", "gauge"),
     ("Pressure / kPa rel", "gauge"), ("p_kPa", None), ("chamber_abs_kPa", "absolute")],
)  # fmt: skip
def test_the_reference_may_follow_the_unit_in_one_cell(tmp_path, cell, kind):
    path = write(tmp_path, f'"t_s";"{cell}"\n0;90\n1;80\n2;70\n')
    log = read_log(path, (TIME, PRESSURE))
    np.testing.assert_allclose(log["pressure"], [90e3, 80e3, 70e3])
    assert find_reference(log.taken["pressure"]) == kind


def test_the_name_given_by_the_user_says_nothing_of_the_kind():
    assert find_reference(Column("pressure", 0, "vacuum", "bar", Fraction(1), given=True)) is None


@settings(max_examples=40, deadline=None)
@given(data=st.binary(max_size=300))
def test_any_bytes_end_in_one_sentence(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("bytes") / "x.csv"
    path.write_bytes(b"time (s),acceleration (g)\n" + data)
    try:
        log = read_log(path, (TIME, ACCELERATION))
    except LayerjamError as error:
        assert "\n" not in str(error)
    else:
        assert all(np.isfinite(c).all() for c in log.columns.values())


@pytest.mark.skipif(not (REAL / "pneumatic_friction_leak").is_dir(), reason="no real files here")
@pytest.mark.parametrize(
    ("name", "rows", "last"),
    [("Aluminium", 1508, 151.303), ("Prusa", 1435, 143.696), ("Ultimaker_020", 1442, 144.465)],
)
def test_real_holds_with_the_mapping_of_their_readme(name, rows, last):
    path = REAL / "pneumatic_friction_leak" / f"airchamber_{name}.csv"
    log = read_log(path, WANTS, ReadingOptions(columns="time:ms,skip,pressure:bar"))
    assert abs(len(log["time"]) - rows) <= 1
    assert log["time"][-1] == pytest.approx(last)
    assert np.diff(log["time"]).max() < 0.3
    assert np.all((log["pressure"] >= 0) & (log["pressure"] < 8e5))
