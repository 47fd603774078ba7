"""A load held for an hour: what creeps under it and what does not, a table and a picture.

    python -m benchmarks.creep [--figure docs/images/held.svg]

Needs the extras mujoco and figures: `.venv/interop/bin/python` after `make interop`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import mujoco as mj
import numpy as np

from benchmarks.mujoco_coupling import (
    HARDEST,
    ROPE,
    SLIP,
    STIFFNESS,
    scene,
    with_plugin,
)

STEP = 2e-3
EVERY = 500
"""Steps between two samples: one second, ten periods of the shaking."""
GRAVITY = 9.80665
BARE = 131e3
"""Stiffness of choi2018-kapton without a rope [N/m]."""
FRICTION = 175.43
"""c L2 of choi2018-kapton at 94.5 kPa [N]."""
SHAKES = {1.0: 2.0, 16.0: 10.0}
"""{mass [kg]: amplitude of a force of 10 Hz on it [N]}."""
OMEGA = 2 * math.pi * 10
BREAKS_AWAY = 0.9
"""Share of the friction up to which the elastoplastic model is elastic."""
Run = Callable[[float, int], np.ndarray]
"""(mass [kg], seconds) to how far the load has slipped at each second [m]."""


def frictionloss(hardness: str) -> Run:
    """MuJoCo's friction constraint on the mass itself."""

    def run(mass: float, seconds: int) -> np.ndarray:
        joint = f'frictionloss="{FRICTION}" {hardness}'
        model = mj.MjModel.from_xml_string(scene(STEP, joint=joint, mass=mass))
        return _stepped(model, mj.MjData(model), seconds, lambda data: data.qpos[0])

    return run


def in_series(mass: float, seconds: int) -> np.ndarray:
    """The same on a slider of 10 g, with the brake's and the rope's stiffness behind it."""
    text = scene(STEP, cable=f'stiffness="{STIFFNESS!r}"', mass=mass)
    slider = f"""
      <body><joint type="slide" axis="0 0 -1" frictionloss="{FRICTION}" {HARDEST}/>
        <inertial pos="0 0 0" mass="0.01" diaginertia="1e-5 1e-5 1e-5"/>
        <site name="ceiling"/></body>"""
    model = mj.MjModel.from_xml_string(text.replace('<site name="ceiling"/>', slider))
    data = mj.MjData(model)
    data.qpos[1] = mass * GRAVITY / STIFFNESS
    return _stepped(model, data, seconds, lambda data: data.qpos[0])


def still(mass: float, seconds: int) -> np.ndarray:
    """The plugin under the bare weight."""
    model, data = _held(mass)
    return _stepped(model, data, seconds, lambda data: data.plugin_state[SLIP])


