"""The brake bent over a joint while it is pulled: tension presses the sheets together.

Over an arc of radius R an interface carries the vacuum and the tension C of all layers outside it,
P W + C/R per length. Interleaved sheets pull alternately to the left and to the right. So C follows
a separate capstan equation on every interface, grows by exp(a mu_k phi) on each, and starts with
the end value of the interface outside. All sheets are assumed to have one radius (the stack is
thin), and the arc to lie in the middle of the overlap. Sheets without spacers also press on each
other at the ends of the overlap; this would add to the friction and is not included.
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
    line_load = vacuum * sheets.width + tension / radius
    # a pressure exponent is applied at the lowest pressure on the joint
    pressure = jnp.where(line_load > 0, line_load, 1.0) / sheets.width
    friction = friction_per_contact(pressure, flat(brake)) / (
        (sheets.count - 1) * sheets.width * pressure
    )
    growth = friction * on_joint / radius
    straight = friction * vacuum * sheets.width * (overlap - on_joint) / 2
    seed = line_load * radius * jnp.expm1(growth) + straight * (1 + jnp.exp(growth))
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
    `tension` [N] of the enclosure's outer face, which covers it. (n - 1) a mu_k P W times the
    overlap for small angles. The arc covers at most the overlap, `slip` [m] shortens that; vacuum
    [Pa]. NaN outside the domain.
    """
    arc = _arc(slip, vacuum, angle, radius, tension, brake)
    is_bent = arc.growth > 0
    safe = jnp.where(is_bent, arc.growth, 1.0)
    interfaces = brake.sheets.count - 1
    times = jnp.where(is_bent, jnp.expm1(interfaces * safe) / jnp.expm1(safe), interfaces)
    return within(_fine(slip, vacuum, angle, radius, tension, brake), arc.seed * times)


@law
def joint_sheet_force(
    slip: Any, vacuum: Any, angle: Any, radius: Any, tension: Any, brake: Brake
) -> Any:
    """Greatest tension [N] of one sheet while it slides over a joint; as `joint_friction`.

    It occurs in the second sheet from the inside: it rubs on both faces where the pressure is
    highest. If there are two sheets, each carries the whole force.
    """
    arc = _arc(slip, vacuum, angle, radius, tension, brake)
    count = brake.sheets.count
    both = jnp.exp((count - 2) * arc.growth) + jnp.exp((count - 3) * arc.growth)
    force = arc.seed * jnp.where(count > 2, both, 1.0)
    return within(_fine(slip, vacuum, angle, radius, tension, brake), force)


@law
def capstan_ratio(angle: Any, friction: Any) -> Any:
    """Pull at one end over that at the other [-]: exp(mu angle) of a band that slides on a joint.

    `friction` [-] is that of the enclosure on the surface below it, `angle` [rad] the wrap.
    """
    return within((angle >= 0) & (friction >= 0), jnp.exp(friction * angle))
