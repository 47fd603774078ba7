"""The helper in MuJoCo: the exact drop, no creep, no energy from nothing, clear refusals."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="make interop installs MuJoCo")
import mujoco as mj

from interop.scenes import EXACT_PEAK, EXACT_SLIP, ROPE, STIFFNESS, VACUUM, arm, falling
from layerjam.core.errors import CompilerError, QuantityError, UnknownNameError
from layerjam.interop import mujoco as brakes

KAPTON = "choi2018-kapton"
SLOW = pytest.mark.slow


def built(text):
    model = mj.MjModel.from_xml_string(text)
    return model, mj.MjData(model)


def drop(step, seconds=0.04, speed=2.5, vacuum=VACUUM, **more):
    """Slip [m] at the end and the greatest force [N] of 1 kg that falls into the brake."""
    model, data = built(falling(step=step))
    brake, most = brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE, **more), 0.0
    data.qvel[0] = speed
    for _ in range(round(seconds / step)):
        most = max(most, brake.before_step(data, vacuum))
        mj.mj_step(model, data)
    return brake.slip, most


@pytest.mark.parametrize(
    ("step", "micrometres"), [(2e-3, 641.4), (1e-3, 141.4), (5e-4, 66.02), (1e-4, 11.91)]
)
def test_the_drop_comes_to_the_exact_one_at_first_order(step, micrometres):
    """The closed form's slip; what is left is the engine's own first-order error."""
    slip, most = drop(step)
    assert (slip - EXACT_SLIP) * 1e6 == pytest.approx(micrometres, abs=0.05)
    assert abs(most - EXACT_PEAK) <= (0.1 if step <= 1e-3 else 4)


def test_the_coupling_that_eats_energy_stops_short():
    assert (drop(5e-4, coupling="implicit")[0] - EXACT_SLIP) * 1e6 == pytest.approx(-1593.6, abs=1)
    assert drop(5e-4, coupling="explicit") == drop(5e-4)


@SLOW
def test_the_twin_without_a_compiler_drops_as_far(monkeypatch):
    def none(*_, **__):
        raise CompilerError("no C compiler found")

    exact = drop(1e-3, seconds=0.03)
    monkeypatch.setattr(brakes, "Kernel", none)
    slip, most = drop(1e-3, seconds=0.03)
    assert slip == pytest.approx(exact[0], abs=1e-12)
    assert most == pytest.approx(exact[1], abs=1e-9)


def hold(mass, seconds):
    """A model that hangs still, weight and force equal to the last bit, held under a vacuum."""
    model, data = built(falling(mass, step=2e-3))
    brake = brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    data.qpos[0] = mass * 9.80665 / STIFFNESS
    model.opt.gravity[2] = -brake.before_step(data, VACUUM) / mass  # a power of two: exact
    mj.mj_step(model, data)
    before = (data.qpos.tobytes(), data.qvel.tobytes(), brake.state)
    for _ in range(round(seconds / 2e-3)):
        brake.before_step(data, VACUUM)
        mj.mj_step(model, data)
    return brake, before, (data.qpos.tobytes(), data.qvel.tobytes(), brake.state)


@pytest.mark.parametrize(
    ("mass", "seconds"), [(16.0, 20.0), (1.0, 20.0), pytest.param(16.0, 3600.0, marks=SLOW)]
)
def test_a_held_load_keeps_every_bit(mass, seconds):
    """16 kg are 89 % of what friction holds."""
    brake, before, after = hold(mass, seconds)
    assert before == after
    assert brake.slip == 0 and brake.force == pytest.approx(mass * 9.80665, rel=1e-9)


def test_a_load_that_swings_in_the_last_bit_does_not_creep_either():
    """A weight that no spring force meets exactly: the slip keeps its bits, the mass its place."""
    model, data = built(falling(3.0, step=2e-3))
    brake = brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    model.dof_damping[0] = 2 * np.sqrt(3.0 * STIFFNESS)
    data.qpos[0] = 3.0 * 9.80665 / STIFFNESS
    seen = []
    for _ in range(20_000):
        brake.before_step(data, VACUUM)
        mj.mj_step(model, data)
        seen.append(data.qpos[0])
    assert brake.slip == 0
    assert np.ptp(seen[10_000:]) <= 1e-15 and abs(seen[-1] - seen[10_000]) <= 1e-15


@pytest.mark.parametrize("late", [0.0, 0.3, 0.7])
@pytest.mark.parametrize("mass", [0.005, 0.02, 0.08])
def test_a_light_body_at_a_coarse_step_gains_no_speed(mass, late):
    """On 131 kN/m at 2 ms: omega h is 5.1 for 20 g, where an explicit spring explodes.

    The exact brake sticks under 5 g and 20 g, and what sticks gives back all: the body leaves as
    fast as it came. So does the softened spring, whose omega h is 1: after three steps the linear
    map (v, u) to (v - u/h, u + h v) is (-v, -u), whatever the phase.
    """
    model, data = built(falling(mass, step=2e-3, stiffness=131e3, gravity=0.0))
    brake = brakes.Brake(model, "cable", KAPTON)
    data.qpos[0], data.qvel[0] = -late * 5e-3, 2.5
    fastest = 0.0
    for _ in range(100):
        brake.before_step(data, VACUUM)
        mj.mj_step(model, data)
        fastest = max(fastest, abs(data.qvel[0]))
    assert fastest <= 2.5 * (1 + 1e-9)
    assert brake.slip == 0 and data.qvel[0] == pytest.approx(-2.5, rel=1e-9)


def test_an_explicit_spring_does_gain_speed_there():
    model, data = built(falling(0.02, step=2e-3, stiffness=131e3))
    brake = brakes.Brake(model, "cable", KAPTON, coupling="explicit")
    data.qvel[0] = 2.5
    for _ in range(20):
        brake.before_step(data, VACUUM)
        mj.mj_step(model, data)
    assert abs(data.qvel[0]) > 5


def test_energy_of_the_drop_is_heat_and_what_is_stored():
    """1 kg: m v^2/2 + m g z goes into heat, spring and enclosure; the error is of first order."""
    errors = []
    for step in (5e-4, 2.5e-4, 1.25e-4):
        model, data = built(falling(step=step))
        brake = brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE)
        data.qvel[0] = 2.5
        while data.qvel[0] > 0:
            brake.before_step(data, VACUUM)
            mj.mj_step(model, data)
        given = 2.5**2 / 2 - data.qvel[0] ** 2 / 2 + 9.80665 * data.qpos[0]
        errors.append(given - brake.heat - brake.law.stored)
    assert abs(errors[0]) < 0.1
    assert abs(errors[2]) < abs(errors[0]) / 2.5


def test_a_reset_and_a_state_lead_back():
    model, data = built(falling())
    brake = brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE)

    def run(steps):
        for _ in range(steps):
            brake.before_step(data, VACUUM)
            mj.mj_step(model, data)
        return data.qpos[0], brake.slip

    data.qvel[0] = 2.5
    first = run(30)
    kept = brake.state, data.qpos[0], data.qvel[0]
    later = run(20)
    brake.state, data.qpos[0], data.qvel[0] = kept
    assert run(20) == later
    mj.mj_resetData(model, data)
    brake.reset()
    data.qvel[0] = 2.5
    assert run(30) == first


def test_arm_over_a_drum_holds_and_slips():
    model, data = built(arm())
    brake = brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    model.dof_damping[0] = 1.0
    slips = []
    for _ in range(3000):
        brake.before_step(data, VACUUM)
        mj.mj_step(model, data)
        slips.append(brake.slip)
    assert brake.force > 100 and len(set(slips[1000:])) == 1
    held = brake.slip
    for _ in range(200):
        brake.before_step(data, 50e3)
        mj.mj_step(model, data)
    assert brake.slip > held + 1e-3


@pytest.mark.parametrize(
    ("cable", "stiffness", "words"),
    [
        ("", None, "tendon 'cable': without stiffness it carries no load"),
        ("", 1000.0, "its stiffness is 1000 N/m, but brake and rope have 14890.3924 N/m"),
        ('frictionloss="3"', STIFFNESS, "frictionloss would add a second resistance, and creep"),
        ('springyield="0.01"', STIFFNESS, "springyield would slide in addition"),
    ],
)
def test_a_tendon_that_cannot_carry_it_is_refused(cable, stiffness, words):
    model, _ = built(falling(cable=cable, stiffness=stiffness))
    with pytest.raises(QuantityError, match=words):
        brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE)


def test_names_numbers_and_integrators_that_are_not_allowed():
    model, data = built(falling())
    with pytest.raises(UnknownNameError, match="unknown tendon 'rope'; did you mean cable"):
        brakes.Brake(model, "rope", KAPTON, rope_stiffness=ROPE)
    with pytest.raises(UnknownNameError, match="coupling 'loose'"):
        brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE, coupling="loose")
    brake = brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    before = brake.state
    for bad in (-1.0, np.nan):
        with pytest.raises(QuantityError, match="vacuum"):
            brake.before_step(data, bad)
    assert brake.state == before
    for integrator in ("RK4", "discrete"):
        other, _ = built(falling(integrator=integrator))
        with pytest.raises(QuantityError, match="integrator"):
            brakes.Brake(other, "cable", KAPTON, rope_stiffness=ROPE)
