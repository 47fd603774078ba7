"""The plugin `layerjam.brake`: exact, still, repeatable, and clear about what is wrong."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="make interop installs MuJoCo")
import mujoco as mj
from mujoco import rollout

from interop.scenes import EXACT_SLIP, ROPE, STIFFNESS, VACUUM, arm, falling
from layerjam.brake.device.load import load
from layerjam.brake.kernel.kernel import Kernel, state_bytes
from layerjam.core.errors import QuantityError, UnknownNameError
from layerjam.interop import mujoco as brakes

KAPTON = "choi2018-kapton"
SLIP, FORCE, HEAT, VACUUM_AT = 3, 2, 5, 1
"""Places in a plugin's state: its first numbers are those of lj_state."""


def model_of(text, **more):
    spec = mj.MjSpec.from_string(text)
    brakes.attach(spec, "cable", KAPTON, **{"rope_stiffness": ROPE, **more})
    return spec.compile()


def built(text, **more):
    model = model_of(text, **more)
    data = mj.MjData(model)
    data.ctrl[0] = VACUUM
    return model, data


def drop(step, integrator="Euler", seconds=0.04, **more):
    model, data = built(falling(step=step, integrator=integrator, stiffness=None), **more)
    data.qvel[0] = 2.5
    for _ in range(round(seconds / step)):
        mj.mj_step(model, data)
    return data.plugin_state[SLIP]


def error(*args, **more):
    """Slip beyond the exact one [µm]."""
    return (drop(*args, **more) - EXACT_SLIP) * 1e6


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "discrete"])
def test_the_drop_at_first_order(integrator):
    errors = [error(step, integrator) for step in (1e-3, 5e-4, 1e-4, 5e-5)]
    assert errors == pytest.approx([141.4, 66.02, 11.91, errors[3]], abs=0.05)
    assert np.log2(errors[2] / errors[3]) >= 0.9


def test_the_drop_with_runge_kutta():
    assert error(1e-3, "RK4") == pytest.approx(-9.8, abs=0.1)
    assert abs(error(5e-4, "RK4")) <= 1
    assert abs(error(1e-4, "RK4")) <= 0.1


def test_the_helper_and_the_plugin_go_equally_far():
    """On the drop, and on the arm whose cable lies over a drum."""
    for text, seconds in ((falling, 0.04), (arm, 1.0)):
        model, data = built(text(step=1e-3, stiffness=None))
        other = mj.MjModel.from_xml_string(text(step=1e-3, stiffness=STIFFNESS))
        same = mj.MjData(other)
        helper = brakes.Brake(other, "cable", KAPTON, rope_stiffness=ROPE)
        data.qvel[0] = same.qvel[0] = 2.5
        furthest = 0.0
        for i in range(round(seconds / 1e-3)):
            vacuum = VACUUM if i % 300 < 200 else 40e3
            data.ctrl[0] = vacuum
            mj.mj_step(model, data)
            helper.before_step(same, vacuum)
            mj.mj_step(other, same)
            assert data.plugin_state[SLIP] == pytest.approx(helper.slip, abs=1e-9)
            assert data.qpos[0] == pytest.approx(same.qpos[0], abs=1e-8)
            furthest = max(furthest, helper.slip)
        assert furthest > 2e-3


@pytest.mark.parametrize("seconds", [20.0, pytest.param(3600.0, marks=pytest.mark.slow)])
def test_a_held_load_keeps_every_bit(seconds):
    """16 kg for an hour at 2 ms; weight and force are equal to the last bit."""
    model, data = built(falling(16.0, step=2e-3, stiffness=None))
    data.qpos[0] = 16 * 9.80665 / STIFFNESS
    mj.mj_forward(model, data)
    model.opt.gravity[2] = data.actuator_force[0] / 16
    mj.mj_step(model, data)
    before = data.qpos.tobytes(), data.qvel.tobytes(), data.plugin_state.tobytes()
    steps = round(seconds / 2e-3)
    mj.mj_step(model, data, nstep=steps)
    assert (data.qpos.tobytes(), data.qvel.tobytes(), data.plugin_state.tobytes()) == before
    assert data.plugin_state[SLIP] == 0 and -data.actuator_force[0] == pytest.approx(156.9, abs=0.1)


