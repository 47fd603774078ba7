"""The budget against a Monte Carlo of the same errors, and against its closed limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from layerjam.device.load import load
from layerjam.identify.calibration.budget import Peak, budget
from layerjam.mechanics.pull import peak, scale_factor_of_peak
from layerjam.records.source import Source

BRAKE = load("choi2018-kapton").brake


def peaks(*vacuums: float) -> list[Peak]:
    return [Peak(float(peak(p, 0.04, BRAKE).force), p) for p in vacuums]


def test_without_an_enclosure_every_sensitivity_is_one() -> None:
    """a = F/(mu (n-1) W P L2): plus one in the force, minus one in all else."""
    bare = replace(BRAKE, enclosure=replace(BRAKE.enclosure, modulus=1e-9))
    found = budget([Peak(170.0, 94.5e3)], bare, 0.01, {}, {})
    assert [c.sensitivity for c in found.contributions] == pytest.approx(
        [1.0, 1.0, -1.0, -1.0, -1.0], abs=2e-4
    )


def test_the_combined_uncertainty_is_that_of_a_monte_carlo() -> None:
    """Errors that all pulls share, drawn as the budget takes them: rectangular and normal."""
    random, count = np.random.default_rng(12), 40_000
    here = peaks(94.5e3, 60e3, 60e3, 20e3)
    cell, gauge, width, overlap = 0.01, 400.0, 0.01, 0.006
    limits = {"load_cell": cell, "gauge": gauge}
    sds = {"sheets.width": width, "sheets.overlap": overlap}
    sources = {path: Source(kind="measured", sd=sd) for path, sd in sds.items()}
    found = budget(here, BRAKE, 0.004, limits, sources)
    read = 1 + random.uniform(-cell, cell, count)
    off = random.uniform(-gauge, gauge, count)
    wide, long = (1 + sd * random.standard_normal(count) for sd in (width, overlap))
    sheets = replace(
        BRAKE.sheets, width=BRAKE.sheets.width * wide, overlap=BRAKE.sheets.overlap * long
    )
    other = replace(BRAKE, sheets=sheets)
    factors = [scale_factor_of_peak(p.force * read, p.vacuum + off, other) for p in here]
    drawn = np.mean(np.asarray(factors), axis=0)
    drawn = drawn * (1 + 0.004 * random.standard_normal(count))
    assert found.whole
    assert found.combined == pytest.approx(drawn.std() / drawn.mean(), rel=0.02)
    assert found.expanded == 2 * found.combined


def test_what_nobody_stated_is_said_and_adds_nothing() -> None:
    found = budget(peaks(94.5e3), BRAKE, None, {"load_cell": 0.01}, {})
    stated = {c.what: c.standard is not None for c in found.contributions}
    assert stated == {
        "repeats": False,
        "load cell": True,
        "vacuum gauge": False,
        "width of the sheets": False,
        "overlap at rest": False,
    }
    assert not found.whole
    force = found.contributions[1]
    assert found.combined == pytest.approx(force.sensitivity * 0.01 / 3**0.5, rel=1e-12)
    assert [c.basis for c in found.contributions if c.standard is None][1:] == ["not stated"] * 3
