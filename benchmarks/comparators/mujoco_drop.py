"""The drop in MuJoCo: a slider with friction loss, set anew before each step, and a spring.

The brake is a light body on a slide joint whose friction loss is the brake's force at its slip;
the mass hangs on it by a second slide joint with the spring of rope and brake. Two things keep it
from the exact answer. MuJoCo wants a mass for the slider, where the brake has none: it rings on
the spring and adds some newtons to the peak. And friction is a soft constraint that creeps: with
MuJoCo's defaults the travel is wrong by centimetres. Here it is as hard as MuJoCo allows.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import mujoco
import numpy as np

from benchmarks.comparators.drops import Answer, Drops

STEP = 2e-5
"""Time step [s]; a fifth of it costs five times as much and makes the travel twice as exact."""
SLIDER = 1e-4
"""Mass of the slider [kg]; less of it creeps more, more of it rings more."""
_MODEL = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -{gravity}" integrator="implicitfast">
    <flag contact="disable"/>
  </option>
  <worldbody>
    <body>
      <inertial pos="0 0 0" mass="{slider}" diaginertia="1 1 1"/>
      <joint type="slide" axis="0 0 -1" frictionloss="1"
             solreffriction="{hard} 1" solimpfriction="0.9999 0.9999 0.001 0.5 2"/>
      <body name="mass">
        <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <joint type="slide" axis="0 0 -1" stiffness="{spring}"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def _one(
    model: mujoco.MjModel, data: mujoco.MjData, speed: float, force: tuple[float, ...],
    spring: float, travel: float,
) -> tuple[float, float]:  # fmt: skip
    """Slip [m] at the end of one drop, between two steps by interpolation, and peak force [N]."""
    c, onset, root, saturation, step, rise = force
    loss, place, rate = model.dof_frictionloss, data.qpos, data.qvel
    mujoco.mj_resetData(model, data)
    rate[1] = pace = speed
    slip = peak = 0.0
    while True:
        x = slip if slip > 0 else 0.0
        loss[0] = onset - c * x + (root * sqrt(x) if x < saturation else step + rise * x)
        mujoco.mj_step(model, data)
        before, slip, last, pace = slip, float(place[0]), pace, float(rate[0] + rate[1])
        peak = max(peak, spring * place[1])
        if slip >= travel:
            return travel, peak
        if pace <= 0:
            return before + (slip - before) * last / (last - pace), peak


def prepare(drops: Drops, step: float = STEP, slider: float = SLIDER) -> Callable[[], Answer]:
    """A call that gives each drop's travel and peak force, one after the other."""
    text = _MODEL.format(
        step=step, gravity=drops.gravity, slider=slider, hard=2 * step, spring=drops.spring
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    forces = np.stack(drops.force, axis=1).tolist()
    cases = list(zip(drops.mass.tolist(), drops.speed.tolist(), map(tuple, forces), strict=True))

    def run() -> Answer:
        out = []
        for mass, speed, force in cases:
            model.body("mass").mass[0] = mass
            mujoco.mj_setConst(model, data)
            out.append(_one(model, data, speed, force, drops.spring, drops.travel))
        travel, peak = np.array(out).T
        return Answer(travel, peak)

    return run
