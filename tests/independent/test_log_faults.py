"""Faulty logs: the shares that docs/coverage.md states, on a few campaigns each."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

from counts import cases
from log_faults import OUTCOMES, PAGE, ROWS, Row, is_right, measure


@pytest.mark.slow
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name.replace(" ", "-"))
def test_a_file_ends_as_required(row: Row, tmp_path: Path) -> None:
    found = measure(row, cases(40, 5), 7, tmp_path)
    assert is_right(row, found), found


def test_the_page_has_every_row_with_the_share_that_is_required() -> None:
    text = PAGE.read_text("utf-8")
    for row in ROWS:
        [cells] = re.findall(rf"^\| {re.escape(row.name)} \| (.*) \|$", text, re.MULTILINE)
        count, *shares = cells.split(" | ")
        assert int(count) >= (300 if row.healthy else 100)
        parts = [0.0 if share == "–" else float(share.rstrip("%")) / 100 for share in shares]
        numbers = [round(int(count) * part) for part in parts]
        assert is_right(row, Counter(dict(zip(OUTCOMES, numbers, strict=True)))), cells