@pytest.mark.slow
def test_frictionloss_creeps_where_the_brake_does_not():
    """Its hardest setting, the same 16 kg and the same hour; benchmarks.creep prints the rest."""
    hardest = 'frictionloss="175.43" solreffriction=".002 1" solimpfriction=".9999 .9999 .001 .5 2"'
    text = falling(16.0, step=2e-3, stiffness=None)
    joint = 'axis="0 0 -1"/>'
    assert joint in text
    model = mj.MjModel.from_xml_string(text.replace(joint, f'axis="0 0 -1" {hardest}/>'))
    data = mj.MjData(model)
    mj.mj_step(model, data, nstep=1_800_000)
    print(f"frictionloss at its hardest: {1e3 * data.qpos[0]:.3f} mm in an hour under 16 kg")
    assert 5e-3 < data.qpos[0] < 10e-3


@pytest.mark.parametrize("late", [0.0, 0.3, 0.7])
def test_a_light_body_at_a_coarse_step_gains_no_speed(late):
    """20 g on 131 kN/m at 2 ms."""
    text = falling(0.02, step=2e-3, stiffness=None, gravity=0.0)
    model, data = built(text, rope_stiffness=None)
    data.qpos[0], data.qvel[0], fastest = -late * 5e-3, 2.5, 0.0
    for _ in range(100):
        mj.mj_step(model, data)
        fastest = max(fastest, abs(data.qvel[0]))
    assert fastest <= 2.5 * (1 + 1e-9)
    assert data.plugin_state[SLIP] == 0 and data.qvel[0] == pytest.approx(-2.5, rel=1e-9)
    model, data = built(text, rope_stiffness=None, coupling="implicit")
    data.qpos[0], data.qvel[0] = -late * 5e-3, 2.5
    mj.mj_step(model, data, nstep=100)
    assert abs(data.qvel[0]) < 0.2


def sliding():
    """A model in the middle of its slide."""
    model, data = built(falling(step=1e-3, stiffness=None))
    data.qvel[0] = 2.5
    mj.mj_step(model, data, nstep=12)
    assert data.plugin_state[SLIP] > 1e-3
    return model, data


def everything(model, data):
    whole = mj.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mj.mj_stateSize(model, whole))
    mj.mj_getState(model, data, state, whole)
    return state


def test_asking_changes_nothing_and_copies_go_on_alike():
    model, data = sliding()
    kept = everything(model, data)
    for _ in range(5):
        mj.mj_forward(model, data)
    assert data.plugin_state.tobytes() == everything_of_plugin(model, kept).tobytes()
    copied = mj.MjData(model)
    mj.mj_copyData(copied, model, data)
    set_ = mj.MjData(model)
    mj.mj_setState(model, set_, kept, mj.mjtState.mjSTATE_INTEGRATION)
    for each in (data, copied, set_):
        mj.mj_step(model, each, nstep=20)
    for each in (copied, set_):
        assert each.qpos.tobytes() == data.qpos.tobytes()
        assert each.plugin_state.tobytes() == data.plugin_state.tobytes()
    assert np.isfinite(data.plugin_state).all()


def everything_of_plugin(model, state):
    other = mj.MjData(model)
    mj.mj_setState(model, other, state, mj.mjtState.mjSTATE_INTEGRATION)
    return other.plugin_state


def test_threads_give_the_same_bits():
    model, data = sliding()
    full = mj.mjtState.mjSTATE_FULLPHYSICS
    one = np.empty(mj.mj_stateSize(model, full))
    mj.mj_getState(model, data, one, full)
    start = np.tile(one, (8, 1))
    control = np.linspace(20e3, 90e3, 8 * 30).reshape(8, 30, 1)
    results = []
    for threads in (1, 2):
        each = [mj.MjData(model) for _ in range(threads)]
        results.append(rollout.rollout(model, each, start, control)[0])
    assert results[0].tobytes() == results[1].tobytes()
    assert np.ptp(results[0][:, -1, 1]) > 1e-4


