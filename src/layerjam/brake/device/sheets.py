"""The interleaved sheets and the film from which they are cut."""

from layerjam.core.conversion import Quantity
from layerjam.core.units import quantity, record


@record
class Sheets:
    """Geometry of the stack (paper, section II-A)."""

    count: Quantity[int] = quantity(
        "1", "total number of interleaved sheets", lo=2, hi=10000, symbol="n", whole=True
    )
    width: Quantity[float] = quantity("m", "sheet width", lo=1e-3, hi=0.5, symbol="W")
    thickness: Quantity[float] = quantity(
        "m", "thickness of one sheet", lo=1e-6, hi=0.01, symbol="t"
    )
    length: Quantity[float] = quantity(
        "m", "full length of one sheet, including its clamped part", lo=1e-3, hi=5
    )
    overlap: Quantity[float] = quantity("m", "overlap at rest", lo=1e-3, hi=5, symbol="L2")
    free_left: Quantity[float] = quantity(
        "m", "length of the left sheets between cap and overlap", lo=1e-4, hi=5, symbol="L1"
    )
    free_right: Quantity[float] = quantity(
        "m", "length of the right sheets between cap and overlap", lo=1e-4, hi=5, symbol="L3"
    )
    usable_travel: Quantity[float] = quantity("m", "usable slip of the brake", lo=1e-4, hi=5)


@record
class Film:
    """The sheets' material and its friction against itself and against the enclosure."""

    modulus: Quantity[float] = quantity(
        "Pa", "tensile modulus of the film", lo=1e6, hi=1e12, symbol="E"
    )
    density: Quantity[float] = quantity(
        "kg/m^3", "density of the film", lo=100, hi=25000, symbol="rho"
    )
    static: Quantity[float] = quantity(
        "1", "coefficient of static friction of the film on itself", lo=1e-4, hi=5, symbol="mu_s"
    )
    kinetic: Quantity[float] = quantity(
        "1", "coefficient of kinetic friction of the film on itself", lo=1e-4, hi=5, symbol="mu_k"
    )
    friction_on_silicone: Quantity[float] = quantity(
        "1", "friction coefficient between film and enclosure", lo=1e-4, hi=5, symbol="mu_e"
    )
    ageing: Quantity[float | None] = quantity(
        "1", "increase in static friction per decade of hold time", lo=-1, hi=1, default=None
    )
    static_hold: Quantity[float | None] = quantity(
        "s",
        "hold time under load after which static friction is film.static",
        lo=1e-3,
        hi=1e8,
        default=None,
    )
    strength: Quantity[float | None] = quantity(
        "Pa", "yield stress of the film", lo=1e5, hi=1e11, default=None
    )
    specific_heat: Quantity[float | None] = quantity(
        "J/(kg K)", "specific heat of the film", lo=50, hi=10000, default=None
    )
