"""A toy effect in every model without a change to them, and the answers of the built-in effects."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

from layerjam.brake.device.effect import Effect
from layerjam.brake.device.load import load
from layerjam.brake.kernel.parameters import parameters
from layerjam.brake.mechanics.effects import BUILT_IN, friction_factor, list_effects, remove_fitted
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.friction import sheet_friction, sheet_friction_at
from layerjam.brake.mechanics.speed_effects import (
    depends_on_speed,
    fix_speed,
    has_speed_effects,
    ignore_speed,
    remove_idle_speed_law,
)
from layerjam.brake.mechanics.stick_slip.slide_step import resistance
from layerjam.brake.mechanics.stop.exact import paced_setup, stop
from layerjam.brake.mechanics.stop.motion import make_load
from layerjam.brake.mechanics.stop.paced import state_rates
from layerjam.brake.simulate import drop, stack, tensile
from layerjam.brake.simulate.procedure import simple_pull
from layerjam.brake.simulate.stick_slip import make_slide
from layerjam.core.errors import LayerjamError
from layerjam.core.evolve import evolve
from layerjam.core.units import quantity, record
from layerjam.interop.fmi import brake_values
from layerjam.laws import brake_force, peak_vacuum, tuned_vacuum, vacuum_for_force
from layerjam.workshop.design.merit import make_point, merits


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
    "model",
    [pytest.param(m, marks=pytest.mark.slow if m in ("tensile", "stack") else ()) for m in MODELS],
)
def test_every_model_applies_an_effect_that_none_of_them_knows(model):
    warm, same, cold = (np.asarray(MODELS[model](b), float) for b in (WARM, SAME, COLD))
    assert warm == pytest.approx(same, rel=1e-9) and not np.allclose(warm, cold, rtol=1e-3)


STATED = {
    "pressure_exponent": {"pressure_exponent": -0.2, "test_pressure": "20 kPa"},
    "vacuum_share": {"vacuum_share": 0.8},
    "speed_law": {
        "speed_law_power": 0.2,
        "speed_law_test_speed": "13 mm/s",
        "speed_law_rest_speed": "1 mm/s",
    },
    "mount.spacers": {"spacers": False},
    "film.ageing": {"ageing": 0.02, "static_hold": "10 s"},
    "hyperelastic": {"hyperelastic_c10": "16.7 kPa", "hyperelastic_strain": 12},
    "hyperelastic.softening_r": {
        "hyperelastic_c10": "16.7 kPa",
        "hyperelastic_strain": 12,
        "hyperelastic_softening_r": 1.7,
        "hyperelastic_softening_m": "4 kPa",
        "hyperelastic_softening_beta": 0.2,
    },
}
"""{table of a built-in effect: numbers that state it}."""


SLIDE = {"vacuum": 6e4, "speed": 0.01, "mass": 1.0, "stiffness": 1e5}


def is_refused(call, *words):
    try:
        call()
    except LayerjamError as error:
        assert any(word in str(error) for word in words), error
        return True
    return False


@pytest.mark.parametrize("effect", BUILT_IN, ids=lambda e: e.table)
def test_a_built_in_effect_answers_as_its_brake_behaves(effect):
    plain = FILE.brake.with_(amplification_held=None)
    brake = plain.with_(**STATED[effect.table])
    assert effect in list_effects(brake) and not list_effects(plain)
    assert effect.is_stated(brake) and effect.is_active(brake)
    key = effect.table.partition(".")[0]
    words = (key, "spacers", "speed")
    assert is_refused(lambda: parameters(brake), *words) != effect.in_kernel
    assert is_refused(lambda: brake_values(brake), *words) != effect.in_fmu
    ratio = sheet_friction(0.0, 8e4, brake) / sheet_friction(0.0, 4e4, brake)
    assert (abs(ratio / 2 - 1) < 1e-12) == effect.is_proportional
    halves = sheet_friction(np.array([0.0, 0.034]), 8e4, brake)
    assert (abs(halves[0] / halves[1] / 2 - 1) > 1e-9) == effect.depends_on_slip
    speeds = sheet_friction_at(0.0, np.array([0.01, 1.0]), 8e4, brake)
    assert (speeds[0] != speeds[1]) == effect.depends_on_speed == bool(depends_on_speed(brake))
    rubber = effect.table.startswith("hyperelastic")
    assert is_refused(lambda: enclosure_law(8e4, brake), "hyperelastic") == rubber
    assert effect not in list_effects(effect.remove(brake))
    if effect.table != "hyperelastic.softening_r":
        assert effect.remove(brake) == plain


@pytest.mark.parametrize(
    "effect",
    [pytest.param(e, marks=pytest.mark.slow if e.depends_on_speed else ()) for e in BUILT_IN],
    ids=lambda e: e.table,
)
def test_the_table_of_the_docs_names_the_calculations_that_reject_an_effect(effect):
    brake = FILE.brake.with_(**STATED[effect.table])
    rejected = {
        "`tune`": lambda: tuned_vacuum(1.0, 2.5, 0.04, 1.5e4, 9.8, brake),
        "`vacuum`": lambda: vacuum_for_force(40.0, 0.01, brake),
        "`stick-slip`": lambda: make_slide(brake, **SLIDE),
        "damping of the rope": lambda: make_load(1.0, 9.8, 1e4, 5.0, brake),
    }
    for name, call in rejected.items():
        assert is_refused(call, effect.table.partition(".")[0]) == (name in effect.rejected_by)


def test_idle_effects_leave_and_others_stay():
    speed = FILE.brake.with_(**STATED["speed_law"])
    assert remove_idle_speed_law(speed) is speed and ignore_speed(speed) == FILE.brake
    idle = speed.with_(speed_law_power=0.0)
    assert remove_idle_speed_law(idle) == FILE.brake and has_speed_effects(idle)
    assert parameters(idle) == parameters(FILE.brake)
    fixed = fix_speed(0.5, speed)
    assert fixed.film.kinetic == pytest.approx(0.24 * (0.501 / 0.014) ** 0.2, rel=1e-14)
    assert fixed.speed_law is None and fix_speed(0.5, FILE.brake) is FILE.brake
    both = speed.with_(**STATED["pressure_exponent"])
    assert remove_fitted(both) == FILE.brake


def test_a_brake_keeps_its_own_list_of_effects():
    shared = FILE.brake.with_(vacuum_share=0.5)
    assert list_effects(shared) is list_effects(shared)
    other = copy.copy(shared)
    object.__setattr__(other, "vacuum_share", None)
    assert len(list_effects(shared)) == 1 and list_effects(other) == ()
    assert pickle.loads(pickle.dumps(shared)) == shared
    assert friction_factor(8e4, WARM) == pytest.approx(0.8, rel=1e-14)


@record
class Growth(Effect):
    """The power law of `[speed_law]`, as another package would state it."""

    power: float = quantity("1", "exponent", hi=1)
    depends_on_speed = True

    def growth(self, speed, brake):
        return ((1e-3 + speed) / (1e-3 + 0.013)) ** self.power

    def growth_slope(self, speed, brake):
        return self.power / (1e-3 + speed)

    def rest_speed(self, brake):
        return 1e-3


TWIN = replace(FILE.brake, effects=(Growth(power=0.2),))
LAW = FILE.brake.with_(**STATED["speed_law"])


def test_solvers_apply_a_speed_effect_of_another_package_as_the_built_in_law():
    states = np.array([[1e-4, 5e-3, 2e-2], [1.0, 0.6, 0.2], [1e-6, 0.1, 0.3], [0.0, 0.1, 1.0]])
    ends = []
    for brake in (LAW, TWIN):
        case = paced_setup(1.0, np.array([1.0, 1.0, 1.0]), 6e4, 1.5e4, 9.8, brake)
        slide = make_slide(brake, **SLIDE)
        paces = np.array([0.0, 1e-3, 1.0])
        friction = [resistance(1e-3, pace, slide) for pace in paces]
        ends.append(
            (state_rates(states, case), friction, sheet_friction_at(0.01, paces, 8e4, brake))
        )
    for built_in, other in zip(*ends, strict=True):
        assert np.asarray(other) == pytest.approx(np.asarray(built_in), rel=1e-12)
    assert is_refused(lambda: parameters(TWIN), "effects") and depends_on_speed(TWIN)
    fixed = fix_speed(0.5, TWIN)
    assert fixed.effects == () and fixed.film.kinetic == fix_speed(0.5, LAW).film.kinetic


@pytest.mark.slow
def test_a_stop_with_a_speed_effect_of_another_package_is_that_of_the_built_in_law():
    case = (1.0, 1.0, 6e4, 1.5e4, 9.8)
    assert np.array(stop(*case, TWIN)) == pytest.approx(np.array(stop(*case, LAW)), rel=1e-9)


@record
class Shorter(Effect):
    """Friction that falls with slip as if the overlap were shorter by `missing`."""

    missing: float = quantity("m", "length without friction", hi=0.1)
    depends_on_slip, is_proportional = True, True

    def slip_factor(self, slip, brake):
        return 1 - self.missing / (brake.sheets.overlap - slip)

    def slip_slope(self, slip, brake):
        return -self.missing / (brake.sheets.overlap - slip) ** 2


LOST, MORE = 8e-3, ("free_left", "free_right")
BENT = replace(COLD, effects=(Shorter(missing=LOST),))
CUT = evolve(
    COLD,
    sheets=evolve(
        COLD.sheets,
        overlap=COLD.sheets.overlap - LOST,
        **{name: getattr(COLD.sheets, name) + LOST / 2 for name in MORE},
    ),
)
"""A brake with that shorter overlap, and an enclosure of the same length."""


@pytest.mark.parametrize(
    "model", ["force", pytest.param("tensile", marks=pytest.mark.slow), "drop", "tune"]
)
def test_every_model_applies_a_change_with_slip_that_none_of_them_knows(model):
    """The sheets of a shorter overlap are also stiffer, which the stack of them would show."""
    bent, cut, cold = (np.asarray(MODELS[model](b), float) for b in (BENT, CUT, COLD))
    if model == "tensile":  # the steps of the two pulls differ
        bent, cut, cold = bent.max(), cut.max(), cold.max()
    assert bent == pytest.approx(cut, rel=2e-7) and not np.allclose(bent, cold, rtol=1e-3)
