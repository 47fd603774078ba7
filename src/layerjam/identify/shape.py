"""The brake with the numbers that fits over curves find."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from layerjam.device.brake import Brake

SHAPE = ("scale_factor", "stiffness", "enclosure_factor")
"""What a single curve's shape depends on; fits take the first two by their logarithms."""


def with_shape(brake: Brake, factor: Any, stiffness: Any, enclosure: Any) -> Brake:
    """The brake with another scale factor, stiffness [N/m] and factor on the enclosure's force.

    Only the product of the enclosure's modulus and friction shows in its force: both are multiplied
    alike, so that the slip from which the whole enclosure moves stays as it was.
    """
    return replace(
        brake,
        scale_factor=factor,
        stiffness_measured=stiffness,
        enclosure=replace(brake.enclosure, modulus=brake.enclosure.modulus * enclosure),
        film=replace(brake.film, friction_on_silicone=brake.film.friction_on_silicone * enclosure),
    )


def plain(brake: Brake) -> Brake:
    """The brake without its pressure exponent, which a fit over curves keeps apart."""
    return replace(brake, pressure_exponent=None, test_pressure=None)
