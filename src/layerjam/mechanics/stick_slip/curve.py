"""Stribeck's curve as a record; the laws that use it need JAX (laws.py)."""

from __future__ import annotations

from layerjam.units import quantity, record


@record
class Stribeck:
    """A friction coefficient over sliding speed; v_s of the paper's films is not measured."""

    static: float = quantity("1", "static friction", hi=10, symbol="mu_s")
    kinetic: float = quantity("1", "kinetic friction", hi=10, symbol="mu_k")
    speed: float = quantity(
        "m/s", "speed over which static friction is lost (0: at once)", hi=100, symbol="v_s"
    )
    exponent: float = quantity(
        "1", "exponent of the loss", lo=0.1, hi=10, symbol="delta", default=1.0
    )
    viscous: float = quantity(
        "s/m", "growth of the coefficient with speed", hi=1e6, symbol="c", default=0.0
    )
