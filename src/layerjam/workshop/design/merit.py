"""Figures of merit of buildable brakes, as a pure, batched function of designs.

A design is a `Point`: sheets, film, lengths, enclosure, vacuum, and the number of identical brakes
in series and in parallel. A base brake supplies everything else. All forces follow from the laws of
`mechanics`; identical brakes share them equally.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake, enclosure_mass, mass, sheet_mass
from layerjam.brake.device.enclosure import Enclosure
from layerjam.brake.device.sheets import Film, Sheets
from layerjam.brake.device.workshop import Build
from layerjam.brake.fluid.closed_forms import rise_time
from layerjam.brake.fluid.line import Line
from layerjam.brake.fluid.vacuum_energy import jam_work
from layerjam.brake.mechanics import energy, friction, limits, pull, stiffness
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.effects import use_single_modulus
from layerjam.brake.mechanics.fan import is_flat
from layerjam.brake.mechanics.law import keep_if
from layerjam.brake.mechanics.stick_slip import laws as stickslip
from layerjam.brake.simulate.prediction import Deviations, change_numbers
from layerjam.brake.simulate.quantities import CROSSHEAD_SPEED, MASS
from layerjam.core.evolve import assemble, evolve
from layerjam.core.units import QuantitySpec, get_spec, like, quantity, record

_TIMES = QuantitySpec("1", "identical brakes", lo=1, hi=1000, whole=True)
OF_SHEETS = ("count", "thickness", "width", "overlap", "free_left", "free_right")
VARIABLES: Mapping[str, QuantitySpec] = {
    **{name: get_spec(Sheets, name) for name in OF_SHEETS},
    "offset": QuantitySpec("m", "slip before use, subtracted from overlap and travel", hi=5),
    "usable_travel": get_spec(Sheets, "usable_travel"),
    "wall": get_spec(Enclosure, "wall"),
    "fittings_mass": get_spec(Brake, "fittings_mass"),
    "vacuum": QuantitySpec("Pa", "operating vacuum of the brake", hi=1.2e5, open_lo=True),
    "series": evolve(_TIMES, text="identical brakes in series"),
    "parallel": evolve(_TIMES, text="identical brakes in parallel"),
}
"""Variables of a design, with units, meanings and bounds; the film is chosen separately."""

MERITS: Mapping[str, QuantitySpec] = {
    "holding_force": QuantitySpec("N", "static friction of all sheets at rest"),
    "max_force": QuantitySpec("N", "peak of a slow pull over the usable travel"),
    "usable_travel": QuantitySpec("m", "usable slip of all brakes in series"),
    "energy_capacity": QuantitySpec("J", "work over the usable travel"),
    "mass": QuantitySpec("kg", "mass of all brakes"),
    "volume": QuantitySpec("m^3", "boxes around the enclosures and clamped ends, at rest"),
    "length": QuantitySpec("m", "length of all brakes in series, as built, at rest"),
    "clamped_length": QuantitySpec(
        "m", "length of the sheets of all brakes in series, with clamped ends, at rest"
    ),
    "height": QuantitySpec("m", "height of one stack in its enclosure"),
    "force_density": QuantitySpec("N/kg", "ratio of max_force to mass"),
    "energy_density": QuantitySpec("J/kg", "ratio of energy_capacity to mass"),
    "stiffness": QuantitySpec(
        "N/m", ("stiffness before slip; that of the sheets on the given brake's mount")
    ),
    "sheet_stress": QuantitySpec("Pa", "highest stress in a sheet's free part"),
    "clamp_stress": QuantitySpec("Pa", "highest stress at the screw holes"),
    "stress_margin": QuantitySpec("1", "ratio of film strength to clamp_stress"),
    "buckling_force": QuantitySpec("N", "compressive force that buckles one sheet, at rest"),
    "self_closing_vacuum": QuantitySpec(
        "Pa", "vacuum below which the enclosure closes the brake, at the end of travel"
    ),
    "rise_time": QuantitySpec("s", "time from 10 to 90 % of the vacuum on the given line"),
    "gas_work": QuantitySpec("J", "minimum pump work for one jam"),
    "judder_margin": QuantitySpec(
        "1", ("ratio of the stiffness to the minimum that avoids stick–slip")
    ),
    "stop_slip": QuantitySpec("m", "slip at which the mass stops"),
    "stop_peak": QuantitySpec("N", "peak force of the stop"),
    "film_area": QuantitySpec("m^2", "area of the sheets and spacers of all brakes, as drawn"),
    "print_volume": QuantitySpec(
        "m^3", "plastic to print for all brakes, including one mould and core, as drawn"
    ),
    "drawn_mass": QuantitySpec("kg", "mass of all brakes, as drawn"),
    "buildable": QuantitySpec(
        "1", "smallest margin of the checks that can reject a `build`; at least 1 passes"
    ),
}
"""All figures of merit with units and meanings; those that need more than a brake come last."""
LINE_MERITS = ("rise_time", "gas_work")
STOP_MERITS = ("stop_slip", "stop_peak")
DRAWN_MERITS = ("film_area", "print_volume", "drawn_mass", "buildable")
LATE_MERITS = (*STOP_MERITS, *DRAWN_MERITS)
"""Merits computed only for designs that may still be chosen."""


OF_A_FIT = ("scale_factor", "amplification_held")
"""Fields of a stock that are unknown until a brake with this film has been calibrated."""


class Stock(NamedTuple):
    """A film with values from its data sheet and from a friction test of this pair of surfaces."""

    modulus: Any
    density: Any
    static: Any
    kinetic: Any
    friction_on_silicone: Any
    strength: Any
    """Tensile strength; NaN if unknown."""
    scale_factor: Any
    amplification_held: Any
    """Factor of self-amplification that the scale factor already includes; NaN if none."""


class Point(NamedTuple):
    """One design, or arrays of many; SI. If `usable_travel` is None, the base overlap remains."""

    stock: Stock
    count: Any
    thickness: Any
    width: Any
    overlap: Any
    free_left: Any
    free_right: Any
    offset: Any
    usable_travel: Any
    wall: Any
    fittings_mass: Any
    vacuum: Any
    series: Any
    parallel: Any
    fittings_length: Any
    """Length of one brake beyond the clamped ends of its sheets."""
    link_gap: Any
    """Distance between two brakes in series."""


@record
class StickSlipPull:
    """`[judder]`: the pull for which the smallest stiffness without stick–slip is calculated."""

    speed: float = like(CROSSHEAD_SPEED, "speed of the pull")
    mass: float = like(MASS, "mass pulled")
    damping_ratio: float = quantity("1", "damping ratio of the mount", hi=10)


def make_stock(film: Film, scale_factor: Any = 1.0, amplification_held: Any = None) -> Stock:
    """Return a film as a stock, with a scale factor and the fanning that this factor includes."""
    values = {name: getattr(film, name) for name in Stock._fields if name not in OF_A_FIT}
    strength = math.nan if film.strength is None else film.strength
    fan = math.nan if amplification_held is None else amplification_held
    return Stock(
        **{**values, "strength": strength}, scale_factor=scale_factor, amplification_held=fan
    )


def make_point(brake: Brake, vacuum: Any = None, build: Build | None = None) -> Point:
    """Return the design that reproduces a brake, at the site's full vacuum by default.

    `build` are the workshop's choices; None means the defaults.
    """
    choices = build or Build()
    sheets = brake.sheets
    fittings = brake.fittings_mass
    if brake.weighed_mass is not None:
        fittings = brake.weighed_mass - sheets.count * sheet_mass(brake) - enclosure_mass(brake)
    return Point(
        stock=make_stock(brake.film, brake.scale_factor, brake.amplification_held),
        **{name: getattr(sheets, name) for name in OF_SHEETS},
        offset=0.0,
        usable_travel=sheets.usable_travel,
        wall=brake.enclosure.wall,
        fittings_mass=fittings,
        vacuum=brake.site.atmosphere if vacuum is None else vacuum,
        series=1.0,
        parallel=1.0,
        fittings_length=choices.fittings_length,
        link_gap=choices.gap,
    )


def make_brake(point: Point, base: Brake) -> Brake:
    """Return one brake of a design, as a record of arrays, with missing values from the base.

    An offset x0 turns overlap into free length on both sides. The stiffness is that of the sheets
    in series with the base brake's mount, if the mount's stiffness has been measured.
    """
    start = base.sheets
    ends = base.mount.clamped_length
    spare = start.length - start.overlap - xp.maximum(start.free_left, start.free_right) - ends
    free = xp.maximum(point.free_left, point.free_right)
    travel = point.usable_travel
    if travel is None:
        travel = point.overlap - (start.overlap - start.usable_travel)
    sheets = assemble(
        Sheets,
        count=point.count,
        width=point.width,
        thickness=point.thickness,
        length=point.overlap + free + ends + spare,
        overlap=point.overlap - point.offset,
        free_left=point.free_left + point.offset,
        free_right=point.free_right + point.offset,
        usable_travel=travel - point.offset,
    )
    film = {name: value for name, value in point.stock._asdict().items() if name not in OF_A_FIT}
    brake = evolve(
        use_single_modulus(base),
        sheets=sheets,
        film=assemble(Film, **film),
        enclosure=evolve(base.enclosure, wall=point.wall),
        fittings_mass=point.fittings_mass,
        weighed_mass=None,
        scale_factor=point.stock.scale_factor,
        amplification_held=point.stock.amplification_held,
        stiffness_measured=None,
        rope=None,
    )
    if base.stiffness_measured is None:
        return brake
    mount_compliance = 1 / base.stiffness_measured - 1 / stiffness.stiffness_before_slip(base)
    sheet_stiffness = stiffness.stiffness_before_slip(brake)
    return evolve(brake, stiffness_measured=1 / (1 / sheet_stiffness + mount_compliance))


def built_length(sheets: Sheets, fittings_length: Any) -> Any:
    """Return the overall length of a brake at rest [m], with both heads, as `build` draws it.

    A sheet is clamped over its length without overlap and free part, also by any surplus.
    """
    return 2 * sheets.length - sheets.overlap + fittings_length


def is_buildable(point: Point, brake: Brake) -> Any:
    """Return whether a design is valid: its travel fits its overlap and its holes fit its width."""
    sheets = brake.sheets
    valid = (sheets.usable_travel > 0) & (sheets.usable_travel <= sheets.overlap * (1 + 1e-12))
    holes = brake.mount.count_screws(point.width) * brake.mount.screw_hole
    valid = valid & (point.width > holes) & (point.count >= 2)
    valid = valid & (point.vacuum > 0) & (point.vacuum <= brake.site.atmosphere) & is_flat(brake)
    return valid & (brake.stiffness_measured > 0 if brake.stiffness_measured is not None else True)


def merits(
    point: Point,
    base: Brake,
    puller: StickSlipPull | None = None,
    deviations: Deviations | None = None,
) -> dict[str, Any]:
    """Return all figures of merit that depend on the brake alone, in the broadcast shape.

    They are for `series` times `parallel` identical brakes that share the load equally, and NaN if
    the design cannot be built. `judder_margin` is included only with a stick–slip `puller`. The
    numbers of the brakes have `deviations`.
    """
    brake = change_numbers(make_brake(point, base), deviations)
    sheets, vacuum = brake.sheets, point.vacuum
    row, rows = point.series, point.parallel
    number = row * rows
    valid = is_buildable(point, brake)
    top = pull.peak(vacuum, sheets.usable_travel, brake).force
    weight = mass(brake) * number
    work = energy.slip_work(sheets.usable_travel, vacuum, brake) * number
    clamp = limits.clamp_stress(top, brake)
    height = sheets.count * sheets.thickness + 2 * brake.enclosure.wall
    free = sheets.free_left + sheets.overlap + sheets.free_right
    length = free + 2 * brake.mount.clamped_length
    holding = friction.holding_force(vacuum, brake)
    brake_stiffness = stiffness.working_stiffness(brake)
    out = {
        "holding_force": holding * rows,
        "max_force": top * rows,
        "usable_travel": sheets.usable_travel * row,
        "energy_capacity": work,
        "mass": weight,
        "volume": (point.width + 2 * brake.enclosure.wall) * height * length * number,
        "length": built_length(sheets, point.fittings_length) * row + point.link_gap * (row - 1),
        "clamped_length": length * row,
        "height": height,
        "force_density": top * rows / weight,
        "energy_density": work / weight,
        "stiffness": brake_stiffness * rows / row,
        "sheet_stress": limits.sheet_stress(top, brake),
        "clamp_stress": clamp,
        "stress_margin": point.stock.strength / clamp,
        "buckling_force": limits.buckling_force(0.0, brake),
        "self_closing_vacuum": limits.self_closing_vacuum(sheets.usable_travel, brake),
    }
    if puller is not None:
        kinetic = friction.sheet_friction(0.0, vacuum, brake)
        min_stiffness = stickslip.stiffness_without_stick_slip(
            puller.speed, holding * rows, kinetic * rows, puller.mass, puller.damping_ratio
        )
        out["judder_margin"] = brake_stiffness * rows / row / min_stiffness
    return {name: keep_if(valid, value) for name, value in out.items()}


def line_merits(vacuum: float, line: Line, brakes: float) -> tuple[float, float]:
    """Return `rise_time` [s] and `gas_work` [J] if every brake has the same chamber as the line.

    The rise time is NaN if the vacuum is never reached. The closed forms assume a rigid chamber at
    one temperature and no tube resistance; both results are proportional to the chamber volume.
    """
    chamber = evolve(
        line.chamber, volume=line.chamber.volume * brakes, shrink=line.chamber.shrink * brakes
    )
    whole_line = evolve(line, chamber=chamber)
    time = rise_time(vacuum, whole_line)
    work = jam_work(vacuum, whole_line) if vacuum <= line.site.atmosphere else math.nan
    return math.nan if time is None else time, work


def line_table(vacuums: np.ndarray[Any, Any], line: Line) -> np.ndarray[Any, Any]:
    """Return `line_merits` of one brake at vacuums [Pa], shape (2, vacuums)."""
    return np.array([line_merits(float(v), line, 1.0) for v in vacuums]).T
