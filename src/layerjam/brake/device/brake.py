"""The brake as a record of numbers only, which can be traced, batched and differentiated."""

from math import atan, pi

from layerjam.brake.device.effect import GROUP, Effect
from layerjam.brake.device.enclosure import Enclosure
from layerjam.brake.device.hyperelastic import Hyperelastic, validate_hyperelastic
from layerjam.brake.device.mount import Mount, Rope, Site
from layerjam.brake.device.sheets import Film, Sheets
from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.core.conversion import Quantity
from layerjam.core.errors import QuantityError, explain_arguments
from layerjam.core.toml_files.changes import Change, with_changes
from layerjam.core.toml_files.plugin_tables import plugin_records
from layerjam.core.units import check, is_traced, nested, quantity, record, show

FAN_EFFECT = 0.1
"""Relative change of the friction by the fan above which a result mentions spacers."""


@record
class Brake:
    """A layer-jamming brake (paper, section II). Every field is in SI units."""

    sheets: Sheets = nested(Sheets)
    film: Film = nested(Film)
    enclosure: Enclosure = nested(Enclosure)
    mount: Mount = nested(Mount)
    fittings_mass: Quantity[float] = quantity(
        "kg", "mass of caps, screws, ties and tube fittings", hi=100
    )
    weighed_mass: Quantity[float | None] = quantity(
        "kg", "weighed mass of the whole brake", lo=1e-6, hi=1000, default=None
    )
    scale_factor: Quantity[float] = quantity(
        "1", "calibration factor on the sheets' friction", lo=1e-3, hi=100, symbol="a", default=1.0
    )
    amplification_held: Quantity[float | None] = quantity(
        "1",
        (
            "self-amplification already included in the scale factor, from the brake on "
            "which it was fitted"
        ),
        lo=1,
        hi=1000,
        default=None,
    )
    stiffness_measured: Quantity[float | None] = quantity(
        "N/m", "measured stiffness of brake and rig", lo=100, hi=1e9, symbol="k", default=None
    )
    pressure_exponent: Quantity[float | None] = quantity(
        "1", "exponent of friction versus pressure", lo=-0.9, hi=2, symbol="m", default=None
    )
    test_pressure: Quantity[float | None] = quantity(
        "Pa", "contact pressure of the friction test", lo=1, hi=1e7, symbol="P_test", default=None
    )
    lowest_pressure: Quantity[float | None] = quantity(
        "Pa",
        "lowest contact pressure at which the exponent was measured; below it the friction "
        "coefficient is constant (only for sheets that fan out)",
        lo=1,
        hi=1e7,
        default=None,
    )
    speed_law: SpeedLaw | None = nested(SpeedLaw, default=None)
    hyperelastic: Hyperelastic | None = nested(Hyperelastic, default=None)
    vacuum_share: Quantity[float | None] = quantity(
        "1",
        "fraction of the gauge's vacuum that presses the sheets on average; default: 1",
        lo=0.01,
        hi=1,
        default=None,
    )
    rope: Rope | None = nested(Rope, default=None)
    site: Site = nested(Site, default=Site())
    effects: tuple[Effect, ...] = plugin_records(GROUP)
    """Effects of other packages on the friction: tables such as [effects.humidity]."""

    @explain_arguments
    def with_(self, **changes: Change) -> "Brake":
        """Return the brake with some values changed by name, such as width="14 mm".

        Text includes a unit, a number is in SI, and None means unknown or the default. Raises
        UnknownNameError with the nearest names, or QuantityError for a value out of bounds or
        values that contradict each other. Values traced by JAX are not checked.
        """
        brake = with_changes(self, changes)
        if not any(map(is_traced, changes.values())):
            validate(brake)
        return brake

    def validate(self) -> None:
        """Raise QuantityError for values that are out of bounds or contradict each other."""
        validate(self)


