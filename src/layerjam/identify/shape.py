"""The brake as a fit takes it: with the numbers found, with the friction at the speed of a pull."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from layerjam.device.brake import Brake
from layerjam.errors import FitError
from layerjam.mechanics.friction import at_speed, growth_of
from layerjam.simulate.speed import follows_speed

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


def growth_in(brake: Brake, speed: float | None, path: str) -> float:
    """Friction at a crosshead's speed [m/s] over that at the law's test speed; 1 without a law.

    Raises FitError where the brake has a law and the pull tells no speed.
    """
    if not follows_speed(brake):
        return 1.0
    if speed is None:
        raise FitError.of(
            path,
            "tells no speed and has no time, and the friction of this brake depends on it "
            "([speed_law]); name the speed in a sidecar, or use the brake without that table",
        )
    return float(growth_of(speed, brake))


def as_pulled(brake: Brake, speed: float | None, path: str) -> Brake:
    """The brake with the friction that it has at a crosshead's speed [m/s]; raises as `growth_in`.

    A scale factor that is fitted with it is that at the law's test speed.
    """
    growth_in(brake, speed, path)
    return brake if speed is None else at_speed(speed, brake)
