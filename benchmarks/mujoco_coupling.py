"""How far a mass slips in MuJoCo beyond the closed form, and what creeps: tables.

    python -m benchmarks.mujoco_coupling

Needs the extra mujoco: `.venv/interop/bin/python` after `make interop`.
"""

from __future__ import annotations

from typing import Any

import mujoco as mj
import numpy as np

from layerjam.brake.commands.drop import drop
from layerjam.interop import mujoco as brakes

KAPTON, ROPE, VACUUM = "choi2018-kapton", 16.8e3, 94.5e3
STIFFNESS = 1 / (1 / 131e3 + 1 / ROPE)
STEPS = (2e-3, 1e-3, 5e-4, 1e-4)
SLIP = 3
"""Place of the slip in a plugin's state."""
HARDEST = 'solreffriction=".002 1" solimpfriction=".9999 .9999 .001 .5 2"'


def scene(step: float, cable: str = "", joint: str = "", integrator: str = "Euler", mass=1.0):
    """A mass on a cable below a ceiling."""
    return f"""
    <mujoco>
      <option timestep="{step!r}" integrator="{integrator}" gravity="0 0 -9.80665"/>
      <worldbody>
        <site name="ceiling"/>
        <body pos="0 0 -0.5">
          <joint type="slide" axis="0 0 -1" {joint}/>
          <inertial pos="0 0 0" mass="{mass!r}" diaginertia="1e-3 1e-3 1e-3"/>
          <site name="load"/>
        </body>
      </worldbody>
      <tendon>
        <spatial name="cable" {cable}><site site="ceiling"/><site site="load"/></spatial>
      </tendon>
    </mujoco>"""


def with_helper(step: float, coupling: Any = "limited") -> tuple[np.ndarray, np.ndarray]:
    """Time [s] and slip [m] of the drop."""
    model = mj.MjModel.from_xml_string(scene(step, cable=f'stiffness="{STIFFNESS!r}"'))
    data = mj.MjData(model)
    brake = brakes.Brake(model, "cable", KAPTON, rope_stiffness=ROPE, coupling=coupling)
    data.qvel[0], rows = 2.5, []
    for _ in range(round(0.04 / step)):
        time = data.time
        brake.before_step(data, VACUUM)
        mj.mj_step(model, data)
        rows.append((time, brake.slip))
    return tuple(np.array(rows).T)


def with_plugin(
    step: float, integrator: str, mass: float = 1.0, rope: float | None = ROPE
) -> tuple[Any, Any]:
    """Model and data of the drop; `rope` [N/m], None for the brake alone."""
    spec = mj.MjSpec.from_string(scene(step, integrator=integrator, mass=mass))
    brakes.attach(spec, "cable", KAPTON, rope_stiffness=rope)
    model = spec.compile()
    data = mj.MjData(model)
    data.qvel[0], data.ctrl[0] = 2.5, VACUUM
    return model, data


def errors(exact: float) -> None:
    """The table of slips."""
    print("slip beyond the closed form [µm]".ljust(34), *(f"{1e3 * s:>7g} ms" for s in STEPS))
    for coupling in ("limited", "implicit"):
        found = [with_helper(step, coupling)[1][-1] for step in STEPS]
        line(f"helper, {coupling}", found, exact)
    for integrator in ("Euler", "implicitfast", "discrete", "RK4"):
        found = []
        for step in STEPS:
            model, data = with_plugin(step, integrator)
            mj.mj_step(model, data, nstep=round(0.04 / step))
            found.append(data.plugin_state[SLIP])
        line(f"plugin, {integrator}", found, exact)


def line(name: str, found: list[float], exact: float) -> None:
    """One row."""
    print(name.ljust(34), *(f"{1e6 * (slip - exact):+10.2f}" for slip in found))


def held(seconds: float, every: int = 500) -> dict[str, np.ndarray]:
    """{name: displacement [m]} of 16 kg held for a time at 2 ms, one sample a second."""
    made, mass, step = {}, 16.0, 2e-3
    spec_model, data = with_plugin(step, "Euler", mass)
    data.qvel[0], data.qpos[0] = 0.0, mass * 9.80665 / STIFFNESS
    found = {"brake": (spec_model, data)}
    for name, more in (("frictionloss", ""), ("frictionloss, hardest", HARDEST)):
        joint = f'frictionloss="175.43" {more}'
        model = mj.MjModel.from_xml_string(scene(step, joint=joint, mass=mass))
        found[name] = (model, mj.MjData(model))
    for name, (model, each) in found.items():
        rows = []
        for _ in range(round(seconds / step / every)):
            mj.mj_step(model, each, nstep=every)
            rows.append(each.qpos[0])
        made[name] = np.array(rows) - rows[0]
    return made


def main() -> None:
    """Print the tables."""
    exact = drop(KAPTON, mass=1.0, speed=2.5, vacuum=VACUUM, rope_stiffness=ROPE)
    errors(float(exact.slip))
    for name, moved in held(60.0).items():
        print(f"{name.ljust(34)} {1e6 * moved[-1]:.6g} µm in a minute under 16 kg")


if __name__ == "__main__":
    main()
