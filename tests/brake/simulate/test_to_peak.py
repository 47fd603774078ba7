"""The vacuum or the number of sheets for a peak, against every vacuum and every number tried."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import peak
from layerjam.brake.simulate.to_peak import find_sheet_count_for_peak, find_vacuum_for_peak
from layerjam.core.errors import QuantityError

BRAKES = ("choi2018-kapton", "choi2018-ptfe")


def peaks(name, vacuum, count=None):
    brake = load(name).brake
    if count is not None:
        brake = replace(brake, sheets=replace(brake.sheets, count=count))
    return peak(vacuum, 0.04, brake).force


@pytest.mark.parametrize("name", BRAKES)
def test_the_vacuum_is_the_one_that_trying_all_finds(name):
    full = load(name).brake.site.atmosphere
    grid = np.linspace(0, full, 20_001)
    tried = np.asarray(peaks(name, grid))
    for share in (0.03, 0.2, 0.7, 0.999):
        force = float(share * tried[-1])
        found = find_vacuum_for_peak(lambda p: float(peaks(name, p)), force, full)
        best = grid[np.abs(tried - force).argmin()]
        assert found.value == pytest.approx(best, abs=grid[1])
        assert found.force == pytest.approx(force, rel=1e-6)
        assert found.at == found.value


def test_a_force_that_no_vacuum_gives_says_what_the_greatest_is():
    found = find_vacuum_for_peak(lambda p: 1.0 + 2e-3 * p, 400.0, 1e5)
    assert (found.value, found.force, found.at) == (None, 201.0, 1e5)
    below = find_vacuum_for_peak(lambda p: 1.0 + 2e-3 * p, 0.5, 1e5)
    assert (below.value, below.force, below.at) == (None, 1.0, 0.0)
    assert find_vacuum_for_peak(lambda p: 1.0 + 2e-3 * p, 201.0, 1e5).value == 1e5
    assert find_vacuum_for_peak(lambda p: 1.0 + 2e-3 * p, 1.0, 1e5).value == 0.0


def test_the_number_of_sheets_is_the_nearest_of_all():
    counts = np.arange(2, 61)
    tried = np.array([float(peaks(BRAKES[0], 80e3, float(n))) for n in counts])
    known = dict(zip(counts.tolist(), tried.tolist(), strict=True))
    for force in (tried[0], 0.9 * tried[1], 77.0, 300.0, tried[-1]):
        found = find_sheet_count_for_peak(known.__getitem__, float(force), 60)
        assert found.value == counts[np.abs(tried - force).argmin()]
        assert found.force == known[int(found.value)]
    above = find_sheet_count_for_peak(known.__getitem__, float(tried[-1]) + 1, 60)
    assert (above.value, above.force, above.at) == (None, tried[-1], 60)
    assert find_sheet_count_for_peak(known.__getitem__, float(tried[0]) / 9, 60).value is None


@pytest.mark.parametrize("force", [-1.0, float("nan"), float("inf")])
def test_what_is_no_force_is_refused(force):
    for ask in (find_vacuum_for_peak, find_sheet_count_for_peak):
        with pytest.raises(QuantityError, match="force"):
            ask(float, force, 60)