def validate(brake: Brake) -> None:
    """Raise QuantityError for a value out of bounds or values that contradict each other."""
    check(brake)
    for effect in brake.effects:
        check(effect)
    sheets, mount = brake.sheets, brake.mount
    if sheets.usable_travel > sheets.overlap:
        raise QuantityError.of(
            "sheets.usable_travel",
            f"{show(sheets.usable_travel, 'm')} exceeds the overlap of {show(sheets.overlap, 'm')}",
        )
    min_length = sheets.overlap + max(sheets.free_left, sheets.free_right) + mount.clamped_length
    if min_length > sheets.length * (1 + 1e-9):
        raise QuantityError.of(
            "sheets.length",
            f"{show(sheets.length, 'm')} is shorter than the sum of free length, "
            f"overlap and clamped part ({show(min_length, 'm')})",
        )
    screws = mount.count_screws(sheets.width)
    if screws * mount.screw_hole >= sheets.width:
        row = "" if screws == 1 else f", {screws} side by side,"
        raise QuantityError.of(
            "mount.screw_hole",
            f"{show(mount.screw_hole, 'm')}{row} leaves no material in sheets "
            f"{show(sheets.width, 'm')} wide",
        )
    slope = sheets.count * sheets.thickness / (4 * min(sheets.free_left, sheets.free_right))
    if mount.spacers is not None and not mount.spacers and slope > 1:
        raise QuantityError.of(
            "mount.spacers",
            f"without spacers the outermost of {sheets.count:g} sheets of "
            f"{show(sheets.thickness, 'm')} would leave its cap at {atan(slope) * 180 / pi:.0f} "
            "degrees; at most 45 are allowed: use spacers or longer free lengths",
        )
    if brake.film.kinetic > brake.film.static:
        raise QuantityError.of(
            "film.kinetic",
            f"{brake.film.kinetic} exceeds film.static, {brake.film.static}; "
            "kinetic friction cannot exceed static friction",
        )
    if (brake.film.ageing is None) != (brake.film.static_hold is None):
        raise QuantityError.of(
            "film.ageing", "give it together with film.static_hold, or give neither"
        )
    if (brake.pressure_exponent is None) != (brake.test_pressure is None):
        raise QuantityError.of(
            "pressure_exponent", "give it together with test_pressure, or give neither"
        )
    check_fan_exponent(brake)
    law = brake.speed_law
    if law is not None and law.fastest is not None and law.fastest < law.test_speed:
        raise QuantityError.of(
            "speed_law.fastest",
            f"{show(law.fastest, 'm/s')} is below test_speed, "
            f"{show(law.test_speed, 'm/s')}, at which friction was also measured",
        )
    if brake.hyperelastic is not None:
        validate_hyperelastic(brake.hyperelastic)


def sheet_mass(brake: Brake) -> float:
    """Return the mass of one sheet [kg], including its clamped part."""
    sheets = brake.sheets
    return sheets.length * sheets.width * sheets.thickness * brake.film.density


def enclosure_mass(brake: Brake) -> float:
    """Return the mass of the enclosure [kg], a close-fitting rectangular tube."""
    sheets, wall = brake.sheets, brake.enclosure.wall
    section = 2 * wall * (sheets.width + sheets.count * sheets.thickness) + 4 * wall**2
    length = sheets.free_left + sheets.overlap + sheets.free_right
    return section * length * brake.enclosure.density


def mass(brake: Brake) -> float:
    """Return the brake's mass [kg]: as weighed, or the sum of sheets, enclosure and fittings."""
    if brake.weighed_mass is not None:
        return brake.weighed_mass
    return brake.sheets.count * sheet_mass(brake) + enclosure_mass(brake) + brake.fittings_mass


def fan_exponent(brake: Brake) -> float:
    """Return the exponent alpha at rest, without spacers: a mu_k t (n/4)^2 (1/L1 + 1/L3)."""
    sheets = brake.sheets
    friction = brake.scale_factor / (brake.amplification_held or 1.0) * brake.film.kinetic
    free = 1 / sheets.free_left + 1 / sheets.free_right
    return friction * sheets.thickness * (sheets.count / 4) ** 2 * free


def fan_factor(alpha: float) -> float:
    """Return the factor on friction, sqrt(pi/(4 alpha)) exp(alpha) erf(sqrt(alpha))."""
    total = term = 1.0
    for k in range(1, 2000):
        term *= alpha / (k + 0.5)
        total += term
        if term < 1e-15 * total:
            break
    return total


def check_fan_exponent(brake: Brake) -> None:
    """Raise QuantityError for a pressure exponent that is impossible for sheets without spacers.

    Their friction grows exponentially with the coefficient. If the coefficient rose without bound
    as the vacuum falls, the brake would hold without a vacuum. A negative exponent therefore
    requires the lowest pressure of its measurement, from which friction must rise with the vacuum.
    """
    exponent, lowest = brake.pressure_exponent, brake.lowest_pressure
    fans_out = brake.mount.spacers is not None and not brake.mount.spacers
    if lowest is not None and (exponent is None or not fans_out):
        raise QuantityError.of(
            "lowest_pressure",
            "is only valid with a pressure_exponent of sheets without spacers "
            "(mount.spacers = false); other sheets lose their friction with the vacuum "
            "in any case",
        )
    if exponent is None or exponent >= 0 or not fans_out:
        return
    if lowest is None:
        raise QuantityError.of(
            "lowest_pressure",
            f"is missing: with a pressure_exponent of {exponent:g} and no spacers, friction would "
            "grow without bound as the vacuum falls. Give the lowest contact pressure at "
            'which the exponent was measured, such as "20 kPa"',
        )
    alpha = fan_exponent(brake) * (lowest / (brake.test_pressure or lowest)) ** exponent
    factor = fan_factor(alpha)
    # d ln M/d ln alpha for M = sqrt(pi/(4 alpha)) exp(alpha) erf(sqrt(alpha))
    growth = (1 - factor + 2 * alpha * factor) / (2 * factor)
    if 1 + exponent * (1 + growth) <= 0:
        raise QuantityError.of(
            "pressure_exponent",
            f"{exponent:g} is too low for sheets without spacers: at {show(lowest, 'Pa')} "
            f"(lowest_pressure) their friction would fall as the vacuum rises; at least "
            f"{-1 / (1 + growth):.3g} is allowed there",
        )