def shaken(mass: float, seconds: int, rope: float | None = ROPE) -> np.ndarray:
    """The plugin under the weight and a force of 10 Hz."""
    model, data = _held(mass, rope)
    period = [SHAKES[mass] * math.sin(OMEGA * STEP * i) for i in range(round(0.1 / STEP))]
    rows, applied = [], data.qfrc_applied
    for _ in range(seconds):
        for _ in range(EVERY // len(period)):
            for force in period:
                applied[0] = force
                mj.mj_step(model, data)
        rows.append(data.plugin_state[SLIP])
    return np.array(rows)


def without_rope(mass: float, seconds: int) -> np.ndarray:
    """The same on the brake alone, near whose resonance 10 Hz are under 16 kg."""
    return shaken(mass, seconds, rope=None)


def _held(mass: float, rope: float | None = ROPE) -> tuple[mj.MjModel, mj.MjData]:
    model, data = with_plugin(STEP, "Euler", mass, rope)
    stiffness = STIFFNESS if rope else BARE
    data.qvel[0], data.qpos[0] = 0.0, mass * GRAVITY / stiffness
    return model, data


def _stepped(
    model: mj.MjModel, data: mj.MjData, seconds: int, slip: Callable[[mj.MjData], float]
) -> np.ndarray:
    rows = []
    for _ in range(seconds):
        mj.mj_step(model, data, nstep=EVERY)
        rows.append(slip(data))
    return np.array(rows)


class Bristle(NamedTuple):
    """A mass on a bristle: displacement and deflection [m], velocity [m/s]."""

    displacement: jax.Array
    speed: jax.Array
    deflection: jax.Array


def lugre(speed: jax.Array, deflection: jax.Array) -> jax.Array:
    """Share of the velocity that slides, after LuGre with a constant friction (Dahl)."""
    return deflection * jnp.sign(speed) * STIFFNESS / FRICTION


def elastoplastic(speed: jax.Array, deflection: jax.Array) -> jax.Array:
    """The same after Dupont, Hayward, Armstrong and Altpeter (2002)."""
    most = FRICTION / STIFFNESS
    least, share = BREAKS_AWAY * most, lugre(speed, deflection)
    middle = (jnp.abs(deflection) - (most + least) / 2) / (most - least)
    part = (jnp.sin(jnp.pi * jnp.clip(middle, -0.5, 0.5)) + 1) / 2
    return jnp.where(share > 0, part * share, 0.0)


def bristle(law: Callable[[jax.Array, jax.Array], jax.Array]) -> Run:
    """A friction model of bristles, by MuJoCo's own integrator (semi-implicit Euler)."""

    def run(mass: float, seconds: int) -> np.ndarray:
        def step(i: int, at: Bristle) -> Bristle:
            shake = SHAKES[mass] * jnp.sin(OMEGA * STEP * (i % EVERY))
            pull = GRAVITY + (shake - STIFFNESS * at.deflection) / mass
            speed = at.speed + STEP * pull
            deflection = at.deflection + STEP * speed * (1 - law(speed, at.deflection))
            return Bristle(at.displacement + STEP * speed, speed, deflection)

        def second(at: Bristle, _: None) -> tuple[Bristle, jax.Array]:
            after = jax.lax.fori_loop(0, EVERY, step, at)
            return after, after.displacement - after.deflection

        rest = mass * GRAVITY / STIFFNESS
        start = Bristle(*map(jnp.float64, (rest, 0.0, rest)))
        return np.asarray(jax.jit(lambda s: jax.lax.scan(second, s, None, seconds)[1])(start))

    return run


ROWS: dict[str, Run] = {
    "frictionloss, as MuJoCo sets it": frictionloss(""),
    "frictionloss at its hardest": frictionloss(HARDEST),
    "the same behind a spring": in_series,
    "LuGre, shaken": bristle(lugre),
    "elastoplastic, shaken": bristle(elastoplastic),
    "layerjam.brake": still,
    "layerjam.brake, shaken": shaken,
    "layerjam.brake without rope, shaken": without_rope,
}
DRAWN = [
    name for name in ROWS if name not in ("layerjam.brake", "layerjam.brake without rope, shaken")
]


def metres(slip: float) -> str:
    """A slip with a unit that suits it."""
    for unit, size in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6)):
        if abs(slip) >= size:
            return f"{slip / size:.3g} {unit}"
    return f"{slip:g} m" if slip else "0"


def figure(path: Path, made: dict[str, np.ndarray]) -> None:
    """Slip over an hour, from the first second on."""
    from layerjam.core.drawing import style

    colors = (style.RED, style.ORANGE, style.PURPLE, style.GREEN, style.SKY, style.BLUE)
    with style.apply_style():
        picture, (axes,) = style.make_axes(width=7.2, height=4.4)
        for name, color in zip(DRAWN, colors, strict=True):
            slip, width = np.abs(made[name]) * 1e3, 4 if name.startswith("layerjam") else 1.8
            axes.plot(np.arange(1, len(slip) + 1), slip, color=color, lw=width, clip_on=False)
        words = [f"{name}: {metres(made[name][-1])}" for name in DRAWN]
        style.add_key(axes, *zip(words, colors, strict=True), loc="upper left")
        axes.set_yscale("symlog", linthresh=1e-3, linscale=0.6)
        style.label_axes(
            axes,
            "Only layerjam.brake holds 16 kg for an hour without creep",
            "simulated; the load is 89 % of the friction, shaken by ±10 N at 10 Hz",
            xlabel="time [s]",
            ylabel="slip [mm]",
            xlim=(1, 3600),
            ylim=(0, 2e6),
        )
        ticks = {0: "0", 1e-3: "0.001", 0.1: "0.1", 10: "10", 1e3: "1 000", 1e5: "100 000"}
        axes.set_yticks(list(ticks), list(ticks.values()))
        style.set_log_scale(axes, "x")
        style.save(picture, path, overwrite=True)


def main() -> None:
    """Print the table; with --figure draw it."""
    jax.config.update("jax_enable_x64", True)
    seconds = 3600
    print("slip in an hour".ljust(36), *(f"{mass:g} kg".rjust(12) for mass in SHAKES))
    heavy = {}
    for name, run in ROWS.items():
        slips = {mass: run(mass, seconds) for mass in SHAKES}
        heavy[name] = slips[16.0]
        print(name.ljust(36), *(metres(slip[-1]).rjust(12) for slip in slips.values()))
    if "--figure" in sys.argv:
        figure(Path(sys.argv[sys.argv.index("--figure") + 1]), heavy)


if __name__ == "__main__":
    main()
