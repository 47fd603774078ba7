"""Figures of merit of brakes as they could be built: one pure batch function over designs.

A design is a `Point`: sheets, film, lengths, enclosure, vacuum, and how many equal brakes stand in
series and in parallel. Everything else comes from a given brake. All forces are the laws of
`mechanics`; here they are only called and shared out among equal brakes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake, enclosure_mass, mass, sheet_mass
from layerjam.device.enclosure import Enclosure
from layerjam.device.sheets import Film, Sheets
from layerjam.fluid.closed_forms import rise_time
from layerjam.fluid.energy import jam_work
from layerjam.fluid.line import Line
from layerjam.mechanics import energy, friction, limits, pull, stiffness
from layerjam.mechanics.fan import is_flat
from layerjam.mechanics.law import within
from layerjam.mechanics.stick_slip import laws as stickslip
from layerjam.simulate.quantities import CROSSHEAD_SPEED, MASS
from layerjam.units import QuantitySpec, like, quantity, record, spec_of

_TIMES = QuantitySpec("1", "equal brakes", lo=1, hi=1000, whole=True)
OF_SHEETS = ("count", "thickness", "width", "overlap", "free_left", "free_right")
VARIABLES: Mapping[str, QuantitySpec] = MappingProxyType(
    {
        **{name: spec_of(Sheets, name) for name in OF_SHEETS},
        "offset": QuantitySpec("m", "slip before use, taken from overlap and travel", hi=5),
        "usable_travel": spec_of(Sheets, "usable_travel"),
        "wall": spec_of(Enclosure, "wall"),
        "fittings_mass": spec_of(Brake, "fittings_mass"),
        "vacuum": QuantitySpec("Pa", "vacuum the brake is used at", hi=1.2e5, open_lo=True),
        "series": replace(_TIMES, text="equal brakes in series"),
        "parallel": replace(_TIMES, text="equal brakes in parallel"),
    }
)
"""What may be varied, with unit, meaning and bounds; the film is chosen beside it."""

MERITS: Mapping[str, QuantitySpec] = MappingProxyType(
    {
        "holding_force": QuantitySpec("N", "static friction of all sheets at rest"),
        "max_force": QuantitySpec("N", "peak of a slow pull over the usable travel"),
        "usable_travel": QuantitySpec("m", "slip of all brakes in series"),
        "energy_capacity": QuantitySpec("J", "work over the usable travel"),
        "mass": QuantitySpec("kg", "mass of all brakes"),
        "volume": QuantitySpec("m^3", "boxes around enclosures and clamped ends, at rest"),
        "length": QuantitySpec("m", "length at rest, clamped ends included, in series"),
        "height": QuantitySpec("m", "height of one stack in its enclosure"),
        "force_density": QuantitySpec("N/kg", "max_force over mass"),
        "energy_density": QuantitySpec("J/kg", "energy_capacity over mass"),
        "stiffness": QuantitySpec("N/m", "before slip; the sheets' own on the given brake's mount"),
        "sheet_stress": QuantitySpec("Pa", "greatest stress in a sheet's free part"),
        "clamp_stress": QuantitySpec("Pa", "greatest stress at the screw holes"),
        "stress_margin": QuantitySpec("1", "strength of the film over clamp_stress"),
        "buckling_force": QuantitySpec("N", "compression at which one sheet buckles, at rest"),
        "self_closing_vacuum": QuantitySpec(
            "Pa", "vacuum below which the enclosure closes it, end of travel"
        ),
        "rise_time": QuantitySpec("s", "10 to 90 % of the vacuum on the given line"),
        "gas_work": QuantitySpec("J", "least work of a pump for one jam"),
        "judder_margin": QuantitySpec("1", "stiffness over the least without stick–slip"),
        "stop_slip": QuantitySpec("m", "slip at standstill"),
        "stop_peak": QuantitySpec("N", "greatest force of the stop"),
        "film_area": QuantitySpec("m^2", "sheets and spacers of all brakes, as drawn"),
        "print_volume": QuantitySpec(
            "m^3", "plastic to print for all brakes, one mould and core included, as drawn"
        ),
        "drawn_mass": QuantitySpec("kg", "mass of all brakes, as drawn"),
        "buildable": QuantitySpec(
            "1", "least margin of the checks of `build` that refuse or fail; 1 is built"
        ),
    }
)
"""Every figure of merit with its unit and meaning; those that need more than a brake come last."""
LINE_MERITS = ("rise_time", "gas_work")
STOP_MERITS = ("stop_slip", "stop_peak")
DRAWN_MERITS = ("film_area", "print_volume", "drawn_mass", "buildable")
LATE_MERITS = (*STOP_MERITS, *DRAWN_MERITS)
"""Merits that are computed only for designs that may yet be chosen."""


OF_A_FIT = ("scale_factor", "amplification_held")
"""Of a stock, what no film has before a brake was made of it."""


class Stock(NamedTuple):
    """The film: what the friction test of this pair of surfaces and the data sheet say."""

    modulus: Any
    density: Any
    static: Any
    kinetic: Any
    friction_on_silicone: Any
    strength: Any
    """NaN where none is known."""
    scale_factor: Any
    amplification_held: Any
    """What of the sheets' fan the scale factor holds already; NaN for nothing."""


