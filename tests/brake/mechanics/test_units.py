"""Every law in other units: a result changes as its unit says, so that no term has a wrong one."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest

from dimensions import OTHER, Units
from layerjam.core.evolve import evolve
from strategies import random_brakes

INPUTS = {
    "hold": (60.0, "s"), "vacuum": (3e4, "Pa"), "deflection": (1e-3, "m"), "length": (0.1, "m"),
    "force": (8.0, "N"), "slip": (5e-3, "m"), "angle": (0.2, "1"), "radius": (0.03, "m"),
    "heat": (3.0, "J"), "rise": (20.0, "K"), "film": (10.0, "W/(m^2 K)"), "mass": (0.4, "kg"),
    "speed": (0.7, "m/s"), "spring": (5e4, "N/m"), "gravity": (9.8, "m/s^2"),
}  # fmt: skip
BENDING = "enclosure_bending_stiffness bending_stiffness_free bending_stiffness_jammed"
WORK = "sheet_work slip_work work_to slip_heat pull_work"
LAWS = {
    ("ageing", "aged_static", "hold"): "1",
    ("ageing", "aged_holding_force", "hold vacuum"): "N",
    ("bending", BENDING, ""): "N m^2",
    ("bending", "shear_at_first_slip shear_at_full_slip", "vacuum"): "N",
    ("bending", "cantilever_force", "deflection length vacuum"): "N",
    ("bending", "cantilever_deflection", "force length vacuum"): "m",
    ("bending", "turning_stiffness_free turning_stiffness_jammed buckling_moment", "slip"): "N m",
    ("bending", "slip_moment", "slip vacuum"): "N m",
    ("bending", "turning_moment", "angle slip vacuum"): "N m",
    ("enclosure", "enclosure_force", "slip vacuum"): "N",
    ("enclosure", "enclosure_stretch", "slip vacuum"): "1",
    ("enclosure", "saturation_slip", "vacuum"): "m",
    ("energy", WORK, "slip vacuum"): "J",
    ("energy", "energy_capacity", ""): "J",
    ("fan", "amplification", "slip"): "1",
    ("fan", "fan_slope tension_ratio", ""): "1",
    ("friction", "friction_per_contact", "vacuum"): "N/m",
    ("friction", "sheet_friction", "slip vacuum"): "N",
    ("friction", "holding_force", "vacuum"): "N",
    ("heat", "rubbing_mass", ""): "kg",
    ("heat", "outer_area", ""): "m^2",
    ("heat", "temperature_rise temperature_rise_of_sheets", "heat"): "K",
    ("heat", "local_rise", "slip vacuum"): "K",
    ("heat", "stops_per_minute", "heat rise film"): "1/s",
    ("joint", "joint_friction joint_sheet_force", "slip vacuum angle radius force"): "N",
    ("limits", "buckling_force", "slip"): "N",
    ("limits", "greatest_force", ""): "N",
    ("limits", "sheet_stress clamp_stress", "force"): "Pa",
    ("limits", "travel_left", "slip"): "m",
    ("limits", "self_closing_vacuum", "slip"): "Pa",
    ("pull", "brake_force sliding_resistance force_at_elongation", "slip vacuum"): "N",
    ("pull", "slip_at_elongation", "slip vacuum"): "m",
    ("pull", "least_stiffness", "vacuum"): "N/m",
    ("pull", "scale_factor_of_peak", "force vacuum"): "1",
    ("pull", "vacuum_for_force holding_vacuum", "force slip"): "Pa",
    ("pull", "peak_vacuum", ""): "Pa",
    ("stiffness", "sheet_section", ""): "m^2",
    ("stiffness", "stiffness_before_slip working_stiffness mount_stiffness", ""): "N/m",
    ("stiffness", "stiffness_sliding", "slip"): "N/m",
    ("stop.tune", "tuned_vacuum", "mass speed slip spring gravity"): "Pa",
    ("stop.tune", "vacuum_eq10", "mass speed slip"): "Pa",
}
"""{(module, its laws, inputs): unit of the results}"""
NAMES = [names.split()[0] for _, names, _ in LAWS]


def make_brakes(kind: str) -> Any:
    brakes = random_brakes(5, 40, exponent=kind == "exponent", spacers=kind == "fan")
    film = evolve(brakes.film, specific_heat=1100.0, ageing=0.03, static_hold=10.0)
    return evolve(brakes, film=evolve(film, strength=np.full(40, 1e8)))


def compute(module: str, name: str, inputs: str, units: Units, brakes: Any) -> np.ndarray:
    law = getattr(importlib.import_module(f"layerjam.brake.mechanics.{module}"), name)
    values = [INPUTS[one][0] * units.factor(INPUTS[one][1]) for one in inputs.split()]
    return np.asarray(law(*values, units.scale(brakes)), float)


@pytest.mark.parametrize("kind", ["plain", "exponent", "fan"])
@pytest.mark.parametrize(("place", "unit"), LAWS.items(), ids=NAMES)
def test_a_law_does_not_depend_on_units(place: tuple[str, str, str], unit: str, kind: str) -> None:
    module, names, inputs = place
    brakes = make_brakes(kind)
    for name in names.split():
        one = compute(module, name, inputs, Units(), brakes)
        assert np.isfinite(one).mean() > 0.4 or (name == "amplification" and kind != "fan"), name
        for units in OTHER:
            other = compute(module, name, inputs, units, brakes)
            assert other == pytest.approx(one * units.factor(unit), rel=1e-7, nan_ok=True), name
