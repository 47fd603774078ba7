"""A toy effect, friction that falls with temperature, in every model without a change to them."""

from dataclasses import replace

import numpy as np
import pytest

from layerjam.design.merit import make_point, merits
from layerjam.device.load import load
from layerjam.laws import brake_force, peak_vacuum, tuned_vacuum, vacuum_for_force
from layerjam.simulate import drop, stack, tensile
from layerjam.simulate.procedure import simple_pull
from layerjam.units import quantity, record


@record
class Warmth:
    rise: float = quantity("K", "temperature over that of the friction test", hi=200)

    def friction_factor(self, vacuum, brake):
        return 1 - 4e-3 * self.rise


FILE, PULL = load("choi2018-kapton"), simple_pull(94.5e3, 0.013, 0.040)
COLD = FILE.brake.with_(usable_travel=0.05, kinetic=0.24, static=0.32)
SAME, WARM = COLD.with_(kinetic=0.192, static=0.256), replace(COLD, effects=(Warmth(rise=50.0),))
MODELS = {
    "force": lambda b: [brake_force(0.02, 8e4, b), vacuum_for_force(80, 0.02, b), peak_vacuum(b)],
    "tensile": lambda b: tensile.tensile(replace(FILE, brake=b), PULL).force,
    "drop": lambda b: drop.drop(replace(FILE, brake=b), mass=1.0, speed=2.5, vacuum=9e4)[0].slip,
    "tune": lambda b: tuned_vacuum(1.0, 2.5, 0.04, 1.5e4, 9.8, b),
    "stack": lambda b: stack.tensile_stack(replace(FILE, brake=b), PULL)[0].force,
    "design": lambda b: list(merits(make_point(b, 9e4), b).values()),
}


@pytest.mark.parametrize(
    "model", [pytest.param(m, marks=pytest.mark.slow) if m == "stack" else m for m in MODELS]
)
def test_every_model_applies_an_effect_that_none_of_them_knows(model):
    warm, same, cold = (np.asarray(MODELS[model](b), float) for b in (WARM, SAME, COLD))
    assert warm == pytest.approx(same, rel=1e-9) and not np.allclose(warm, cold, rtol=1e-3)