class Point(NamedTuple):
    """One design, or arrays of many; SI. `usable_travel` None: all but the base's rest."""

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


@record
class StickSlipPull:
    """`[judder]`: what pulls, for the stiffness over the least without stick–slip."""

    speed: float = like(CROSSHEAD_SPEED, "speed of the pull")
    mass: float = like(MASS, "mass pulled")
    damping_ratio: float = quantity("1", "damping of the mount over the critical one", hi=10)


def stock_of(film: Film, scale_factor: Any = 1.0, amplification_held: Any = None) -> Stock:
    """A film as a design has it, with a calibration factor and what that holds."""
    known = {name: getattr(film, name) for name in Stock._fields if name not in OF_A_FIT}
    strength = math.nan if film.strength is None else film.strength
    held = math.nan if amplification_held is None else amplification_held
    return Stock(
        **{**known, "strength": strength}, scale_factor=scale_factor, amplification_held=held
    )


def point_of(brake: Brake, vacuum: Any = None) -> Point:
    """The design that is this brake itself, at the site's full vacuum unless another is given."""
    sheets = brake.sheets
    fittings = brake.fittings_mass
    if brake.weighed_mass is not None:
        fittings = brake.weighed_mass - sheets.count * sheet_mass(brake) - enclosure_mass(brake)
    return Point(
        stock=stock_of(brake.film, brake.scale_factor, brake.amplification_held),
        **{name: getattr(sheets, name) for name in OF_SHEETS},
        offset=0.0,
        usable_travel=sheets.usable_travel,
        wall=brake.enclosure.wall,
        fittings_mass=fittings,
        vacuum=brake.site.atmosphere if vacuum is None else vacuum,
        series=1.0,
        parallel=1.0,
    )


def brake_of(point: Point, base: Brake) -> Brake:
    """One brake of a design, as a record of arrays; what the design does not say is the base's.

    An offset x0 turns overlap into free length on both sides. The stiffness is the sheets' own in
    series with the base's mount, where one was measured.
    """
    at, start = point, base.sheets
    clamped = base.mount.clamped_length
    spare = start.length - start.overlap - jnp.maximum(start.free_left, start.free_right) - clamped
    travel = at.usable_travel
    if travel is None:
        travel = at.overlap - (start.overlap - start.usable_travel)
    sheets = Sheets(
        count=at.count,
        width=at.width,
        thickness=at.thickness,
        length=at.overlap + jnp.maximum(at.free_left, at.free_right) + clamped + spare,
        overlap=at.overlap - at.offset,
        free_left=at.free_left + at.offset,
        free_right=at.free_right + at.offset,
        usable_travel=travel - at.offset,
    )
    film = {name: value for name, value in at.stock._asdict().items() if name not in OF_A_FIT}
    made = Brake(
        sheets=sheets,
        film=Film(**film),
        enclosure=replace(base.enclosure, wall=at.wall),
        mount=base.mount,
        fittings_mass=at.fittings_mass,
        scale_factor=at.stock.scale_factor,
        amplification_held=at.stock.amplification_held,
        pressure_exponent=base.pressure_exponent,
        test_pressure=base.test_pressure,
        speed_law=base.speed_law,
        vacuum_share=base.vacuum_share,
        site=base.site,
        effects=base.effects,
    )
    if base.stiffness_measured is None:
        return made
    mount_compliance = 1 / base.stiffness_measured - 1 / stiffness.stiffness_before_slip(base)
    own = stiffness.stiffness_before_slip(made)
    return replace(made, stiffness_measured=1 / (1 / own + mount_compliance))


