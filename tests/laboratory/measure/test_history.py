"""Reading a vacuum over time."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.core.errors import FileError, UnknownNameError
from layerjam.laboratory.measure.history import read_history
from layerjam.laboratory.measure.options import ReadingOptions

ATMOSPHERE = 101325.0


def write(tmp_path, text):
    path = tmp_path / "pump.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "text",
    [
        "time [s],vacuum [kPa]\n0,0\n0.5,40\n2,94.5\n",
        "# from the sensor\nUnterdruck (kPa);t (ms)\n0;0\n40;500\n94.5;2000\n",
        "t [s],note,vacuum [mbar]\n0,a,0\n0.5,b,400\n2,c,945\n",
    ],
)
def test_units_say_which_column_is_which(tmp_path, text):
    history = read_history(write(tmp_path, text), ATMOSPHERE)
    np.testing.assert_allclose(history.time, [0, 0.5, 2])
    np.testing.assert_allclose(history.vacuum, [0, 40e3, 94.5e3])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("time [s],vacuum [kPa]\n", "no rows of numbers"),
        ("time [s],vacuum [kPa]\n1.5,20\n", "never increases"),
        ("time,vacuum [kPa]\n0,0\n1,2\n", "'time' has no unit"),
        ("time [s],vacuum\n0,0\n1,2\n", "'vacuum' has no unit"),
        ("time [s],a [kPa],b [Pa]\n0,0,0\n1,2,2\n", "which column is the pressure"),
        ("time [s],vacuum [kPa]\n0,0\n1,x\n", "'x' in column 'vacuum' is not a finite number"),
        ("time [s],vacuum [kPa]\n0,0\n1\n", "1 value instead of 2"),
        ("time [s],vacuum [kPa]\n0,0\n1,nan\n", "'nan' in column 'vacuum' is not a finite number"),
        ("time [s],vacuum [kPa]\n0,0\n1,1\n1,2\n", "time does not increase"),
        ("time [s],vacuum [kPa]\n0,0\n1,120\n", "absolute pressure falls to -18"),
        ("time [s],vacuum [kPa]\n0,-1\n1,20\n", "vacuum -1 kPa at 0 s is not between"),
    ],
)
def test_what_is_refused_and_how(tmp_path, text, words):
    with pytest.raises(FileError, match=words):
        read_history(write(tmp_path, text), ATMOSPHERE)


@pytest.mark.parametrize("name", ["pressure [kPa]", "Druck (kPa)", "P [kPa]"])
def test_a_pressure_is_never_guessed_to_be_a_vacuum(tmp_path, name):
    path = write(tmp_path, f"time [s];{name}\n0;101.3250\n1;6.8250\n")
    with pytest.raises(FileError, match="state it \\(--reading absolute or --reading vacuum\\)"):
        read_history(path, ATMOSPHERE)
    absolute = read_history(path, ATMOSPHERE, ReadingOptions(reading="absolute"))
    np.testing.assert_allclose(absolute.vacuum, [0, 94.5e3])
    with pytest.raises(FileError, match="cannot be read as gauge.*--reading absolute"):
        read_history(path, ATMOSPHERE, ReadingOptions(reading="gauge"))
    with pytest.raises(UnknownNameError, match="absolute"):
        read_history(path, ATMOSPHERE, ReadingOptions(reading="absolut"))


def test_the_column_says_what_it_counts_from(tmp_path):
    path = write(tmp_path, "time [s],absolute pressure [kPa]\n0,101.325\n1,6.825\n")
    np.testing.assert_allclose(read_history(path, ATMOSPHERE).vacuum, [0, 94.5e3])
    path = write(tmp_path, "time [s],gauge pressure [kPa]\n0,0\n1,-94.5\n")
    np.testing.assert_allclose(read_history(path, ATMOSPHERE).vacuum, [0, 94.5e3])


def test_no_file_and_no_text(tmp_path):
    with pytest.raises(FileError, match="does not exist") as said:
        read_history(tmp_path / "none.csv", ATMOSPHERE)
    assert "Errno" not in str(said.value) and str(said.value).count("none.csv") == 1
    path = tmp_path / "bytes.csv"
    path.write_bytes(b"\xff\xfe\x00\x01" * 10)
    with pytest.raises(FileError):
        read_history(path, ATMOSPHERE)
