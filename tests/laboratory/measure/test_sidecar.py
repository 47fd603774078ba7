"""The facts beside a data file: read, refused with the line, written and read back."""

from __future__ import annotations

from pathlib import Path

import pytest

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.certificate import Certificate
from layerjam.laboratory.measure.options import load_reading_options
from layerjam.laboratory.measure.sidecar import Facts, read_facts, sidecar_path, write_facts


def facts_of(tmp_path: Path, text: str) -> Facts:
    (tmp_path / "pull.csv.toml").write_text(text)
    return read_facts(tmp_path / "pull.csv")


def test_read(tmp_path: Path) -> None:
    assert read_facts(tmp_path / "pull.csv") == Facts()
    facts = facts_of(tmp_path, 'vacuum = "94.5 kPa"\nspeed = "13mm/s"\nrepeat = 3\n')
    assert facts == Facts(vacuum=94500.0, speed=0.013, repeat=3)


@pytest.mark.parametrize(
    ("text", "line", "sentence"),
    [
        ('vacuum = "94.5 kPa"\nspeeed = "1 mm/s"', 2, "unknown key 'speeed'"),
        ("\nvacuum = 94500", 2, "has no unit"),
        ('vacuum = "94.5 mm"', 1, "pressure"),
        ('vacuum = "94.5 MPa"', 1, "at most 120 kPa"),
        ('vacuum = "-3 kPa"', 1, "not allowed"),
        ('speed = "0 mm/s"', 1, "at least 0.0001 mm/s"),
        ("repeat = 1.5", 1, "an integer"),
        ("repeat = true", 1, "an integer"),
        ("synthetic = 1", 1, "true or false"),
        ("brake = 7", 1, "text in quotes"),
        ("vacuum = ", 1, "is not valid TOML"),
        ("[vacuum]\nx = 1", 1, "has the unknown key x"),
        ('load_cell_certificate = "K1"', 1, "must be a table with number, date, laboratory"),
        ('[gauge_certificate]\nnumber = "P"', 1, "lacks date, laboratory"),
        ('[gauge_certificate]\nnumbr = "P"', 1, "has unknown keys: numbr"),
        (
            '[gauge_certificate]\nnumber = "P"\nlaboratory = "L"\ndate = "1 March"',
            4,
            "'1 March' is not a date such as 2026-03-01",
        ),
        (
            '[gauge_certificate]\nnumber = "P"\nlaboratory = "L"\ndate = 2026-03-01\n'
            'due = "2025-03-01"',
            5,
            "2025-03-01 is before the calibration date, 2026-03-01",
        ),
    ],
)
def test_refused_with_the_line(text: str, line: int, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(FileError) as err:
        facts_of(tmp_path, text)
    assert err.value.line == line and sentence in str(err.value)
    assert "pull.csv.toml" in str(err.value)


def test_written_and_read_back(tmp_path: Path) -> None:
    facts = Facts(
        vacuum=94512.3,
        speed=1 / 3,
        repeat=2,
        brake="choi2018-kapton",
        normal_force=2.45,
        procedure="pull at 13 mm/s",
        synthetic=True,
        seed=7,
        note='a "note"\nin lines',
    )
    path = write_facts(tmp_path / "pull.csv", facts)
    assert (
        path == sidecar_path(tmp_path / "pull.csv") and read_facts(tmp_path / "pull.csv") == facts
    )
    with pytest.raises(FileError, match="already exists"):
        write_facts(tmp_path / "pull.csv", facts)
    write_facts(tmp_path / "pull.csv", Facts(), overwrite=True)
    assert read_facts(tmp_path / "pull.csv") == Facts()


CERTIFICATE = """
number = "K-17"
date = 2026-03-01
due = "2027-03-01"
laboratory = "DKD 123"
"""


def test_a_certificate_is_a_record(tmp_path: Path) -> None:
    """Days with and without quotes; a file's own certificate replaces the folder's as a whole."""
    known = Certificate(number="K-17", date="2026-03-01", due="2027-03-01", laboratory="DKD 123")
    (tmp_path / "conditions.toml").write_text(
        f'customer = "Ankle Works"\n[load_cell_certificate]{CERTIFICATE}', encoding="utf-8"
    )
    facts = read_facts(tmp_path / "pull.csv")
    assert facts == Facts(customer="Ankle Works", load_cell_certificate=known)
    write_facts(tmp_path / "pull.csv", facts)
    assert read_facts(tmp_path / "pull.csv") == facts
    own = 'number = "K-18"\ndate = "2026-04-01"\nlaboratory = "other"\n'
    facts = facts_of(tmp_path, f"[load_cell_certificate]\n{own}")
    assert facts.load_cell_certificate == Certificate(
        number="K-18", date="2026-04-01", laboratory="other"
    )


def test_what_holds_for_a_folder_stands_once(tmp_path: Path) -> None:
    (tmp_path / "conditions.toml").write_text(
        'vacuum = "90 kPa"\noperator = "A. Nurse"\nload_cell_limit = "0.5 %"\n'
        '[read]\nnegative = ["force"]\n',
        encoding="utf-8",
    )
    facts = facts_of(tmp_path, 'vacuum = "60 kPa"\ngauge_limit = "0.5 kPa"\n')
    assert facts == Facts(
        vacuum=60e3, operator="A. Nurse", load_cell_limit=0.005, gauge_limit=500.0
    )
    assert load_reading_options(tmp_path / "pull.csv").negative == ("force",)
    (tmp_path / "conditions.toml").write_text("operater = 'me'\n", encoding="utf-8")
    with pytest.raises(FileError, match="operator") as err:
        read_facts(tmp_path / "pull.csv")
    assert err.value.line == 1 and err.value.path == str(tmp_path / "conditions.toml")
