"""The brake pulled while it is bent over a joint: tension presses the sheets together.

Over an arc of radius R an interface carries the vacuum and the tension C of all layers outside it,
P W + C/R per unit length. Interleaved sheets pull alternately to the left and to the right. C
therefore follows a capstan equation on every interface. It grows by exp(a mu_k phi) on each,
starting with the end value of the next outer interface. All sheets are assumed to have the same
radius (the stack is thin), and the arc to be in the middle of the overlap. Sheets without spacers
also press on each other at the ends of the overlap; this extra friction is not included.
"""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.effects import remove_slip_effects
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.law import keep_if, law


class _Arc(NamedTuple):
    growth: Any
    """a mu_k phi of the part of the overlap that lies on the joint."""
    seed: Any
    """Friction of the outermost interface [N]."""


def _make_arc(slip: Any, vacuum: Any, angle: Any, radius: Any, tension: Any, brake: Brake) -> _Arc:
    sheets = brake.sheets
    overlap = sheets.overlap - slip
    on_joint = xp.minimum(radius * angle, overlap)
    line_load = vacuum * sheets.width + tension / radius
    # a pressure exponent applies at the lowest pressure on the joint
    pressure = xp.where(line_load > 0, line_load, 1.0) / sheets.width
    friction = friction_per_contact(pressure, remove_slip_effects(brake)) / (
        (sheets.count - 1) * sheets.width * pressure
    )
    growth = friction * on_joint / radius
    straight = friction * vacuum * sheets.width * (overlap - on_joint) / 2
    seed = line_load * radius * xp.expm1(growth) + straight * (1 + xp.exp(growth))
    return _Arc(growth, seed)


def _is_valid(slip: Any, vacuum: Any, angle: Any, radius: Any, tension: Any, brake: Brake) -> Any:
    is_inside = (slip >= 0) & (slip <= brake.sheets.overlap) & (vacuum >= 0)
    return is_inside & (angle >= 0) & (radius > 0) & (tension >= 0)


@law
def joint_friction(
    slip: Any, vacuum: Any, angle: Any, radius: Any, tension: Any, brake: Brake
) -> Any:
    """Return kinetic friction [N] of sheets over a joint of a radius [m], bent by an angle [rad].

    The part of the overlap on the joint contributes (P W R + T) (exp((n - 1) a mu_k angle) - 1). T
    is the `tension` [N] of the enclosure's outer face over it. For small angles the sum is (n - 1)
    a mu_k P W times the overlap. The arc covers at most the overlap, which `slip` [m] shortens; the
    vacuum is in Pa. NaN outside the domain.
    """
    arc = _make_arc(slip, vacuum, angle, radius, tension, brake)
    is_bent = arc.growth > 0
    safe = xp.where(is_bent, arc.growth, 1.0)
    interfaces = brake.sheets.count - 1
    times = xp.where(is_bent, xp.expm1(interfaces * safe) / xp.expm1(safe), interfaces)
    return keep_if(_is_valid(slip, vacuum, angle, radius, tension, brake), arc.seed * times)


@law
def joint_sheet_force(
    slip: Any, vacuum: Any, angle: Any, radius: Any, tension: Any, brake: Brake
) -> Any:
    """Return the largest tension [N] of one sheet that slides over a joint; see `joint_friction`.

    It occurs in the second sheet from the inside, which rubs on both faces at the highest pressure.
    If there are only two sheets, each carries the whole force.
    """
    arc = _make_arc(slip, vacuum, angle, radius, tension, brake)
    count = brake.sheets.count
    growth_sum = xp.exp((count - 2) * arc.growth) + xp.exp((count - 3) * arc.growth)
    force = arc.seed * xp.where(count > 2, growth_sum, 1.0)
    return keep_if(_is_valid(slip, vacuum, angle, radius, tension, brake), force)


@law
def capstan_ratio(angle: Any, friction: Any) -> Any:
    """Return the ratio of pulls [-] at the ends of a band that slides on a joint: exp(mu angle).

    `friction` [-] is that of the enclosure on the surface below it, `angle` [rad] the wrap angle.
    """
    return keep_if((angle >= 0) & (friction >= 0), xp.exp(friction * angle))
