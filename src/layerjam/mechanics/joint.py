"""The brake bent over a joint while it is pulled: tension presses the sheets together.

Over an arc of radius R an interface bears the vacuum and the tension C of all that lies outside it,
P W + C/R per length. Interleaved sheets pull by turns to the left and to the right, so that C
follows a capstan of its own on every interface, grows by exp(a mu_k phi) on each, and starts there
from where the one outside it ended. Radii of all sheets are taken as one (the stack is thin), and
the arc as lying in the middle of the overlap. Sheets without spacers press on each other where they
leave the overlap too; that only adds, and is left out.
"""

from typing import Any, NamedTuple

import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.fan import flat
from layerjam.mechanics.friction import friction_per_contact
from layerjam.mechanics.law import law, within


class _Arc(NamedTuple):
    growth: Any
    """a mu_k phi of the part of the overlap that lies on the joint."""
    seed: Any
    """Friction of the outermost interface [N]."""


def _arc(slip: Any, vacuum: Any, angle: Any, radius: Any, tension: Any, brake: Brake) -> _Arc:
    sheets = brake.sheets
    overlap = sheets.overlap - slip
    on_joint = jnp.minimum(radius * angle, overlap)
    pressed = vacuum * sheets.width + tension / radius
    # an exponent of the pressure counts at the least pressure on the joint
    at = jnp.where(pressed > 0, pressed, 1.0) / sheets.width
    friction = friction_per_contact(at, flat(brake)) / ((sheets.count - 1) * sheets.width * at)
    growth = friction * on_joint / radius
    straight = friction * vacuum * sheets.width * (overlap - on_joint) / 2
    seed = pressed * radius * jnp.expm1(growth) + straight * (1 + jnp.exp(growth))
    return _Arc(growth, seed)


def _fine(slip: Any, vacuum: Any, angle: Any, radius: Any, tension: Any, brake: Brake) -> Any:
    inside = (slip >= 0) & (slip <= brake.sheets.overlap) & (vacuum >= 0)
    return inside & (angle >= 0) & (radius > 0) & (tension >= 0)


@law
def joint_friction(
    slip: Any, vacuum: Any, angle: Any, radius: Any, tension: Any, brake: Brake
) -> Any:
    """Kinetic friction [N] of the sheets over a joint of a radius [m], bent by an angle [rad].

    (P W R + T) (exp((n - 1) a mu_k angle) - 1) where the overlap lies on the joint, with T the
    `tension` [N] of what covers it outside: an enclosure's outer face. (n - 1) a mu_k P W times the
    overlap for small angles. The arc covers at most the overlap, `slip` [m] shortens that; vacuum
    [Pa]. NaN outside the domain.
    """
    arc = _arc(slip, vacuum, angle, radius, tension, brake)
    bent = arc.growth > 0
    one = jnp.where(bent, arc.growth, 1.0)
    interfaces = brake.sheets.count - 1
    times = jnp.where(bent, jnp.expm1(interfaces * one) / jnp.expm1(one), interfaces)
    return within(_fine(slip, vacuum, angle, radius, tension, brake), arc.seed * times)


@law
def joint_sheet_force(
    slip: Any, vacuum: Any, angle: Any, radius: Any, tension: Any, brake: Brake
) -> Any:
    """Greatest tension [N] of one sheet while it slides over a joint; as `joint_friction`.

    That of the last sheet but the innermost, which rubs on both faces where the pressure is
    highest; of two sheets each bears all.
    """
    arc = _arc(slip, vacuum, angle, radius, tension, brake)
    count = brake.sheets.count
    both = jnp.exp((count - 2) * arc.growth) + jnp.exp((count - 3) * arc.growth)
    force = arc.seed * jnp.where(count > 2, both, 1.0)
    return within(_fine(slip, vacuum, angle, radius, tension, brake), force)


@law
def capstan_ratio(angle: Any, friction: Any) -> Any:
    """Pull at one end over that at the other [-]: exp(mu angle) of a band that slides on a joint.

    `friction` [-] is that of the enclosure on what it lies on, `angle` [rad] the wrap.
    """
    return within((angle >= 0) & (friction >= 0), jnp.exp(friction * angle))
