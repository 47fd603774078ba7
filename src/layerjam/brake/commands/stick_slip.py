"""`stick-slip`: whether a brake shows stick–slip, how strong it is, and how to avoid it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from layerjam.brake.commands.arguments import (
    Atmosphere,
    BrakeInput,
    CrossheadSpeed,
    Elongation,
    Mass,
    OtherFilm,
    Slip,
    Vacuum,
    check_vacuum,
    slip_notices,
)
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.mount import Rope
from layerjam.brake.device.sheets import Film
from layerjam.brake.mechanics.stick_slip.stribeck import Stribeck
from layerjam.brake.simulate.record import Outcome
from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Figure, Result, fact, number, result
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import QuantitySpec, get_spec, show

if TYPE_CHECKING:
    from layerjam.brake.mechanics.stick_slip.slide_step import Slide
    from layerjam.brake.simulate.stick_slip import Bounds, StickSlipRecord
    from layerjam.core.drawing.chart import Pane

MOUNT = QuantitySpec("N/m", "stiffness of the mount", lo=100, hi=1e9, example="200kN/m")
DAMPING = evolve(
    get_spec(Rope, "damping"), text="damping parallel to the spring", example="'5 N s/m'", symbol=""
)
STRIBECK_SPEED = evolve(get_spec(Stribeck, "speed"), example="1mm/s")
STATIC = evolve(get_spec(Film, "static"), text="static friction", example="0.3")


@result
class StickSlip(Result):
    """The last slip of the run, and remedies for stick–slip; `record` is the StickSlipRecord."""

    record: StickSlipRecord
    outcome: str = fact("outcome of the run")
    amplitude: float | None = number("N", "half the force drop of the last slip")
    relative_amplitude: float | None = number("1", "ratio of amplitude to kinetic force")
    force_high: float | None = number("N", "force before the last slip")
    force_low: float | None = number("N", "force after the last slip")
    slip_per_event: float | None = number("m", "distance slid in the last slip")
    period: float | None = number("s", "time between the last two slips")
    events: int = number("1", "number of slips in the run")
    static_force: float = number("N", "static friction force at the start")
    kinetic_force: float = number("N", "force of steady sliding at the start")
    critical_speed: float | None = number("m/s", "speed above which stick–slip decays")
    stable_speed: float | None = number("m/s", "speed above which steady sliding is stable")
    stiffness_needed: float | None = number(
        "N/m", "stiffness that lowers the critical speed to this speed"
    )
    mass: float = number("kg", "moving mass")
    stiffness: float = number("N/m", "stiffness of sheets and mount in series")
    damping_ratio: float = number("1", "ratio of damping to critical damping")

    def draw_panes(self, panes: Sequence[Pane]) -> Figure:
        """Return force versus elongation with the stick–slip bounds, and the last slip enlarged."""
        from layerjam.brake.figures import force_figures

        return force_figures.draw_stick_slip(self.record, panes[0])

    def panes(self) -> Sequence[Pane]:
        """Return force versus elongation between the stick–slip bounds."""
        from layerjam.brake.figures import force_figures

        return force_figures.bounds_panes(self.record)


@command("predict", record=(".csv", ".nc"))
def stick_slip(
    brake: BrakeInput,
    *,
    vacuum: Vacuum,
    speed: CrossheadSpeed,
    mass: Annotated[Mass, Help("Moving mass. Default: half the brake's mass.")] | None = None,
    mount_stiffness: Annotated[
        float | None, MOUNT, Help("Stiffness of your mount, instead of the measured value.")
    ] = None,
    damping: Annotated[float, DAMPING] = 0.0,
    stribeck_speed: Annotated[float, STRIBECK_SPEED] = 0.0,
    static: Annotated[float | None, STATIC, Help("Static friction, instead of the film's.")] = None,
    slip: Annotated[Slip, Help("Slip at the start.")] = 0.0,
    elongation: Annotated[
        Elongation,
        Help("Elongation of the pull. Default: for a dozen slips.", old=("--travel",)),
    ]
    | None = None,
    atmosphere: Atmosphere = None,
    film: OtherFilm = None,
) -> StickSlip:
    """Simulate a pull at one speed to see whether the brake shows stick–slip, and its remedies.

    The pull starts from rest at `slip`. Amplitude and forces are those of the last slip of the run.
    `critical_speed`, `stable_speed` and `stiffness_needed` assume the friction at `slip`.
    `stribeck_speed` 0 means that static friction vanishes immediately. Raises FitError if the run
    would take too many steps.
    """
    from layerjam.brake.simulate import stick_slip as simulation

    device = brake.brake
    check_vacuum(vacuum, device)
    notices = slip_notices(slip, device)
    _check_elongation(slip, elongation, device)
    record = simulation.stick_slip(
        brake,
        vacuum=vacuum,
        speed=speed,
        mass=mass,
        mount_stiffness=mount_stiffness,
        damping=damping,
        stribeck=_friction_curve(device, stribeck_speed, static),
        slip=slip,
        travel=elongation,
    )
    start = record.freeze_friction(slip)
    bounds = simulation.Bounds(*(float(v) for v in simulation.force_bounds(start)))
    ratio = damping / (2 * math.sqrt(record.stiffness * record.mass))
    notices += _assumption_notices(record, mass is None)
    if static is None and bounds.static > bounds.kinetic:
        notices.append(
            Notice(
                "static friction is that of a friction test; sheets that start to slip "
                "one after another carry less in total (tensile --model stack)",
                "static-of-a-test",
            )
        )
    return StickSlip.create(
        _last_slip_results(record),
        _stick_slip_limits(start, bounds, ratio),
        record,
        outcome=str(record.outcome),
        events=len(record.events),
        static_force=bounds.static,
        kinetic_force=bounds.kinetic,
        damping_ratio=ratio,
        warnings=[*record.warnings, *notices],
        record=record,
    )


judder = stick_slip
"""Former name of `stick_slip`."""


def _friction_curve(brake: Brake, speed: float, static: float | None) -> Stribeck:
    """Return the film's friction with a Stribeck speed [m/s] and, if given, static friction."""
    from layerjam.brake.mechanics.stick_slip.laws import film_curve

    curve = film_curve(brake, speed)
    if static is None:
        return curve
    if static < curve.kinetic:
        raise QuantityError(
            f"static: {static:g} is below the film's kinetic friction, {curve.kinetic:g}; "
            "static friction cannot be less"
        )
    return evolve(curve, static=static)


