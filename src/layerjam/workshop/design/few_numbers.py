"""Design requests made from a few numbers: a force to resist, or a mass to stop."""

import math
from collections.abc import Mapping
from types import MappingProxyType

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import QuantitySpec, exact_text, quantities, show
from layerjam.workshop.design.design_file import plain_name
from layerjam.workshop.design.merit import MERITS, VARIABLES, built_length
from layerjam.workshop.design.request import (
    Axis,
    DesignRequest,
    FilmChoice,
    Range,
    open_reader,
    read_request,
)
from layerjam.workshop.design.requirements import Constraint, Objective
from layerjam.workshop.design.specification import example_texts
from layerjam.workshop.design.stopping import StopRequirement

HOLD: Mapping[str, QuantitySpec] = {
    "force": evolve(MERITS["holding_force"], open_lo=True, hi=1e7),
    "mass": QuantitySpec("kg", "maximum mass of all brakes", open_lo=True, hi=100),
    "width": QuantitySpec("m", "maximum width of the sheets of one brake", open_lo=True, hi=1),
    "length": QuantitySpec(
        "m", "maximum length at rest, as built, including both heads", open_lo=True, hi=5
    ),
    "stress_margin": evolve(MERITS["stress_margin"], hi=100),
    "travel": evolve(MERITS["usable_travel"], hi=5),
    "vacuum": VARIABLES["vacuum"],
}
"""Requirements of a brake that resists a force; a stress_margin or travel of 0 sets no limit."""
FORCES = MappingProxyType({"rest": "holding_force", "sliding": "max_force"})
"""{when a brake must resist: name of the force}: before it slips, or at the peak of a pull."""
PREFERENCES = {
    "mass": Objective("mass", True),
    "length": Objective("length", True),
    "energy": Objective("energy_capacity", False),
}
"""{preference: its objective}."""
STOP: Mapping[str, QuantitySpec] = MappingProxyType(
    {name: spec for name, spec, _ in quantities(StopRequirement)}
    | {name: HOLD[name] for name in ("stress_margin", "width", "length", "vacuum")}
    | {"own_mass": HOLD["mass"]}
)
"""Requirements of a brake that stops a mass."""
STEPS = 20
VACUUMS = (0.6, 0.8, 0.93)
"""Vacuums as fractions of atmospheric pressure; the paper's pump reached 94.5 of 101.3 kPa."""
Number = str | float


def hold(
    brake: BrakeFile,
    brake_name: str,
    *,
    force: Number,
    mass: Number,
    width: Number,
    length: Number,
    stress_margin: float = 2.0,
    travel: Number = 0.0,
    vacuum: Number | None = None,
    when: str = "rest",
    prefer: str = "mass",
) -> DesignRequest:
    """Return the request for a brake that resists `force` at no more than `vacuum`.

    `mass` is the maximum mass. `brake_name` is the name of the base brake in the request, `when` a
    key of FORCES and `prefer` one of PREFERENCES; the slip is at least `travel`. Raises
    QuantityError for values out of bounds, a length that leaves no overlap, or a stress margin if
    the film's strength is unknown.
    """
    values = _read_request(
        HOLD,
        force=force,
        mass=mass,
        width=width,
        length=length,
        travel=travel,
        stress_margin=stress_margin,
    )
    force_text = exact_text(values["force"], "N")
    limits = [Constraint(name, True, values[name]) for name in ("mass", "width", "length")]
    if values["travel"]:
        limits.append(Constraint("usable_travel", False, values["travel"]))
    return DesignRequest(
        name=plain_name(f"hold-{force_text}".replace(" ", "")),
        title=f"Hold {force_text} with little mass",
        brake=brake_name,
        constraints=(
            Constraint(FORCES[when], False, values["force"]),
            *limits,
            *_strength_margin(brake, values["stress_margin"]),
        ),
        objectives=(PREFERENCES[prefer],),
        film=_film_names(brake_name),
        vary={
            "count": Range(3, 61, 2),
            "width": _round_range(values["width"] / 4, values["width"]),
            "overlap": _overlap_range(brake, values["length"]),
            "vacuum": _vacuum_range(brake, vacuum),
            "parallel": (1, 2, 3, 4),
        },
    )


