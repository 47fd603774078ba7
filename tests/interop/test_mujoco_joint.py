"""The plugin over a joint: the law of the joint at the angle of the path, and no creep."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="make interop installs MuJoCo")
import mujoco as mj

import layerjam as lj
from layerjam.interop import mujoco as brakes

VACUUM, RADIUS = 94.5e3, 0.06
VACUUM_AT, FORCE, SLIP, ENCLOSURE, MOTION = 1, 2, 3, 6, -3
"""Places in a plugin's state: those of lj_state, and its bytes from the end."""
LIMBS = ('type="cylinder" size="0.06 0.02" euler="90 0 0"', 'type="sphere" size="0.06"')


def over_limb(mass: float, limb: str = LIMBS[0], left: tuple = (-0.2, 0.02), right=(0.2, 0.02)):
    """A load on a cable over a limb; the brake is the cable."""
    text = f"""
    <mujoco>
      <option timestep="0.002"/>
      <worldbody>
        <geom name="limb" {limb} contype="0" conaffinity="0"/>
        <site name="left" pos="{left[0]} 0 {left[1]}"/>
        <site name="over" pos="0 0 0.1"/>
        <body pos="{right[0]} 0 {right[1]}">
          <joint type="slide" axis="0 0 -1" damping="400"/>
          <inertial pos="0 0 0" mass="{mass}" diaginertia="1e-3 1e-3 1e-3"/>
          <site name="load"/>
        </body>
      </worldbody>
      <tendon>
        <spatial name="brake">
          <site site="left"/><geom geom="limb" sidesite="over"/><site site="load"/>
        </spatial>
      </tendon>
    </mujoco>"""
    spec = mj.MjSpec.from_string(text)
    brakes.attach(spec, "brake", "choi2018-kapton", over_joint=True)
    model = spec.compile()
    data = mj.MjData(model)
    data.ctrl[0] = VACUUM
    return model, data


def angle_over_top(left, right):
    """Angle of a thread over the circle, from the tangents at two points."""
    places = np.array([left, right])
    turn = (np.arctan2(places[0, 1], places[0, 0]) - np.arctan2(*places[1, ::-1])) % (2 * np.pi)
    return turn - np.arccos(RADIUS / np.hypot(*places.T)).sum()


@pytest.mark.parametrize("limb", LIMBS)
@pytest.mark.parametrize(("x", "z", "mass"), [(0.2, 0.02, 10.0), (0.03, -0.3, 250.0)])
def test_what_slides_is_held_by_the_law_of_the_joint(limb, x, z, mass):
    """At the angle of the geometry, more than half a turn too, while the vacuum falls."""
    model, data = over_limb(mass, limb, (-x, z), (x, z))
    brake, slides, angles = lj.load("choi2018-kapton").brake, [], []
    for i in range(1000):
        data.ctrl[0] = VACUUM * (1 - max(i - 500, 0) / 1000)
        angle = angle_over_top((-x, z), (x, z - data.qpos[0]))
        mj.mj_step(model, data)
        state = data.plugin_state
        if state[MOTION] == 1 and state[SLIP] < 0.068:
            slides.append(state.copy())
            angles.append(angle)
    vacuum, force, slip, outer = np.array(slides)[:, [VACUUM_AT, FORCE, SLIP, ENCLOSURE]].T
    law = lj.laws.joint_friction(slip, vacuum, np.array(angles), RADIUS, outer / 2, brake)
    assert len(slides) > 30 and np.ptp(slip) > 1e-3
    assert np.max(np.abs(force - outer - np.asarray(law))) < 1e-9


@pytest.mark.parametrize("mass", [4.5, 10.0])
@pytest.mark.parametrize("seconds", [20.0, pytest.param(3600.0, marks=pytest.mark.slow)])
def test_a_load_over_a_joint_does_not_creep(mass, seconds):
    """4.5 kg pull more than the straight brake holds; 10 kg slide until the angle holds them."""
    model, data = over_limb(mass)
    mj.mj_step(model, data, nstep=10_000)
    held = data.plugin_state[SLIP:-8].tobytes()
    mj.mj_step(model, data, nstep=round(seconds / 2e-3))
    assert data.plugin_state[SLIP:-8].tobytes() == held
    assert data.plugin_state[FORCE] > 180 and (data.plugin_state[SLIP] > 0) == (mass > 5)
