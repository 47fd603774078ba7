"""Friction of the sheets as a function of their sliding speed."""

from layerjam.core.conversion import Quantity
from layerjam.core.units import quantity, record


@record
class SpeedLaw:
    """Ratio of friction at a speed v to friction at `test_speed`: ((v_0 + v)/(v_0 + v_test))^n.

    It is an empirical law for one pair of surfaces; n = 1 is the linear growth of the Stribeck
    curve. The film's kinetic friction and the scale factor apply at `test_speed`.
    """

    power: Quantity[float] = quantity(
        "1", "exponent of the sliding speed in the friction law", lo=0, hi=1, symbol="n"
    )
    test_speed: Quantity[float] = quantity(
        "m/s", "sliding speed at which the friction was measured", hi=100, symbol="v_test"
    )
    rest_speed: Quantity[float] = quantity(
        "m/s", "speed far below which friction no longer changes", lo=1e-7, hi=10, symbol="v_0"
    )
    fastest: Quantity[float | None] = quantity(
        "m/s", "highest sliding speed of the measurement", lo=1e-7, hi=1000, default=None
    )