def _check_elongation(slip: float, elongation: float | None, brake: Brake) -> None:
    """Raise QuantityError if the overlap leaves no room for a pull or the pull is too long."""
    travel_left = brake.sheets.overlap - slip
    if travel_left <= 0:
        raise QuantityError.of("slip", f"{show(slip, 'm')} leaves no overlap to pull on")
    if elongation is not None and elongation > travel_left:
        raise QuantityError.of(
            "elongation",
            f"{show(elongation, 'm')} from a slip of {show(slip, 'm')} exceeds the overlap "
            f"of {show(brake.sheets.overlap, 'm')}",
        )


def _last_slip_results(record: StickSlipRecord) -> dict[str, float]:
    """Return the values of the last slip, or the force of steady sliding."""
    import numpy as np

    from layerjam.brake.simulate.stick_slip import force_bounds

    events, last = record.events, float(record.force[-1])
    if record.outcome is Outcome.STEADY_SLIDING:
        return {"amplitude": 0.0, "relative_amplitude": 0.0, "force_high": last, "force_low": last}
    if record.outcome is Outcome.STUCK:
        return {"force_high": last}
    if not len(events):
        return {}
    high, low = float(events.force_high[-1]), float(events.force_low[-1])
    slip_at_break = float(np.interp(events.break_time[-1], record.time, record.slip))
    level = float(force_bounds(record.freeze_friction(slip_at_break)).kinetic)
    out = {"amplitude": (high - low) / 2, "force_high": high, "force_low": low}
    out["slip_per_event"] = float(events.slip[-1])
    if level:
        out["relative_amplitude"] = (high - low) / 2 / level
    if len(events) > 1:
        out["period"] = float(events.break_time[-1] - events.break_time[-2])
    return out


def _stick_slip_limits(slide: Slide, bounds: Bounds, ratio: float) -> dict[str, float]:
    """Return the speed and the stiffness that prevent stick–slip; infinite if none does."""
    from layerjam.brake.mechanics.stick_slip.laws import stable_speed, stiffness_without_stick_slip
    from layerjam.brake.simulate.stick_slip import find_critical_speed

    drag = float(slide.damping) + float(slide.level) * float(slide.viscous)
    out = {"critical_speed": find_critical_speed(slide)}
    # steady sliding without damping is never stable; with the jump law it is at best neutral
    if drag and slide.paced_brake is None:
        drop = bounds.static - bounds.kinetic
        out["stable_speed"] = float(stable_speed(drop, slide.stribeck, slide.exponent, drag))
    if float(slide.stribeck) == 0.0 and slide.paced_brake is None:
        stiffness_needed = stiffness_without_stick_slip(slide.speed, *bounds, slide.mass, ratio)
        out["stiffness_needed"] = float(stiffness_needed)
    return out


def _assumption_notices(record: StickSlipRecord, assumed: bool) -> list[Notice]:
    """Return notices about the assumptions; `assumed` is the mass if none was given."""
    from layerjam.brake.simulate.speed import list_slide_notices

    out, count = [], len(record.events)
    if record.outcome is Outcome.STEADY_SLIDING and count:
        times = f"{count} time{'s' if count > 1 else ''}"
        out.append(
            Notice(
                f"it stuck {times} before settling: friction and critical speed fall with slip",
                "settled-late",
            )
        )
    if assumed:
        out.append(
            Notice(
                f"moving mass {show(record.mass, 'kg')}: half the brake's mass (assumed). Add "
                "any mass attached to it",
                "assumed-mass",
            )
        )
    if not record.damping:
        out.append(
            Notice(
                "no damping was given, so stick–slip never decays; critical speed "
                "and required stiffness are unknown",
                "no-damping",
            )
        )
    if record.stribeck.speed == 0:
        sentence = (
            "static friction is assumed to vanish immediately; no Stribeck speed was measured"
        )
    else:
        sentence = "the Stribeck speed is an input: it was not measured for the catalogue's films"
    fastest = float(record.speed_of_mass.max())
    notices = list_slide_notices(record.brake, record.speed, fastest)
    return [*out, Notice(sentence, "stribeck-speed"), *notices]