def can_be_built(point: Point, brake: Brake) -> Any:
    """True where the design is a brake: travel within the overlap, holes within the width, ..."""
    sheets = brake.sheets
    fine = (sheets.usable_travel > 0) & (sheets.usable_travel <= sheets.overlap * (1 + 1e-12))
    holes = brake.mount.screws_across(point.width) * brake.mount.screw_hole
    fine = fine & (point.width > holes) & (point.count >= 2)
    fine = fine & (point.vacuum > 0) & (point.vacuum <= brake.site.atmosphere) & is_flat(brake)
    return fine & (brake.stiffness_measured > 0 if brake.stiffness_measured is not None else True)


def merits(point: Point, base: Brake, pulled: StickSlipPull | None = None) -> dict[str, Any]:
    """Every figure of merit that follows from the brake alone; arrays of the broadcast shape.

    For `series` times `parallel` equal brakes with an ideally even share. All NaN where the design
    cannot be built; `judder_margin` only with `pulled`.
    """
    made = brake_of(point, base)
    sheets, vacuum = made.sheets, point.vacuum
    row, rows = point.series, point.parallel
    number = row * rows
    fine = can_be_built(point, made)
    top = pull.peak(vacuum, sheets.usable_travel, made).force
    weight = mass(made) * number
    work = energy.slip_work(sheets.usable_travel, vacuum, made) * number
    clamp = limits.clamp_stress(top, made)
    height = sheets.count * sheets.thickness + 2 * made.enclosure.wall
    length = sheets.free_left + sheets.overlap + sheets.free_right + 2 * made.mount.clamped_length
    held = friction.holding_force(vacuum, made)
    own = stiffness.working_stiffness(made)
    out = {
        "holding_force": held * rows,
        "max_force": top * rows,
        "usable_travel": sheets.usable_travel * row,
        "energy_capacity": work,
        "mass": weight,
        "volume": (point.width + 2 * made.enclosure.wall) * height * length * number,
        "length": length * row,
        "height": height,
        "force_density": top * rows / weight,
        "energy_density": work / weight,
        "stiffness": own * rows / row,
        "sheet_stress": limits.sheet_stress(top, made),
        "clamp_stress": clamp,
        "stress_margin": point.stock.strength / clamp,
        "buckling_force": limits.buckling_force(0.0, made),
        "self_closing_vacuum": limits.self_closing_vacuum(sheets.usable_travel, made),
    }
    if pulled is not None:
        kinetic = friction.sheet_friction(0.0, vacuum, made)
        least = stickslip.stiffness_without_stick_slip(
            pulled.speed, held * rows, kinetic * rows, pulled.mass, pulled.damping_ratio
        )
        out["judder_margin"] = own * rows / row / least
    return {name: within(fine, value) for name, value in out.items()}


def line_merits(vacuum: float, line: Line, brakes: float) -> tuple[float, float]:
    """`rise_time` [s] and `gas_work` [J] with one chamber of the line's for every brake.

    Rise time NaN where the line never reaches the vacuum. Closed forms: a rigid chamber at one
    temperature without a tube that matters; both grow in proportion to the chamber.
    """
    chamber = replace(
        line.chamber, volume=line.chamber.volume * brakes, shrink=line.chamber.shrink * brakes
    )
    many = replace(line, chamber=chamber)
    time = rise_time(vacuum, many)
    work = jam_work(vacuum, many) if vacuum <= line.site.atmosphere else math.nan
    return math.nan if time is None else time, work


def line_table(vacuums: np.ndarray[Any, Any], line: Line) -> np.ndarray[Any, Any]:
    """`line_merits` of one brake, shape (2, vacuums [Pa]); n brakes have n times as much."""
    return np.array([line_merits(float(v), line, 1.0) for v in vacuums]).T
