"""Whole simulations in other units: each column of a record changes as its unit says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from dimensions import Units
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.simulate.drop import drop
from layerjam.brake.simulate.drop_in_time import drop_in_time
from layerjam.brake.simulate.procedure import simple_pull
from layerjam.brake.simulate.stick_slip import stick_slip
from layerjam.brake.simulate.tensile import tensile

Run = Callable[[BrakeFile, Units], Any]
OTHER = (Units(length=3.0, mass=2.0, time=0.8), Units(mass=0.25))


def drop_exactly(file: BrakeFile, u: Units) -> Any:
    values = {"mass": u.mass, "speed": 1.5 * u.factor("m/s"), "vacuum": 6e4 * u.factor("Pa")}
    return drop(file, **values, rope_stiffness=2e5 * u.factor("N/m"))[1]


def drop_steps(file: BrakeFile, u: Units) -> Any:
    values = {"mass": u.mass, "speed": 1.5 * u.factor("m/s"), "vacuum": 6e4 * u.factor("Pa")}
    rope = {"rope_stiffness": 2e5 * u.factor("N/m"), "rope_damping": 20.0 * u.factor("N s/m")}
    return drop_in_time(file, **values, **rope, step=1e-4 * u.time)[1]


def pull(file: BrakeFile, u: Units) -> Any:
    return tensile(file, simple_pull(6e4 * u.factor("Pa"), 1e-2 * u.factor("m/s"), 0.02 * u.length))


def judder(file: BrakeFile, u: Units) -> Any:
    values = {"vacuum": 6e4 * u.factor("Pa"), "speed": 5e-3 * u.factor("m/s")}
    return stick_slip(file, **values, mass=0.2 * u.mass, damping=2.0 * u.factor("N s/m"))


@pytest.mark.parametrize("name", ["choi2018-kapton", "choi2018-ptfe"])
@pytest.mark.parametrize("run", [drop_exactly, drop_steps, pull, judder])
def test_a_simulation_does_not_depend_on_units(run: Run, name: str) -> None:
    file = load(name)
    one = run(file, Units())
    for units in OTHER:
        other = run(replace(file, brake=units.scale(file.brake)), units)
        assert other.outcome == one.outcome
        for column, values, spec in one.columns():
            expected = values * units.factor(spec.unit)
            size = np.abs(expected).max()
            assert getattr(other, column) == pytest.approx(expected, rel=1e-5, abs=1e-5 * size), (
                column
            )
