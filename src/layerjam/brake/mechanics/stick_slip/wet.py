"""Wet sheets: a Stribeck law with adhesion and a viscous part (ours; paper, section III-B, Fig. 6).

A film of water between the sheets changes the shear stress of an interface in three ways. The
Coulomb part follows a Stribeck curve (the water is squeezed out at rest and carries load at speed).
Menisci pull the sheets together without vacuum (adhesion). The film is sheared (viscous part):

    tau(v, P) = a mu(v) P + tau_0 + b v.

All three must be fitted to data of wet sheets (see `identify.friction.stribeck`). Dry sheets follow
the same law with a flat curve and neither of the other two parts.
"""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.effects import list_shapes, pressure_on_sheets
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.law import keep_if, law
from layerjam.brake.mechanics.stick_slip.laws import static_fraction
from layerjam.core.units import quantity, record


@record
class WetFilm:
    """Friction parameters of a wet interface."""

    static: float = quantity("1", "wet static friction", hi=10, symbol="mu_s")
    kinetic: float = quantity("1", "wet kinetic friction at high speed", hi=10, symbol="mu_k")
    speed: float = quantity(
        "m/s", "speed scale at which the water begins to carry load", hi=100, symbol="v_s"
    )
    exponent: float = quantity(
        "1", "exponent of the Stribeck curve", lo=0.1, hi=10, symbol="delta", default=1.0
    )
    adhesion: float = quantity("Pa", "shear stress at zero vacuum", hi=1e6, symbol="tau_0")
    viscosity: float = quantity(
        "Pa s/m", "ratio of the water's viscosity to its film thickness", hi=1e9, symbol="b"
    )


ILLUSTRATIVE = WetFilm(
    static=0.30, kinetic=0.17, speed=8e-3, exponent=1.0, adhesion=1.2e3, viscosity=2e4
)
"""Kapton in water, ILLUSTRATIVE: chosen so that the curves behave as described in the paper's text
on Fig. 6, with the wet peak below the dry one at 25 mm/s ("conversely"). Not measured, not fitted.
"""
ILLUSTRATIVE_VISCOUS = WetFilm(
    static=0.30, kinetic=0.24, speed=8e-3, exponent=1.0, adhesion=1.2e3, viscosity=1.2e5
)
"""The same with the wet peak above the dry one at 25 mm/s, the other interpretation of the paper's
sentence. ILLUSTRATIVE: not measured, not fitted.
"""


@law
def wet_stress(speed: Any, vacuum: Any, film: WetFilm, scale_factor: Any) -> Any:
    """Return the shear stress of one wet interface [Pa]; speed [m/s] and vacuum [Pa] broadcast.

    `scale_factor` multiplies the Coulomb part alone, because the adhesion and the viscous part are
    fitted to the brake itself. At rest the result is the stress at which the interface begins to
    slip. NaN for a negative speed or vacuum.
    """
    static_share = static_fraction(speed, film.speed, film.exponent)
    friction = film.kinetic + (film.static - film.kinetic) * static_share
    stress = scale_factor * friction * vacuum + film.adhesion + film.viscosity * speed
    return keep_if((speed >= 0) & (vacuum >= 0), stress)


@law
def wet_force(slip: Any, speed: Any, vacuum: Any, brake: Brake, film: WetFilm) -> Any:
    """Return the force of the wet brake sliding at a speed [N]; slip [m], speed [m/s], vacuum [Pa].

    It is (n - 1) W (L2 - x) tau plus the force of the enclosure, which is assumed dry. The
    arguments broadcast. A fitted pressure exponent of the brake scales the Coulomb part. NaN for a
    negative slip, speed or vacuum.
    """
    sheets = brake.sheets
    contact = (sheets.count - 1) * sheets.width * xp.maximum(sheets.overlap - slip, 0.0)
    jammed = vacuum > 0
    coulomb = friction_per_contact(xp.where(jammed, vacuum, 1.0), brake)
    coulomb = coulomb / ((sheets.count - 1) * sheets.width * brake.film.kinetic)
    factor = coulomb / xp.where(jammed, vacuum, 1.0)
    stress = wet_stress(speed, vacuum, film, factor)
    force = contact * stress
    for shape in list_shapes(1.0, brake):
        # the self-amplification acts on any shear stress; its friction coefficient is the ratio of
        # stress to pressure
        share = stress / pressure_on_sheets(xp.where(jammed, vacuum, 1.0), brake)
        share = share / (brake.scale_factor * brake.film.kinetic)
        force = force * shape.scale(share).factor(slip)
    force = force + enclosure_law(vacuum, brake).force(slip)
    return keep_if((slip >= 0) & (speed >= 0) & (vacuum >= 0), force)