def test_the_force_is_the_kernels_along_the_path_that_was_taken():
    model, data = built(falling(step=1e-3, stiffness=None))
    kernel = Kernel(load(KAPTON), rope_stiffness=ROPE)
    data.qvel[0] = 2.5
    rng = np.random.default_rng(2)
    for _ in range(60):
        data.ctrl[0] = rng.uniform(0, 1e5)
        elongation = data.qpos[0]
        mj.mj_step(model, data)
        force = kernel.move(elongation, data.ctrl[0])
        assert -data.actuator_force[0] == pytest.approx(force, abs=1e-9)


def test_the_vacuum_line_is_the_actuators_dynamics():
    """P (1 - exp(-t/tau)), the closed form, at any step."""
    model, data = built(falling(step=1e-2, stiffness=None), vacuum_lag=2.2533)
    data.ctrl[0] = 101325.0
    mj.mj_step(model, data, nstep=390)
    assert data.act[0] == pytest.approx(101325 * (1 - np.exp(-3.9 / 2.2533)), rel=1e-12)
    assert data.plugin_state[VACUUM_AT] == pytest.approx(data.act[0], rel=2e-3)


def test_a_control_that_is_no_number_keeps_the_last_vacuum(tmp_path, monkeypatch):
    """And goes on with it: the force falls when the load turns back."""
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warnings into a file
    model, data = sliding()
    data.ctrl[0] = np.nan
    mj.mj_step(model, data, nstep=60)
    assert data.warning[mj.mjtWarning.mjWARN_BADCTRL].number > 0
    assert data.plugin_state[VACUUM_AT] == VACUUM
    same, other = sliding()
    mj.mj_step(same, other, nstep=60)
    assert other.qpos[0] == data.qpos[0]


def test_the_control_stays_within_what_the_atmosphere_gives():
    model, data = sliding()
    data.ctrl[0] = 5e5
    mj.mj_step(model, data)
    assert data.plugin_state[VACUUM_AT] == 101325
    data.ctrl[0] = -5.0
    mj.mj_step(model, data)
    assert data.plugin_state[VACUUM_AT] == 0


