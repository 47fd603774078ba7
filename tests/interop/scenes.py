"""MuJoCo models that carry a brake: a falling mass, and an arm with its cable over a drum."""

from __future__ import annotations

ROPE = 16.8e3
"""Stiffness of the rope [N/m]."""
STIFFNESS = 1 / (1 / 131e3 + 1 / ROPE)
"""Of choi2018-kapton and the rope in series [N/m]."""
VACUUM = 94.5e3
EXACT_SLIP = 17.025104387e-3
"""`layerjam drop choi2018-kapton --mass 1kg --speed 2.5m/s --vacuum 94.5kPa
--rope-stiffness 16.8kN/m`, from the closed form [m]."""
EXACT_PEAK = 175.925038


def falling(
    mass: float = 1.0,
    step: float = 5e-4,
    integrator: str = "Euler",
    stiffness: float | None = STIFFNESS,
    cable: str = "",
    top: str = "",
    gravity: float = 9.80665,
) -> str:
    """A mass that hangs on a cable, as MJCF; `stiffness` None for the plugin's cable."""
    spring = "" if stiffness is None else f'stiffness="{stiffness!r}"'
    return f"""
    <mujoco>{top if "<extension" in top else ""}
      <option timestep="{step!r}" integrator="{integrator}" gravity="0 0 {-gravity!r}"/>
      <worldbody>
        <site name="ceiling"/>
        <body name="load" pos="0 0 -0.5">
          <joint name="down" type="slide" axis="0 0 -1"/>
          <inertial pos="0 0 0" mass="{mass!r}" diaginertia="1e-3 1e-3 1e-3"/>
          <site name="load"/>
        </body>
      </worldbody>
      <tendon>
        <spatial name="cable" {spring} {cable}><site site="ceiling"/><site site="load"/></spatial>
      </tendon>
    </mujoco>"""


def arm(step: float = 1e-3, stiffness: float | None = STIFFNESS) -> str:
    """An arm that turns about a drum of 30 mm with a cable laid over it."""
    spring = "" if stiffness is None else f'stiffness="{stiffness!r}"'
    return f"""
    <mujoco>
      <option timestep="{step!r}" gravity="0 0 -9.80665"/>
      <worldbody>
        <site name="anchor" pos="-0.2 0 0.05"/>
        <geom name="drum" type="cylinder" size="0.03 0.02" euler="90 0 0" contype="0"
              conaffinity="0" mass="0"/>
        <site name="side" pos="0 0 0.06"/>
        <body name="forearm">
          <joint name="elbow" axis="0 1 0"/>
          <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="1" contype="0"
                conaffinity="0"/>
          <geom type="sphere" pos="0.3 0 0" size="0.04" mass="1" contype="0" conaffinity="0"/>
          <site name="hand" pos="0.1 0 0.015"/>
        </body>
      </worldbody>
      <tendon>
        <spatial name="cable" {spring}>
          <site site="anchor"/><geom geom="drum" sidesite="side"/><site site="hand"/>
        </spatial>
      </tendon>
    </mujoco>"""