def stop(
    brake: BrakeFile,
    brake_name: str,
    *,
    mass: Number,
    speed: Number,
    travel: Number,
    force: Number,
    stress_margin: float = 1.5,
    own_mass: Number | None = None,
    width: Number | None = None,
    length: Number | None = None,
    vacuum: Number | None = None,
    prefer: str = "mass",
) -> DesignRequest:
    """Return the request for brakes that stop a mass within a travel and with a limited force.

    The mass moves horizontally; `own_mass`, `width` and `length` limit the brakes. Raises
    QuantityError as `hold` does.
    """
    values = _read_request(
        STOP, mass=mass, speed=speed, travel=travel, force=force, stress_margin=stress_margin
    )
    margin = values.pop("stress_margin")
    texts = {name: exact_text(value, STOP[name].unit) for name, value in values.items()}
    limits = {"mass": own_mass, "width": width, "length": length}
    caps = {n: HOLD[n].si(value, n) for n, value in limits.items() if value is not None}
    sheets = brake.brake.sheets
    widths = {sheets.width * f for f in (1, 1.5, 2, 2.5, 3)}
    longest = max(2 * sheets.overlap, 1.2 * values["travel"] / 2)
    return DesignRequest(
        name="stop",
        title=f"Stop {texts['mass']} from {texts['speed']} within a slip of {texts['travel']} "
        f"and below {texts['force']}",
        brake=brake_name,
        constraints=(
            *(Constraint(name, True, value) for name, value in caps.items()),
            *_strength_margin(brake, margin),
        ),
        objectives=(PREFERENCES[prefer],),
        stop=StopRequirement(**values, horizontal=True),
        film=_film_names(brake_name),
        vary={
            "count": Range(5, 37, 4),
            "width": tuple(sorted({float(f"{min(w, caps.get('width', w)):.12g}") for w in widths})),
            "overlap": _round_range(_remaining_overlap(brake) + 0.1 * longest, longest, 12),
            "vacuum": _vacuum_range(brake, vacuum),
            "series": (1, 2, 3, 4),
            "parallel": (1, 2, 3, 4, 6, 8),
        },
    )


def _read_request(specs: Mapping[str, QuantitySpec], **given: Number) -> dict[str, float]:
    return {name: specs[name].si(value, name) for name, value in given.items()}


def _film_names(brake_name: str) -> tuple[FilmChoice, ...]:
    choices = read_request(open_reader(example_texts()["stop"], "stop")).film
    return tuple(choice for choice in choices if choice.use == brake_name)


def _strength_margin(brake: BrakeFile, margin: float) -> tuple[Constraint, ...]:
    if not margin:
        return ()
    if brake.brake.film.strength is None:
        raise QuantityError.of(
            "stress_margin",
            f"{margin:g} cannot be required because the film strength of {brake.name} is "
            "unknown; use 0 for no requirement",
        )
    return (Constraint("stress_margin", False, margin),)


def _remaining_overlap(brake: BrakeFile) -> float:
    """Return the overlap [m] that must remain, as in the base brake."""
    return brake.brake.sheets.overlap - brake.brake.sheets.usable_travel


def _overlap_range(brake: BrakeFile, length: float) -> Axis:
    sheets = brake.brake.sheets
    used = built_length(sheets, brake.making.build.fittings_length) - sheets.overlap
    longest, gap = length - used, _remaining_overlap(brake)
    if longest <= gap:
        raise QuantityError.of(
            "length",
            f"{show(length, 'm')} is too short; the free and clamped parts, caps and heads of "
            f"{brake.name} need {show(used, 'm')}, and an overlap of {show(gap, 'm')} must remain",
        )
    return _round_range(longest / 4 if longest / 4 > gap else (longest + gap) / 2, longest)


def _vacuum_range(brake: BrakeFile, available: Number | None) -> Axis:
    full_vacuum = brake.brake.site.atmosphere
    if available is not None:
        full_vacuum = HOLD["vacuum"].si(available, "vacuum") / VACUUMS[-1]
    steps = (
        math.floor(full_vacuum * part / 500 + 1e-9) * 500.0 or full_vacuum * part
        for part in VACUUMS
    )
    return tuple(dict.fromkeys(steps))


def _round_range(low: float, high: float, steps: int = STEPS) -> Range:
    """Return a range from about `low` to exactly `high`, in round steps."""
    raw = (high - low) / steps
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(f * power for f in (1, 2, 5, 10) if f * power >= raw * (1 - 1e-9))
    first = high - math.floor((high - low) / step * (1 + 1e-9)) * step
    return Range(*(float(f"{v:.6g}") for v in (first, high, step)))
