"""A look at a file: cells cut to fit, columns by number, lines as an editor counts them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.preview import LETTERS, preview_file, read_column
from layerjam.laboratory.measure.readers.column_names import shorten
from layerjam.laboratory.measure.readers.content import Source


def test_a_cell_that_fits_is_whole_and_a_longer_one_ends_in_dots(tmp_path: Path) -> None:
    head = "n" * LETTERS
    path = tmp_path / "long.csv"
    path.write_text(f"{head},{head}m\n1,2\n3,4\n5,6\n", encoding="utf-8")
    fits, cut = preview_file(path).names
    assert fits == head
    assert len(cut) == LETTERS and cut == "n" * (LETTERS - 1) + "…"


def test_a_text_for_a_message_has_at_most_forty_characters() -> None:
    assert shorten("n" * 40) == "n" * 40
    for length in (41, 400):
        assert shorten("n" * length) == "n" * 37 + "..."


def test_the_first_and_the_last_column_are_read_and_none_beside_them(tmp_path: Path) -> None:
    path = tmp_path / "two.csv"
    path.write_text("time [s],force [kN]\n0,1\n1,2\n2,3\n", encoding="utf-8")
    assert read_column(path, 0, "s", "s").tolist() == [0.0, 1.0, 2.0]
    np.testing.assert_allclose(read_column(path, 1, "kN", "N"), [1e3, 2e3, 3e3])
    for index in (-1, 2):
        with pytest.raises(FileError, match=f"has no column {index + 1} with the unit 's'"):
            read_column(path, index, "s", "s")
    with pytest.raises(FileError, match="has no column 2 with the unit 's'"):
        read_column(path, 1, "s", "N")


def test_a_line_end_within_a_cell_counts_as_one() -> None:
    source = Source("file", b"Load\x0b(N),Time\n1,2\n3,4\n", "utf-8")
    assert [source.line_number(offset) for offset, _ in source.lines()] == [1, 3, 4]
