"""The brake in MJX: as far as in MuJoCo, in either precision, with a gradient; clear refusals."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

pytest.importorskip("mujoco", reason="make interop installs MuJoCo")
pytest.importorskip("mujoco.mjx", reason="make interop installs MJX")
import mujoco as mj
from mujoco import mjx

from interop.scenes import EXACT_SLIP, ROPE, STIFFNESS, VACUUM, arm, falling
from layerjam.core.errors import QuantityError
from layerjam.interop import mjx as brakes
from layerjam.interop import mujoco as helpers

KAPTON = "choi2018-kapton"
SLOW = pytest.mark.slow


def built(text, speed):
    model = mj.MjModel.from_xml_string(text)
    brake = brakes.brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    mx = mjx.put_model(model)
    data = mj.MjData(model)
    data.qvel[0] = speed
    return brake, mx, mjx.fwd_position(mx, mjx.put_data(model, data))


def rolled(brake, mx, d, state, vacuum, steps):
    def step(carry, _):
        return brakes.step(mx, *carry, vacuum, brake), None

    return jax.lax.scan(step, (d, state), None, steps)[0]


@SLOW
def test_the_drop_in_double_precision_and_its_gradient():
    """d slip/d vacuum through 60 steps, against differences and against the exact law's."""
    brake, mx, d = built(falling(step=5e-4), 2.5)
    state = brakes.start(brake)
    end = jax.jit(rolled, static_argnums=5)(brake, mx, d, state, VACUUM, 80)[1]
    assert (float(end.slip) - EXACT_SLIP) * 1e6 == pytest.approx(66.02, abs=0.05)

    model = mj.MjModel.from_xml_string(falling(step=5e-4))
    data = mj.MjData(model)
    data.qvel[0] = 2.5
    helper = helpers.Brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    for _ in range(80):
        helper.before_step(data, VACUUM)
        mj.mj_step(model, data)
    assert float(end.slip) == pytest.approx(helper.slip, abs=1e-9)

    def slip(vacuum):
        return rolled(brake, mx, d, state, vacuum, 60)[1].slip

    value = jax.jit(slip)
    by_differences = float(value(VACUUM + 50) - value(VACUUM - 50)) / 100
    gradient = float(jax.jit(jax.jacfwd(slip))(VACUUM))
    assert gradient == pytest.approx(by_differences, rel=1e-3)
    assert gradient == pytest.approx(-3.69241e-7, rel=1e-2)  # the exact law, interop.md 3.3


@SLOW
def test_the_drop_in_single_precision():
    with jax.enable_x64(False):
        brake, mx, d = built(falling(step=5e-4), 2.5)
        end = jax.jit(rolled, static_argnums=5)(brake, mx, d, brakes.start(brake), VACUUM, 80)[1]
        assert end.slip.dtype == jnp.float32
        assert (float(end.slip) - EXACT_SLIP) * 1e6 == pytest.approx(66.02, abs=0.1)


@SLOW
@pytest.mark.parametrize(("wide", "steps"), [(False, 1_800_000), (True, 2_000)])
def test_sixteen_kilograms_keep_every_bit(wide, steps):
    """For an hour in single precision; weight and force are equal to the last bit, as in MuJoCo."""
    with jax.enable_x64(wide):
        brake, mx, d = built(falling(16.0, step=2e-3), 0.0)
        d = d.replace(qpos=d.qpos.at[0].set(16 * 9.80665 / STIFFNESS))
        run = jax.jit(rolled, static_argnums=5)
        first, state = run(brake, mx, d, brakes.start(brake), VACUUM, 1)
        weight = mx.opt.gravity.at[2].set(first.qfrc_passive[0] / 16)
        mx = mx.tree_replace({"opt.gravity": weight})
        before = run(brake, mx, d, state, VACUUM, 1)
        after = run(brake, mx, *before, VACUUM, steps)
        for a, b in zip(*(jax.tree.leaves(kept(*each)) for each in (before, after)), strict=True):
            assert np.asarray(a).tobytes() == np.asarray(b).tobytes()
        assert after[1].slip == 0 and float(after[1].force) == pytest.approx(156.9, abs=0.1)


def kept(d, state):
    """All that the next step starts from, but the time."""
    return d.qpos, d.qvel, d.qacc_warmstart, state


@SLOW
def test_a_load_that_swings_does_not_creep():
    """A weight that no spring force meets exactly: undamped it swings by rounding, for an hour."""
    with jax.enable_x64(False):
        brake, mx, d = built(falling(16.0, step=2e-3), 0.0)
        d = d.replace(qpos=d.qpos.at[0].set(16 * 9.80665 / STIFFNESS))
        run = jax.jit(rolled, static_argnums=5)
        settled = run(brake, mx, d, brakes.start(brake), VACUUM, 1000)
        after = run(brake, mx, *settled, VACUUM, 100_000)
        memories = (settled[1].brake.enclosure, after[1].brake.enclosure)
        for a, b in zip(*map(jax.tree.leaves, memories), strict=True):
            assert np.asarray(a).tobytes() == np.asarray(b).tobytes()
        assert after[1].slip == 0
        assert abs(float(after[0].qpos[0] - settled[0].qpos[0])) < 1e-4


@SLOW
def test_the_arm_over_a_drum_goes_as_far_as_with_the_helper():
    brake, mx, d = built(arm(), 2.5)
    end = jax.jit(rolled, static_argnums=5)(brake, mx, d, brakes.start(brake), 30e3, 100)
    model = mj.MjModel.from_xml_string(arm())
    data = mj.MjData(model)
    data.qvel[0] = 2.5
    helper = helpers.Brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    for _ in range(100):
        helper.before_step(data, 30e3)
        mj.mj_step(model, data)
    assert helper.slip > 1e-3
    assert float(end[1].slip) == pytest.approx(helper.slip, abs=1e-9)


def test_what_mjx_would_take_in_silence_is_refused():
    spec = mj.MjSpec.from_string(falling(stiffness=None))
    helpers.attach(spec, "cable", KAPTON)
    with pytest.raises(
        QuantityError, match="actuator 'cable': MJX would treat this plugin as a motor"
    ):
        brakes.brake(spec.compile(), "cable", KAPTON)
    model = mj.MjModel.from_xml_string(falling(cable='springyield="0.01"'))
    with pytest.raises(QuantityError, match="MJX treats springyield as an elastic spring"):
        brakes.brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    model = mj.MjModel.from_xml_string(falling(stiffness=None))
    with pytest.raises(QuantityError, match="tendon 'cable': without stiffness"):
        brakes.brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    model = mj.MjModel.from_xml_string(falling())
    brake = brakes.brake(model, "cable", KAPTON, rope_stiffness=ROPE)
    for dtype, words in ((jnp.float16, "float16 is not allowed"), (jnp.float64, "jax_enable_x64")):
        with jax.enable_x64(False), pytest.raises(QuantityError, match=words):
            brakes.start(brake, dtype)
