"""Stribeck's curve as a record; the laws that use it need JAX (laws.py)."""

from layerjam.core.conversion import Quantity
from layerjam.core.units import quantity, record


@record
class Stribeck:
    """A friction coefficient versus sliding speed; v_s of the paper's films was not measured."""

    static: Quantity[float] = quantity("1", "static friction", hi=10, symbol="mu_s")
    kinetic: Quantity[float] = quantity("1", "kinetic friction", hi=10, symbol="mu_k")
    speed: Quantity[float] = quantity(
        "m/s", "speed at which static friction decays (0: at once)", hi=100, symbol="v_s"
    )
    exponent: Quantity[float] = quantity(
        "1", "exponent of the decay", lo=0.1, hi=10, symbol="delta", default=1.0
    )
    viscous: Quantity[float] = quantity(
        "s/m", "viscous growth of friction with speed", hi=1e6, symbol="c", default=0.0
    )
