"""Figures of merit in other units, each with its own; and many equal brakes, which share a load."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from dimensions import OTHER, Units
from layerjam.brake.device.load import load
from layerjam.core.evolve import evolve
from layerjam.workshop.design.force_density import added_sheet_effect, make_sheet_line
from layerjam.workshop.design.merit import MERITS, StickSlipPull, make_point, merits

PULLER = StickSlipPull(speed=0.013, mass=0.8, damping_ratio=0.1)
NAMES = ("choi2018-kapton", "choi2018-polyester")


def compute(name: str, units: Units, **changes: Any) -> dict[str, Any]:
    """The figures of merit of a design that is not the base itself."""
    brake = load(name).brake
    brake = evolve(brake, mount=evolve(brake.mount, screws=1))  # else the width sets their number
    base, m = units.scale(brake), units.length
    point = make_point(base, 6e4 * units.factor("Pa"))._replace(
        count=14, series=2.0, parallel=3.0, offset=0.004 * m, width=0.03 * m,
        fittings_length=0.02 * m, link_gap=0.005 * m,
    )  # fmt: skip
    return merits(point._replace(**changes), base, units.scale(PULLER))


@pytest.mark.parametrize("name", NAMES)
def test_figures_of_merit_do_not_depend_on_units(name: str) -> None:
    one = compute(name, Units())
    assert sum(np.isfinite(float(value)) for value in one.values()) >= 15
    for units in OTHER:
        other = compute(name, units)
        for merit, value in one.items():
            expected = float(value) * units.factor(MERITS[merit].unit)
            assert float(other[merit]) == pytest.approx(expected, rel=1e-8, nan_ok=True), merit


IN_A_ROW = {"usable_travel", "clamped_length"}
SIDE_BY_SIDE = {"holding_force", "max_force"}
OF_ALL = {"energy_capacity", "mass", "volume"}


@pytest.mark.parametrize("name", NAMES)
def test_equal_brakes_share_forces_and_add_their_travels(name: str) -> None:
    single = compute(name, Units(), series=1.0, parallel=1.0)
    many = compute(name, Units(), series=4.0, parallel=5.0)
    times = dict.fromkeys(single, 1.0)
    times |= dict.fromkeys(IN_A_ROW, 4.0) | dict.fromkeys(SIDE_BY_SIDE, 5.0)
    times |= dict.fromkeys(OF_ALL, 20.0) | {"stiffness": 5 / 4, "force_density": 1 / 4}
    for merit in times.keys() - {"length", "judder_margin"}:
        expected = float(single[merit]) * times[merit]
        assert float(many[merit]) == pytest.approx(expected, rel=1e-12, nan_ok=True), merit
    assert float(many["length"]) > 4 * float(single["length"])


@pytest.mark.parametrize("name", NAMES)
def test_sheets_add_equal_masses_and_their_effect_is_the_slope(name: str) -> None:
    brake = load(name).brake
    line = make_sheet_line(name, brake, 6e4)
    assert line.sheets[0] == brake.sheets.count and np.all(np.diff(line.sheets) > 0)
    slopes = np.diff(line.masses) / np.diff(line.sheets)
    force, mass = added_sheet_effect(brake, 6e4)
    assert slopes == pytest.approx(np.full(len(slopes), mass), rel=1e-9)
    assert np.all(np.diff(line.forces) / np.diff(line.sheets) == pytest.approx(force, rel=0.2))
