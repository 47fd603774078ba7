"""Heat of a stop in the sheets: temperature rise, and allowed stops per minute.

The rise is adiabatic: a stop lasts tens of milliseconds, but heat takes about ten seconds through
stack and enclosure, so it stays where it is generated. All of it is assigned to the sheets, even
the part that warms the enclosure, so the mean is slightly high. Between stops the enclosure
releases the heat to the air.

Neither wear of the film nor the effects of wear and temperature on friction are modelled.
"""

from typing import Any

from layerjam.brake.device.brake import Brake, sheet_mass
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.friction import friction_per_contact, sheet_law
from layerjam.brake.mechanics.law import keep_if, law


def _specific_heat(brake: Brake) -> Any:
    """Return the specific heat of the film [J/(kg K)]; NaN if the brake does not state it."""
    value = brake.film.specific_heat
    return xp.nan if value is None else value


def rubbing_mass(brake: Brake) -> Any:
    """Return the mass of film in the overlap at rest [kg], over all sheets: the part that rubs."""
    return brake.sheets.count * sheet_mass(brake) * brake.sheets.overlap / brake.sheets.length


def outer_area(brake: Brake) -> Any:
    """Return the outer surface of the enclosure from cap to cap at rest [m^2], without the ends."""
    sheets, wall = brake.sheets, brake.enclosure.wall
    around = 2 * (sheets.width + sheets.count * sheets.thickness) + 8 * wall
    return around * (sheets.free_left + sheets.overlap + sheets.free_right)


@law
def temperature_rise(heat: Any, brake: Brake) -> Any:
    """Return the mean rise [K] of the sheets' rubbing part (the overlap at rest) due to a heat [J].

    It solves m c dT = heat. NaN for negative heat, or if the film's specific heat is unknown.
    """
    capacity = rubbing_mass(brake) * _specific_heat(brake)
    return keep_if(heat >= 0, heat / capacity)


@law
def temperature_rise_of_sheets(heat: Any, brake: Brake) -> Any:
    """Return the mean rise [K] of whole sheets, with clamped and free parts, due to a heat [J].

    This is the state after the heat has spread along the sheets, before any is lost.
    """
    capacity = brake.sheets.count * sheet_mass(brake) * _specific_heat(brake)
    return keep_if(heat >= 0, heat / capacity)


@law
def local_rise(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the rise [K], averaged over the thickness, of an inner sheet after a slip [m].

    This is the hottest position: each face takes half of the friction's work per unit area, a mu_k
    P d, and no heat is conducted along the film. Slip and vacuum [Pa] broadcast. The surface itself
    is warmer for a few milliseconds, and the contact spots warmer still; neither is modelled.
    """
    sheets = brake.sheets
    # the friction law includes the pressure exponent
    shear = friction_per_contact(vacuum, brake) / ((sheets.count - 1) * sheets.width)
    for shape in sheet_law(vacuum, brake).shapes:  # for the middle sheet, at its tension at rest
        shear = shape.amplify_middle(shear)
    rise = shear * slip / (brake.film.density * _specific_heat(brake) * sheets.thickness)
    is_valid = (slip >= 0) & (slip <= sheets.overlap) & (vacuum >= 0)
    return keep_if(is_valid, rise)


@law
def stops_per_minute(heat: Any, allowed_rise: Any, film_coefficient: Any, brake: Brake) -> Any:
    """Return the stops per minute [1/min] of equal heat [J] for an allowed mean rise [K].

    The stops are equally spaced. A stop warms the rubbing sheets by `temperature_rise`, and between
    stops they cool with the time constant C/(h A). Here h is the `film_coefficient` [W/(m^2 K)]
    from the enclosure's outer surface to still air. In the steady state the rise just after a stop
    is dT/(1 - exp(-h A t/C)) at the spacing t; it may reach `allowed_rise` above the air. The
    result is zero if a single stop exceeds it. For small dT it is h A (allowed rise)/heat,
    independent of C.

    It neglects the enclosure's heat capacity and thermal resistance, conduction into the caps, and
    the drift of friction with temperature. NaN unless all three are positive.
    """
    capacity = rubbing_mass(brake) * _specific_heat(brake)
    share = heat / (capacity * allowed_rise)
    rate = film_coefficient * outer_area(brake) / capacity
    possible = share < 1
    spacing = -xp.log1p(-xp.where(possible, share, 0.5)) / rate
    is_valid = (heat > 0) & (allowed_rise > 0) & (film_coefficient > 0) & ~xp.isnan(share)
    return keep_if(is_valid, xp.where(possible, 60 / spacing, 0.0))
