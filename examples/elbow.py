"""A brake over an elbow, as a Gymnasium environment: let the hand down, and stop it where wanted.

A forearm with something in its hand falls from the horizontal. The action is the vacuum that the
brake over the elbow is asked for, fifty times a second; the line follows within some hundredths of
a second. A brake cannot lift: whoever lets the arm fall too far has lost. What is in the hand is
not told.

    pip install ".[mujoco]" gymnasium
"""

from __future__ import annotations

from typing import Any

import gymnasium
import mujoco
import numpy as np

from layerjam.interop.mujoco import attach

FOREARM, REACH, DRUM = 1.2, 0.30, 0.03
"""Mass of the forearm [kg], from elbow to hand and from the elbow's axis to the brake [m]."""
TISSUE = 0.3
"""Damping of a relaxed elbow [N m s/rad], of the order that is reported for it."""
LOADS, TARGETS, SPEEDS = (0.3, 0.7), (20.0, 45.0), (0.0, 1.5)
"""In the hand [kg], where to stop [degrees below the horizontal], speed at first [rad/s]."""
FULL, LAG = 94.5e3, 0.03
"""Greatest vacuum [Pa] and time constant of the line, one with a reservoir [s]."""
STEP, EVERY, STEPS = 1e-3, 20, 60
"""Time step of the engine [s], its steps for each action, actions of an episode."""

MODEL = f"""
<mujoco>
  <option timestep="{STEP}" gravity="0 0 -9.80665"/>
  <worldbody>
    <site name="upper arm" pos="-0.25 0 {DRUM}"/>
    <geom name="drum" type="cylinder" size="{DRUM} 0.02" euler="90 0 0"
          contype="0" conaffinity="0"/>
    <site name="side" pos="0 0 0.06"/>
    <body name="forearm">
      <joint name="elbow" axis="0 1 0" range="0 80" limited="true" damping="{TISSUE}"/>
      <geom type="capsule" fromto="0 0 0 {REACH} 0 0" size="0.03" mass="{FOREARM}"
            contype="0" conaffinity="0"/>
      <site name="wrist" pos="0.12 0 {DRUM}"/>
      <body name="load" pos="{REACH} 0 0">
        <geom type="sphere" size="0.04" mass="1" contype="0" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
  <tendon>
    <spatial name="brake">
      <site site="upper arm"/><geom geom="drum" sidesite="side"/><site site="wrist"/>
    </spatial>
  </tendon>
</mujoco>"""


def model(brake: str = "choi2018-kapton", lag: float = LAG) -> mujoco.MjModel:
    """The arm with a brake of layerjam over its elbow; its control is the vacuum [Pa]."""
    spec = mujoco.MjSpec.from_string(MODEL)
    attach(spec, "brake", brake, vacuum_lag=lag)
    return spec.compile()


class Elbow(gymnasium.Env):
    """Observed: angle and target [rad], speed [rad/s], vacuum as a share of the greatest one."""

    def __init__(self, brake: str = "choi2018-kapton") -> None:
        self.model, self.load = model(brake), 1.0
        self.data = mujoco.MjData(self.model)
        self.hand = self.model.body("load").id
        self.inertia = self.model.body_inertia[self.hand].copy()
        self.observation_space = gymnasium.spaces.Box(
            np.array([-1.0, 0.0, -40.0, 0.0]), np.array([2.0, 1.0, 40.0, 1.0]), dtype=np.float64
        )
        self.action_space = gymnasium.spaces.Box(0.0, 1.0, (1,), np.float64)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[np.ndarray, dict]:
        """A new load, target and speed, drawn from their ranges."""
        super().reset(seed=seed)
        self.load = self.np_random.uniform(*LOADS)
        self.target = np.radians(self.np_random.uniform(*TARGETS))
        self.model.body_mass[self.hand] = self.load
        self.model.body_inertia[self.hand] = self.inertia * self.load
        mujoco.mj_setConst(self.model, self.data)
        mujoco.mj_resetData(self.model, self.data)
        self.data.qvel[0] = self.np_random.uniform(*SPEEDS)
        self.done = 0
        return self._seen(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict]:
        """A fiftieth of a second; the reward is minus the distance from the target [rad]."""
        self.data.ctrl[0] = FULL * float(np.clip(action[0], 0.0, 1.0))
        mujoco.mj_step(self.model, self.data, nstep=EVERY)
        self.done += 1
        away = abs(self.data.qpos[0] - self.target)
        return self._seen(), -away, False, self.done >= STEPS, {}

    def _seen(self) -> np.ndarray:
        share = self.data.act[0] / FULL
        return np.array([self.data.qpos[0], self.target, self.data.qvel[0], share])
