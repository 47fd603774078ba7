"""Stresses and masses of a build whose lengths are all twice as long, and twice the force."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from dimensions import Units
from layerjam.brake.device.load import load
from layerjam.brake.device.workshop import Build
from layerjam.workshop.fabricate.lengths import compute_lengths, ellipse_girth
from layerjam.workshop.fabricate.masses import nut_mass, screw_mass
from layerjam.workshop.fabricate.screws import Thread
from layerjam.workshop.fabricate.strength import (
    cap_stresses,
    screw_preload,
    screw_torque,
    strength_checks,
    tray_factor,
)

BRAKE, BUILD = load("choi2018-kapton").with_(strength="69 MPa").brake, Build()
LENGTHS = compute_lengths(BRAKE, BUILD)


def enlarge(record: Any, size: float) -> Any:
    """The record with every length times `size`, areas times its square; counts stay."""
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        power = 2 if "area" in field.name else 1
        if dataclasses.is_dataclass(value):
            changes[field.name] = enlarge(value, size)
        elif isinstance(value, float | np.floating) or (
            isinstance(value, int) and (isinstance(record, Thread) or field.name == "screw_length")
        ):
            changes[field.name] = value * size**power
    return dataclasses.replace(record, **changes)


@pytest.mark.parametrize("size", [2.0, 0.3])
def test_stresses_are_forces_per_area_and_masses_volumes_times_densities(size: float) -> None:
    large, build = enlarge(LENGTHS, size), Units(length=size).scale(BUILD)
    assert tray_factor(build, large) == pytest.approx(tray_factor(BUILD, LENGTHS) / size**2)
    small = cap_stresses(120.0, 300.0, BUILD, LENGTHS)
    for place, stress in cap_stresses(120.0, 300.0, build, large).items():
        assert stress == pytest.approx(small[place] / size**2, rel=1e-9), place
    for mass in (screw_mass, nut_mass):
        assert mass(large) == pytest.approx(mass(LENGTHS) * size**3, rel=1e-9)
    turn = screw_torque(120.0, BRAKE, BUILD, LENGTHS)
    assert screw_torque(120.0, BRAKE, BUILD, large) == pytest.approx(turn * size, rel=1e-9)


def test_stresses_are_proportional_to_the_force() -> None:
    single, double = (
        {(c.code, c.key): (c.value, c.limit) for c in strength_checks(f, BRAKE, BUILD, LENGTHS)}
        for f in (60.0, 120.0)
    )
    assert single.keys() == double.keys() and len(single) >= 8
    for key, (value, limit) in single.items():
        assert double[key] == (pytest.approx(2 * value, rel=1e-12), limit), key


def test_friction_of_two_faces_and_all_screws_holds_the_force() -> None:
    force = 2 * BRAKE.film.kinetic * LENGTHS.screws * screw_preload(90.0, BRAKE, LENGTHS)
    assert force == pytest.approx(90.0, rel=1e-12)


def test_a_lopsided_tray_bends_and_an_even_one_does_not() -> None:
    """Force over section alone if the stack lies on the axis of the section."""
    even = dataclasses.replace(LENGTHS, screws=0, slot=0.0, plate_height=LENGTHS.shelf_height)
    area = even.tray_width * (even.stack + 2 * even.shelf_height)
    assert tray_factor(BUILD, even) == pytest.approx(1 / area, rel=1e-9)
    height = even.stack + even.plate_height + even.shelf_height
    lifted = dataclasses.replace(even, plate_height=even.plate_height + 4)
    arm, height = 2.0, height + 4
    area = lifted.tray_width * height
    expected = 1 / area + arm * height / 2 / (lifted.tray_width * height**3 / 12)
    assert tray_factor(BUILD, lifted) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("ratio", [1.0, 1.7, 6.0, 60.0])
def test_the_girth_of_an_ellipse_is_the_sum_of_its_chords(ratio: float) -> None:
    angle = np.linspace(0, 2 * math.pi, 200_001)
    x, y = 3.0 * ratio * np.cos(angle), 3.0 * np.sin(angle)
    chords = float(np.hypot(np.diff(x), np.diff(y)).sum())
    assert float(ellipse_girth(3.0 * ratio, 3.0)) == pytest.approx(chords, rel=1e-8)


def test_lengths_along_the_brake_add_up() -> None:
    """The enclosure from cap to cap and over both caps, the ports, and half a head at each end."""
    for side in LENGTHS.sides:
        assert side.sheets + side.spacers == LENGTHS.count
        free = BRAKE.sheets.free_left if side.name == "left" else BRAKE.sheets.free_right
        outside = (free + BRAKE.sheets.overlap) * 1e3
        assert side.clamped + outside == pytest.approx(LENGTHS.sheet_length, rel=1e-12)
    assert LENGTHS.sleeve == pytest.approx(
        LENGTHS.free + sum(side.reach for side in LENGTHS.sides), rel=1e-12
    )
    rest = LENGTHS.overall - LENGTHS.sleeve - 2 * LENGTHS.port_length
    assert rest == pytest.approx(2 * LENGTHS.head, rel=1e-9)
    assert LENGTHS.strap - LENGTHS.pin_to_pin == pytest.approx(BRAKE.sheets.usable_travel * 1e3)
    heights = LENGTHS.plate_height + LENGTHS.shelf_height + LENGTHS.stack
    assert LENGTHS.cap_height == pytest.approx(heights, rel=1e-12)
    girth = 2 * (LENGTHS.inner_width + LENGTHS.inner_height)
    assert LENGTHS.girth == pytest.approx(girth, rel=1e-12)
    stretched = float(ellipse_girth(LENGTHS.neck_a, LENGTHS.neck_b))
    assert stretched == pytest.approx(girth * (1 + BUILD.neck_stretch), rel=1e-9)
