"""What `pull` says of a file that holds several specimens."""

from __future__ import annotations

from pathlib import Path

import pytest

import layerjam as lj
from laboratory.measure.layouts import rows
from layerjam.core.errors import FileError

HEAD = "Time (s),Extension (mm),Load (N)"


def test_each_specimen_is_called_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    body = rows(200)
    other = [
        f"{head},{0.9 * float(load):.4f}" for head, _, load in (r.rpartition(",") for r in body)
    ]
    text = ["Specimen A 1", HEAD, *body, "", "Specimen A 2", HEAD, *other, ""]
    path.write_text("\n".join(text))
    found = lj.pull(path)
    names = [row["specimen"] for row in found.pulls]
    assert len(set(names)) == 2 and None not in names
    printed = list(found.lines())
    for name in names:
        assert f"x.csv, specimen {name}" in printed


def test_refused_specimens_are_counted_as_such(tmp_path: Path) -> None:
    bad = [f"{i},{i},5.0" for i in range(50)]
    path, none = tmp_path / "x.csv", tmp_path / "none.csv"
    path.write_text("\n".join([HEAD, *bad, "", HEAD, *bad, "", HEAD, *bad, ""]))
    with pytest.raises(FileError, match=r"\(2 more specimens were also rejected\)"):
        lj.pull(path)
    with pytest.raises(FileError, match=r"\(1 more file and 2 more specimens were also rejected\)"):
        lj.pull([path, none])
    with pytest.raises(FileError, match=r"\(1 more file was also rejected\)"):
        lj.pull([none, tmp_path / "other.csv"])
    with pytest.raises(FileError, match="is an empty name"):
        lj.pull("")


def test_a_record_without_a_peak_says_so(tmp_path: Path) -> None:
    """It rises to its end; a peak "not known at not known" was printed."""
    path = tmp_path / "x.csv"
    steps = [f"{i / 100:.2f},{i / 200:.3f},{0.2 * i + 0.3 * (i % 2):.2f}" for i in range(400)]
    path.write_text("\n".join([HEAD, *steps, ""]))
    found = lj.pull(path)
    assert found.pulls[0]["peak_force"] is None
    printed = "\n".join(found.lines())
    assert ", no peak" in printed and "not known at" not in printed
