"""The drop in diffrax: one jitted, vmapped solve in double precision, ended by an event.

State: way z and speed v of the mass, as for SciPy; stuck and sliding are one force over z, whose
kink at the onset the step control resolves.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import optimistix

from benchmarks.comparators.drops import Drops, Force

LONGEST = 2.0
"""Seconds after which a drop must have ended."""
LONGEST_STEP = 4e-3
"""[s] A longer one can pass a standstill and come back behind it, unseen by the event."""
STEPS = 1000
"""At most, a drop."""
TOLERANCE = {1e-6: 1e-8, 1e-8: 1e-11}
"""Per accuracy [m]: the loosest power of ten as rtol with which no travel is further off."""


def slip_at(z: Any, force: Force, spring: Any) -> Any:
    """Slip [m] of the brake with the mass at z [m]; 0 until the onset."""
    over = jnp.maximum(z - force.onset / spring, 0.0)
    a, b = 1 - force.c / spring, force.root / spring
    w = 2 * over / (b + jnp.sqrt(b * b + 4 * a * over))
    slope = 1 + (force.rise - force.c) / spring
    whole = (over - force.step / spring) / slope
    return jnp.where(w * w < force.saturation, w * w, whole)


def _one(
    mass: Any, speed: Any, force: Force, spring: Any, gravity: Any, travel: Any, rtol: Any
) -> Any:
    """Slip at the end of one drop [m]."""

    def field(t: Any, y: Any, args: Any) -> Any:
        z, v = y
        return v, gravity - spring * (z - slip_at(z, force, spring)) / mass

    def standstill(t: Any, y: Any, args: Any, **_: Any) -> Any:
        return y[1]

    def used_up(t: Any, y: Any, args: Any, **_: Any) -> Any:
        return slip_at(y[0], force, spring) - travel

    finder = optimistix.Newton(1e-12, 1e-12)
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(field), diffrax.Tsit5(), 0.0, LONGEST, None, (0.0 * speed, speed),
        stepsize_controller=diffrax.PIDController(rtol=rtol, atol=rtol * 1e-2, dtmax=LONGEST_STEP),
        event=diffrax.Event((standstill, used_up), finder), adjoint=diffrax.ForwardMode(),
        saveat=diffrax.SaveAt(t1=True), max_steps=STEPS, throw=False,
    )  # fmt: skip
    return slip_at(solution.ys[0][-1], force, spring)


_all = jax.jit(jax.vmap(_one, in_axes=(0, 0, 0, None, None, None, None)))


def prepare(drops: Drops, rtol: float) -> Callable[[], Any]:
    """A call that gives the drops' travel [m], all in one batch; NaN for one without an end."""
    arrays = jax.tree.map(jnp.asarray, (drops.mass, drops.speed, drops.force))

    def run() -> Any:
        out = _all(*arrays, drops.spring, drops.gravity, drops.travel, rtol)
        return jax.block_until_ready(out)

    return run
