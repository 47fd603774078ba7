"""A run of the bench in words: the date and the time that it covers."""

from __future__ import annotations

from datetime import date

import numpy as np
import pytest

from layerjam.core.errors import QuantityError
from layerjam.laboratory.measure.run_text import make_run_facts
from layerjam.laboratory.measure.runs import Run


def run_of(time: list[float], **meta: str) -> Run:
    """A run with samples of one start of the board at these times [s]."""
    columns = {
        "time": np.array(time), "boot": np.ones(len(time), int), "seq": np.arange(len(time)),
        "board_us": (1e6 * np.array(time)).astype(int) + 500_000,
    }  # fmt: skip
    return Run(
        path="x.ljrun", meta=meta, columns=columns, boots=(1,), events=(), clock=np.empty((0, 2)),
        gaps=0,
    )  # fmt: skip


def test_the_date_of_a_run_is_the_day_of_its_start() -> None:
    facts = make_run_facts(run_of([0.0], started_utc="2026-11-23T03:00:00.123Z"))
    assert date.fromisoformat(facts.date) == date(2026, 11, 23)
    assert make_run_facts(run_of([0.0])).date == ""


def test_a_range_without_samples_is_answered_with_the_first_and_the_last_time() -> None:
    run = run_of([-0.5, 0.0, 1.0, 4.0])
    for start, end in ((4.5, None), (None, -1.0), (2.0, 3.0)):
        with pytest.raises(QuantityError, match=r"the samples cover -0\.5 s to 4 s$"):
            run.between(start, end)
    assert run.between(0.0, 1.0).columns["time"].tolist() == [0.0, 1.0]
    with pytest.raises(QuantityError, match="the samples cover none"):
        run_of([]).between(0.0, None)
