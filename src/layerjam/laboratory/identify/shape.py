"""A brake with the parameters that a fit to curves varies."""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.core.evolve import evolve

SHAPE = ("scale_factor", "stiffness", "enclosure_factor")
"""Parameters that set the shape of a curve; fits use the logarithms of the first two."""


def change_shape(brake: Brake, factor: Any, stiffness: Any, enclosure: Any) -> Brake:
    """Return the brake with a scale factor, stiffness [N/m] and enclosure factor.

    A force determines only the product of the enclosure's modulus and friction. Both are multiplied
    by the same factor, so the slip at which the whole enclosure moves does not change.
    """
    return evolve(
        brake,
        scale_factor=factor,
        stiffness_measured=stiffness,
        enclosure=evolve(brake.enclosure, modulus=brake.enclosure.modulus * enclosure),
        film=evolve(brake.film, friction_on_silicone=brake.film.friction_on_silicone * enclosure),
    )


def keep_fitted_law(brake: Brake) -> Brake:
    """Return the brake with only what the law of a fit reads, so that one program fits them all.

    The fit's own parameters replace the stiffness, and the growth with speed is part of their
    start. The amplification counts only where the spacers are known.
    """
    return evolve(
        drop_exponent(brake),
        stiffness_measured=1.0,
        amplification_held=None if brake.mount.spacers is None else brake.amplification_held,
        speed_law=None,
        lowest_pressure=None,
        enclosure=evolve(brake.enclosure, force_uncertainty=None),
    )


def drop_exponent(brake: Brake) -> Brake:
    """Return the brake without its pressure exponent, which fits to curves treat separately."""
    return evolve(brake, pressure_exponent=None, test_pressure=None)