def test_the_gradient_by_differences_sees_the_vacuum():
    model, data = sliding()
    b = np.zeros((2 * model.nv + model.na, model.nu))
    a = np.zeros((b.shape[0], b.shape[0]))
    mj.mjd_transitionFD(model, data, 1.0, True, a, b, None, None)
    assert -2e-6 < b[1, 0] < -4e-7


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ('key="contact" value="0.0273"', 'key="contact" value="-1"', "contact must be above zero"),
        pytest.param(
            'key="reach" value="0.045"',
            'key="reach" value="4,5"',
            "reach is no number",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            'key="overlap" value="0.068"',
            'key="rest_length" value="0.1"',
            "overlap is missing",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            'value="limited"', 'value="loose"', "coupling is 'loose'", marks=pytest.mark.slow
        ),
        pytest.param(
            'key="contact"',
            'key="kontakt"',
            "unrecognized attribute 'plugin:kontakt'",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            'key="contact"',
            'key="sheets" value="11"/><config key="width" value="0.013"/><config key="contact"',
            "wraps one cylinder or sphere; this one wraps 0",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_wrong_attributes_are_named(before, after, words, tmp_path):
    """In a process of its own: MuJoCo prints the plugin's sentence beside its own error."""
    text = falling(stiffness=None).replace("<mujoco>", '<mujoco><include file="actuator.xml"/>')
    (tmp_path / "model.xml").write_text(text)
    fragment = brakes.mjcf(KAPTON, rope_stiffness=ROPE)
    assert before in fragment
    (tmp_path / "actuator.xml").write_text(fragment.replace(before, after))
    code = (
        "from layerjam.interop import mujoco as b; import mujoco\n"
        "b.load(); mujoco.MjModel.from_xml_path('model.xml')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode != 0 and words in done.stdout + done.stderr


def test_two_brakes_on_two_tendons_pull_like_one_each():
    """The default name is the tendon's; each actuator has its own vacuum and memory."""
    text = falling(step=1e-3, stiffness=None)
    cable = text[text.index("<spatial") : text.index("</tendon>")]
    body = text[text.index("<body") : text.index("</worldbody>")]
    both = text.replace(body, body + re.sub('name="(load|down)"', r'name="\1 2"', body))
    second = cable.replace('"cable"', '"other"').replace('site="load"', 'site="load 2"')
    spec = mj.MjSpec.from_string(both.replace(cable, cable + second))
    for tendon in ("cable", "other"):
        brakes.attach(spec, tendon, KAPTON, rope_stiffness=ROPE)
    with pytest.raises(QuantityError, match="already has an actuator 'other'; choose a different"):
        brakes.attach(spec, "other", KAPTON)
    model = spec.compile()
    assert [model.actuator(i).name for i in range(model.nu)] == ["cable", "other"]
    data = mj.MjData(model)
    data.qvel[:], data.ctrl[:] = 2.5, (VACUUM, 40e3)
    mj.mj_step(model, data, nstep=40)
    for i, vacuum in enumerate((VACUUM, 40e3)):
        alone = model_of(text)
        single = mj.MjData(alone)
        single.qvel[0], single.ctrl[0] = 2.5, vacuum
        mj.mj_step(alone, single, nstep=40)
        assert data.qpos[i] == pytest.approx(single.qpos[0], abs=1e-12)
    assert data.qpos[1] > 1.5 * data.qpos[0]


@pytest.mark.parametrize("damage", [(1, np.nan), (-4, 99.0), (-3, 255.0), (-1, 1e300)])
def test_a_damaged_memory_is_said_and_the_simulation_reset(damage, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warnings into a file
    model, data = sliding()
    data.plugin_state[damage[0]] = damage[1]
    mj.mj_step(model, data)
    assert data.warning[mj.mjtWarning.mjWARN_BADQACC].number == 1
    assert data.time == model.opt.timestep and np.isfinite(data.qpos).all()
    assert data.plugin_state[SLIP] == 0
    assert "plugin_state is damaged" in (tmp_path / "MUJOCO_LOG.TXT").read_text()


def test_attach_refuses_what_would_act_beside_the_brake():
    spec = mj.MjSpec.from_string(falling())
    with pytest.raises(QuantityError, match="stiffness would add to the brake"):
        brakes.attach(spec, "cable", KAPTON)
    spec = mj.MjSpec.from_string(falling(stiffness=None))
    with pytest.raises(UnknownNameError, match="unknown tendon 'rope'"):
        brakes.attach(spec, "rope", KAPTON)
    for wrong in ({"vacuum_lag": 0.0}, {"rest_length": -1.0}):
        with pytest.raises(QuantityError, match=next(iter(wrong))):
            brakes.attach(spec, "cable", KAPTON, **wrong)
    assert len(spec.actuators) == 0


def test_a_model_file_opens_without_a_line_of_code(tmp_path):
    """`import mujoco` finds the plugin through its entry point."""
    about = tmp_path / "layerjam-0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: layerjam\nVersion: 0\n")
    (about / "entry_points.txt").write_text(
        "[mujoco.plugins]\nlayerjam = layerjam.interop.plugin:register\n"
    )
    text = falling(stiffness=None).replace("<mujoco>", '<mujoco><include file="actuator.xml"/>')
    (tmp_path / "brake.xml").write_text(text)
    (tmp_path / "actuator.xml").write_text(brakes.mjcf(KAPTON))
    code = "import mujoco; print(mujoco.MjModel.from_xml_path('brake.xml').npluginstate)"
    places = os.pathsep.join([str(tmp_path), *filter(None, sys.path)])
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": places},
    )
    assert int(done.stdout) == state_bytes("double") // 8 + 7, done.stderr
