"""`rise`: how fast a line brings the vacuum, and how fast it lets go of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.commands.answer import Answer, Quantity, si
from layerjam.device.mount import Site
from layerjam.errors import FitError, QuantityError, UnknownNameError
from layerjam.fluid import closed_forms as forms
from layerjam.fluid.energy import jam_work
from layerjam.fluid.file import LineFile, load_line
from layerjam.fluid.flow import VAPOUR
from layerjam.fluid.line import Line, validate, water_compliance
from layerjam.fluid.network import Response, respond
from layerjam.fluid.pump import intake
from layerjam.fluid.timing import pumped, released
from layerjam.fluid.tube import LAMINAR_UP_TO, filling_lag, reynolds, wave_delay
from layerjam.units import QuantitySpec, show, spec_of

AnyLine = str | Path | LineFile
FLUIDS = ("air", "water")
TARGET = QuantitySpec(
    "Pa", "vacuum to reach, the atmosphere less the pressure inside,", open_lo=True
)
UNITS = {
    "rise_time": "s", "time_constant": "s", "fall_time": "s", "target": "Pa", "reachable": "Pa",
    "closed_form": "s", "closed_form_fall": "s", "gas_work": "J", "tube_delay": "s",
    "tube_lag": "s",
}  # fmt: skip
MATTERS = 0.05
"""Share of the rise time from which on what the tube delays is said."""
CELLS = 10
"""Of a tube, to start with: a wave's front comes to a tenth of its way."""


class Filling(NamedTuple):
    """Vacuum [Pa] over time [s] in a line filled with water, shape (N,)."""

    time: npt.NDArray[np.float64]
    vacuum: npt.NDArray[np.float64]


def line_at(line: AnyLine, atmosphere: Quantity | None) -> LineFile:
    """The line, at the site's atmosphere if one is given."""
    file = line if isinstance(line, LineFile) else load_line(line)
    if atmosphere is None:
        return file
    pressure = si(atmosphere, spec_of(Site, "atmosphere"), "atmosphere")
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


def rise(
    line: AnyLine,
    *,
    target: Quantity,
    fluid: str = "air",
    atmosphere: Quantity | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Answer:
    """10 to 90 % rise time to a vacuum, the time constant, and the fall when vented.

    The pump runs full on until the target is reached. `rise_time` is None, `feasible` False and
    `reason` says what can be had where the target is never reached. In air the line is integrated
    (`record` is the Response, of water a Filling); `closed_form` beside it holds where the volume
    is rigid and no tube or orifice counts. `fall_time` is by the vent valve from when it is open,
    or the pumps run backwards (`fall_by`), with `closed_form_fall` likewise; None where the line
    has neither.
    `tube_delay` is the way of a pressure wave along the tube, `tube_lag` the time constant of its
    resistance and the chamber's volume at the target; None without a tube. `progress` is told
    (what, share done): a tube in many cells takes a while.
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
    timed, response = (forms.rise_time(wanted, made, True), None) if water else (
        pumped(wanted, made, _of(progress, "rise"))
    )  # fmt: skip
    fall, by = (
        _fall(wanted, made, water, _of(progress, "fall")) if timed is not None else (None, None)
    )
    reason, curve = None, response or _curve(wanted, made, water)
    if timed is None:
        what = f"the water boils ({show(VAPOUR, 'Pa')} at 20 °C)" if water and (
            made.pump.ultimate < VAPOUR
        ) else "pump and leak balance" if made.leak.laminar or made.leak.orifice else (
            "the pump takes in no more"
        )  # fmt: skip
        reason = f"{show(wanted, 'Pa')} is never reached: at {show(low, 'Pa')} {what}"
    closed = water or forms.simple(made)
    own = forms.rise_time(wanted, made, water) if closed else None
    own_fall = _closed_fall(wanted, made, by, water) if closed else None
    delays = (None, None) if made.tube is None or water else (
        wave_delay(made.tube, made.polytropic), filling_lag(made, made.site.atmosphere - wanted)
    )  # fmt: skip
    if timed is not None and not water:
        said += _of_the_tube(made, timed, *delays)
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
            "closed_form_fall": own_fall,
            "gas_work": work,
            "tube_delay": delays[0],
            "tube_lag": delays[1],
        },
        units=UNITS,
        warnings=said,
        record=curve,
    )  # fmt: skip


def _curve(target: float, line: Line, water: bool) -> Response | Filling:
    """Of water, and of a line that never gets there: how far it comes."""
    if not water:
        return respond(line, 8 * forms.time_constant(line))
    end = min(target, forms.reachable(line, water=True))
    whole = end * water_compliance(line) / forms.pumps_flow(line)
    return Filling(np.array([0.0, whole, 1.6 * whole]), np.array([0.0, end, end]))


def _of(progress: Callable[[str, float], None] | None, what: str) -> Callable[[float], None] | None:
    return None if progress is None else lambda share: progress(what, max(share, 1e-9))


def _fall(
    target: float, line: Line, water: bool, progress: Callable[[float], None] | None
) -> tuple[float | None, str | None]:
    """90 to 10 % when vented, and by what; water by the pumps alone."""
    if not water:
        return released(target, line, progress)
    back = forms.fall_by_pump(target, line, water=True)
    return back, None if back is None else "pumps run backwards"


def _closed_fall(target: float, line: Line, by: str | None, water: bool) -> float | None:
    if by == "valve":
        return None if line.leak.laminar else forms.fall_by_valve(target, line)
    alone = line.leak.laminar == 0 or water
    return forms.fall_by_pump(target, line, water) if by is not None and alone else None


def _of_the_tube(
    line: Line, rise: float, delay: float | None, lag: float | None
) -> list[str]:  # fmt: skip
    """What to say of a tube that delays much, or whose flow is not laminar."""
    tube = line.tube
    out: list[str] = []
    if tube is None or delay is None or lag is None:
        return out
    if delay > MATTERS * rise and not tube.cells:
        out.append(
            f"tube: a pressure wave takes {show(delay, 's')}, {delay / rise:.0%} of the rise; "
            f"tube.cells = {CELLS} counts it"
        )
    if lag > MATTERS * rise:
        out.append(
            f"tube: its resistance makes a lag of {show(lag, 's')} at the target, {lag / rise:.0%} "
            "of the rise, which is counted; a wider or shorter one is faster"
        )
    a = line.site.atmosphere
    number = reynolds(intake(a, line.pump, a) * line.pump.count, tube.bore)
    if number > LAMINAR_UP_TO:
        out.append(
            f"tube: at full flow the Reynolds number is {number:.0f}, above {LAMINAR_UP_TO:.0f}: "
            "turbulent at first, but laminar resistance is counted; it is slower than this"
        )
    return out
