"""What filter and rope would take to make the paper's accelerations."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.brake.simulate.accelerometer import seen, specific_force
from layerjam.studies.choi2018 import impact as paper
from layerjam.studies.choi2018.claims import Verdict


@pytest.mark.slow
def test_no_filter_and_no_rope_makes_the_papers_peaks() -> None:
    claims = paper.claims()
    assert [c.verdict for c in claims] == [Verdict.DIFFERS] * 3
    assert claims[0].ours == pytest.approx(17.78, abs=5e-3)
    assert claims[1].ours == pytest.approx(11.29, abs=5e-3)
    assert "10.6 Hz" in claims[0].why and "2.1 Hz" in claims[1].why
    assert "9.4 g" in claims[1].why and "319 mm" in claims[1].why
    assert all(not c.why.endswith(".") for c in claims)


def test_cutoffs_are_where_they_are_said_to_be() -> None:
    both = zip(paper.simulate_stops(), (10.0, 2.0), paper.find_cutoffs(), strict=True)
    for record, peak, cutoff in both:
        force = specific_force(record)
        assert paper.filtered_peak(force, cutoff) == pytest.approx(peak, rel=1e-6)
        over = [paper.filtered_peak(force, f) for f in np.geomspace(0.5, 60, 12)]
        assert np.all(np.diff(over) > 0)
        # a class of the standard through the public way
        assert paper.filtered_peak(force, 100) == pytest.approx(
            seen(record, cfc=60).peak / paper.G, rel=1e-4
        )


def test_a_stiff_rope_shows_the_filters_answer_to_an_impulse() -> None:
    for cutoff in (5.0, 25.0):
        most = paper.max_bare_reading(cutoff)
        stiff = paper.filtered_peak(paper.simulate_rope(1e6), cutoff)
        assert stiff == pytest.approx(most, rel=0.01)
        assert paper.filtered_peak(paper.simulate_rope(5e3), cutoff) <= most
    time, force = paper.simulate_rope(16.8e3)
    area = np.trapezoid(force, time)
    assert area == pytest.approx(2 * 3.7 + paper.G * (time[-1] - time[0]), rel=1e-5)
    assert force.max() / paper.G == pytest.approx(50, abs=0.5)


def test_ropes() -> None:
    study = paper.study_ropes()
    slips = np.isfinite(study.tuned)
    assert (study.tuned[slips] <= study.bare[slips] * 1.001).all()
    assert (study.bare > 2).all() and np.nanmin(study.tuned) > 9
    assert study.full[-1] == pytest.approx(17.94, abs=5e-3)
    # any stop within a way: 1 + v^2/2gz
    spring = 1 / (1 / 131e3 + 1 / study.rope[slips])
    way = 0.040 + study.tuned[slips] * paper.G / spring
    assert (study.tuned[slips] > 1 + 2.5**2 / (2 * paper.G * way)).all()
