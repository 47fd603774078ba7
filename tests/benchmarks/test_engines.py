"""The measured drop of docs/simulators.md is what two integrators written here compute."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:  # where pytest was not started as `python -m pytest` in the root
    sys.path.append(str(ROOT))

from benchmarks import engines  # noqa: E402
from layerjam.brake.commands.drop import drop  # noqa: E402
from layerjam.brake.device.load import load  # noqa: E402
from layerjam.brake.kernel.kernel import Kernel  # noqa: E402
from layerjam.core.errors import CompilerError  # noqa: E402

RECORD = json.loads(engines.RECORD.read_text(encoding="utf-8"))
PAGE = engines.PAGE.read_text(encoding="utf-8")
KAPTON, VACUUM, ROPE = "choi2018-kapton", 94.5e3, 16.8e3
GRAVITY = 9.80665


def kernel():
    try:
        return Kernel(load(KAPTON), rope_stiffness=ROPE)
    except CompilerError:
        pytest.skip("there is no C compiler here")


def euler(steps=80, step=0.5e-3):
    """Semi-implicit: the speed by the force at the start, the place by the new speed."""
    brake, place, speed, slips = kernel(), 0.0, 2.5, []
    for _ in range(steps):
        speed += step * (GRAVITY - brake.move(place, VACUUM))
        place += step * speed
        slips.append(brake.slip)
    return slips


def leapfrog(steps=80, step=0.5e-3):
    """Drift, kick, drift: what an exact step under the force of its middle is."""
    brake, place, speed, slips = kernel(), 0.0, 2.5, []
    for _ in range(steps):
        place += step / 2 * speed
        speed += step * (GRAVITY - brake.move(place, VACUUM))
        place += step / 2 * speed
        slips.append(brake.slip)
    return slips


def test_five_engines_are_semi_implicit_euler_and_opensim_a_leapfrog():
    """In single precision a slip of 17 mm is known to some ten nanometres."""
    five, sixth = np.array(euler()), np.array(leapfrog())
    for name, found in RECORD["engines"].items():
        due, near = (sixth, 1e-9) if name == "OpenSim" else (five, 1e-7)
        assert np.abs(found["slip"] - due).max() < near, name
        assert found["held"], name
    assert set(RECORD["engines"]) == set(engines.ENGINES)


def test_errors_are_those_that_were_promised():
    exact = float(drop(KAPTON, mass=1.0, speed=2.5, vacuum=VACUUM, rope_stiffness=ROPE).slip)
    assert RECORD["exact"] == pytest.approx(exact, abs=1e-12)
    errors = {n: 1e6 * (found["slip"][-1] - exact) for n, found in RECORD["engines"].items()}
    assert abs(errors.pop("OpenSim")) < 10
    assert all(error == pytest.approx(66.02, abs=0.05) for error in errors.values()), errors
    other = {n: 1e6 * (slip - exact) for n, slip in RECORD["other"].items()}
    assert other["Newton, SolverMuJoCo"] == pytest.approx(66.02, abs=0.05)


def test_the_page_shows_the_measured_table_and_every_recipe():
    assert engines.table(RECORD) in PAGE
    for function, *_ in engines.ENGINES.values():
        assert f"check({function}" in PAGE
