"""`rise`: how fast a line brings the vacuum, and how fast it lets go of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from layerjam.device.mount import Site
from layerjam.errors import FitError, QuantityError, UnknownNameError
from layerjam.fluid import closed_forms as forms
from layerjam.fluid.energy import jam_work
from layerjam.fluid.file import LineFile, load_line
from layerjam.fluid.flow import VAPOUR
from layerjam.fluid.line import Line, validate
from layerjam.fluid.network import Drive, Response, at_pressure, respond
from layerjam.units import Meaning, meaning_of, show
from layerjam.verbs.answer import Answer, Quantity, si

AnyLine = str | Path | LineFile
FLUIDS = ("air", "water")
TARGET = Meaning("Pa", "vacuum to reach, the atmosphere less the pressure inside,", open_lo=True)
UNITS = {
    "rise_time": "s", "time_constant": "s", "fall_time": "s", "target": "Pa", "reachable": "Pa",
    "closed_form": "s", "gas_work": "J",
}  # fmt: skip
LONGEST = 200.0
"""Time constants after which a rise is given up."""


def line_at(line: AnyLine, atmosphere: Quantity | None) -> LineFile:
    """The line, at the site's atmosphere if one is given."""
    file = line if isinstance(line, LineFile) else load_line(line)
    if atmosphere is None:
        return file
    pressure = si(atmosphere, meaning_of(Site, "atmosphere"), "atmosphere")
    made = replace(file.line, site=replace(file.line.site, atmosphere=pressure))
    validate(made)
    return replace(file, line=made)


def target_of(target: Quantity, line: Line) -> float:
    """A vacuum [Pa] that the site allows."""
    wanted = si(target, TARGET, "target")
    if wanted > line.site.atmosphere:
        raise QuantityError(
            f"target: {show(wanted, 'Pa', 6)} is more than the atmosphere, "
            f"{show(line.site.atmosphere, 'Pa', 6)}; a vacuum is at most that"
        )
    return wanted


def simple(line: Line) -> bool:
    """Whether the closed forms hold: one rigid volume at one temperature, no orifice leaks."""
    chamber, leak = line.chamber, line.leak
    return line.tube is None and chamber.shrink == 0 and leak.orifice == 0 and line.polytropic == 1


def rise(
    line: AnyLine, *, target: Quantity, fluid: str = "air", atmosphere: Quantity | None = None
) -> Answer:
    """10 to 90 % rise time to a vacuum, the time constant, and the fall when vented.

    The pump runs full on until the target is reached. `rise_time` is None, `feasible` False and
    `reason` says what can be had where the target is never reached. In air the line is integrated
    (`record` is the Response); `closed_form` beside it holds where the volume is rigid and no tube
    or orifice counts. `fall_time` is by the vent valve, or the pumps run backwards (`fall_by`);
    None where the line has neither.
    """
    if fluid not in FLUIDS:
        raise UnknownNameError("fluid", fluid, FLUIDS)
    file = line_at(line, atmosphere)
    wanted, water = target_of(target, file.line), fluid == "water"
    if water and file.line.chamber.compliance is None:
        raise FitError(
            f"chamber.compliance: {file.name} has none, so that nothing says how much water a "
            "vacuum draws out"
        )
    made = file.line
    low = forms.reachable(made, water)
    said = list(file.warnings())
    if water:
        said.append("water: pump and compliance only; neither tube nor bubbles are counted")
    timed, response = (
        (forms.rise_time(wanted, made, True), None) if water else _pumped(wanted, made)
    )
    fall, by = (None, None) if timed is None else _fall(wanted, made, water)
    reason = None
    if timed is None:
        what = f"the water boils ({show(VAPOUR, 'Pa')} at 20 °C)" if water and (
            made.pump.ultimate < VAPOUR
        ) else "pump and leak balance"  # fmt: skip
        reason = f"{show(wanted, 'Pa')} is never reached: at {show(low, 'Pa')} {what}"
    own = forms.rise_time(wanted, made, water) if water or simple(made) else None
    work = None if timed is None else jam_work(wanted, made, water)
    return Answer(
        values={
            "rise_time": timed,
            "time_constant": forms.time_constant(made, water),
            "fall_time": fall,
            "fall_by": by,
            "feasible": timed is not None,
            "reason": reason,
            "reachable": low,
            "target": wanted,
            "fluid": fluid,
            "closed_form": own,
            "gas_work": work,
        },
        units=UNITS,
        warnings=said,
        record=response,
    )  # fmt: skip


def _pumped(target: float, line: Line) -> tuple[float | None, Response | None]:
    """10 to 90 % by integration; None where it is never reached."""
    if target >= forms.reachable(line):
        return None, None
    span = 4 * forms.time_constant(line)
    while span < LONGEST * forms.time_constant(line):
        made = respond(line, span, Drive(), at_pressure(line), samples=801)
        if made.vacuum[-1] >= target:
            low, high = made.crossing(0.1 * target), made.crossing(0.9 * target)
            assert low is not None and high is not None
            return high - low, made
        span *= 2
    return None, None


def _fall(target: float, line: Line, water: bool) -> tuple[float | None, str | None]:
    """90 to 10 % when vented, and by what."""
    if line.valve is not None and not water:
        if simple(line):
            return forms.fall_by_valve(target, line), "valve"
        start = at_pressure(line, line.site.atmosphere - target)
        span = forms.fall_by_valve(target, line) * 4
        for _ in range(12):
            made = respond(line, span, Drive(pump=0.0, vent=1.0), start, samples=801)
            end = made.crossing(0.1 * target)
            if end is not None:
                first = made.crossing(0.9 * target)
                assert first is not None
                return end - first, "valve"
            span *= 2
        return None, None
    back = forms.fall_by_pump(target, line, water)
    return back, None if back is None else "pumps run backwards"
