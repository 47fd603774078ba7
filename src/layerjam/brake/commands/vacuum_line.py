"""`rise`: rise and fall of the vacuum in a line."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from layerjam.brake.commands.arguments import Atmosphere, Target, check_vacuum
from layerjam.brake.commands.lines import ONLY_COMPLIANCE, Fluid, LineInput
from layerjam.brake.fluid.line import Line, Tube, water_compliance
from layerjam.brake.fluid.line_file import LineFile
from layerjam.core.command.declare import Progress, command
from layerjam.core.command.results import Figure, Result, fact, number, result
from layerjam.core.errors import Notice
from layerjam.core.units import show

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from layerjam.brake.fluid.closed_forms import Filling
    from layerjam.brake.fluid.network import Response
    from layerjam.core.drawing.chart import Pane

MATTERS = 0.05
"""Fraction of the rise time above which the delay of the tube is reported."""
CELLS = 10
"""Suggested number of tube cells, which resolves a wave front to a tenth of the length."""


@result
class VacuumRise(Result):
    """Rise and fall of the vacuum; `record` is the Response in air, a Filling in water."""

    record: "Response | Filling"
    rise_time: float | None = number("s", "time from 10 to 90 % of the target")
    time_constant: float = number("s", "time constant of pump and chamber")
    fall_time: float | None = number("s", "time from 90 to 10 % of the target when vented")
    fall_by: str | None = fact("device that vents the line: the valve, or the pumps run backwards")
    feasible: bool = fact("whether the target is reached", shown=lambda yes: "" if yes else "no")
    reason: str | None = fact("reason if it is never reached")
    reachable: float = number("Pa", "highest vacuum that the line reaches")
    target: float = number("Pa", "target vacuum")
    fluid: str = fact("fluid in the line")
    closed_form: float | None = number("s", "rise time by the closed form, if valid")
    closed_form_fall: float | None = number("s", "fall time by the closed form, if valid")
    gas_work: float | None = number("J", "work done on the gas up to the target")
    tube_delay: float | None = number("s", "travel time of a pressure wave along the tube")
    tube_lag: float | None = number("s", "time constant of tube and chamber at the target")
    line: LineFile

    def draw_panes(self, panes: "Sequence[Pane]") -> Figure:
        """Return vacuum versus time, and ways to make the line faster."""
        from layerjam.brake.figures import fluid_figures

        line, water = self.line.line, self.fluid == "water"
        return fluid_figures.draw_rise(panes[0], line, self.target, water)

    def panes(self) -> "Sequence[Pane]":
        """Return vacuum versus time up to the target."""
        from layerjam.brake.figures import fluid_figures

        return fluid_figures.make_rise_pane(self.line, self.target, self.record, self.rise_time)


@command("vacuum")
def rise(
    line: LineInput,
    *,
    target: Target,
    fluid: Fluid = "air",
    atmosphere: Atmosphere = None,
    progress: Progress | None = None,
) -> VacuumRise:
    """Compute the time in which a line reaches a vacuum, and the time in which it releases it.

    The pump runs at full power until the target is reached. If it is never reached, `rise_time` is
    None, `feasible` False and `reason` states the vacuum that can be reached. In air the line is
    integrated; `closed_form` holds for a rigid volume without an effect of tube or orifice.
    `fall_time` and `closed_form_fall` count from the opening of the vent valve or the reversal of a
    pump (`fall_by`); None if the line has neither. `tube_delay` and `tube_lag` are None in water
    and for a line that has no tube. A tube with many cells takes a long time to compute.
    """
    from layerjam.brake.fluid import closed_forms as forms
    from layerjam.brake.fluid.network import respond
    from layerjam.brake.fluid.timing import air_fall_time, air_rise_time
    from layerjam.brake.fluid.tube import filling_lag, wave_delay
    from layerjam.brake.fluid.vacuum_energy import jam_work

    pipe, water = line.line, fluid == "water"
    check_vacuum(target, pipe, "target")
    if water:
        water_compliance(pipe)
    response: Response | Filling | None = None
    if water:
        rise_time = forms.rise_time(target, pipe, True)
    else:
        rise_time, response = air_rise_time(target, pipe, _label_progress(progress, "rise"))
    fall_time, fall_means = None, None
    if rise_time is not None and water:
        fall_time = forms.fall_by_pump(target, pipe, water=True)
        fall_means = None if fall_time is None else "pumps run backwards"
    elif rise_time is not None:
        fall_time, fall_means = air_fall_time(target, pipe, _label_progress(progress, "fall"))
    if response is None:  # in air, this is the vacuum reached if the target is never reached
        response = (
            forms.filling(target, pipe) if water else respond(pipe, 8 * forms.time_constant(pipe))
        )
    low, closed_form = forms.reachable_vacuum(pipe, water), water or forms.has_closed_form(pipe)
    notices = [*line.warnings(), *([ONLY_COMPLIANCE] if water else [])]
    delay, lag = None, None
    if pipe.tube is not None and not water:
        delay = wave_delay(pipe.tube, pipe.polytropic)
        lag = filling_lag(pipe, pipe.site.atmosphere - target)
        if rise_time is not None:
            notices += _tube_notices(pipe, pipe.tube, rise_time, delay, lag)
    return VacuumRise(
        rise_time=rise_time,
        time_constant=forms.time_constant(pipe, water),
        fall_time=fall_time,
        fall_by=fall_means,
        feasible=rise_time is not None,
        reason=None if rise_time is not None else _explain_failure(pipe, target, low, water),
        reachable=low,
        target=target,
        fluid=fluid,
        closed_form=forms.rise_time(target, pipe, water) if closed_form else None,
        closed_form_fall=_fall_time(target, pipe, fall_means, water) if closed_form else None,
        gas_work=None if rise_time is None else jam_work(target, pipe, water),
        tube_delay=delay,
        tube_lag=lag,
        warnings=notices,
        record=response,
        line=line,
    )


def _explain_failure(line: Line, target: float, low: float, water: bool) -> str:
    from layerjam.brake.fluid.flow import VAPOUR

    if water and line.pump.ultimate < VAPOUR:
        cause = f"the water boils ({show(VAPOUR, 'Pa')} at 20 °C)"
    elif line.leak.laminar or line.leak.orifice:
        cause = "pump and leak balance"
    else:
        cause = "the pump reaches its ultimate pressure"
    return f"{show(target, 'Pa')} is never reached: at {show(low, 'Pa')}, {cause}"


def _label_progress(progress: Progress | None, label: str) -> "Callable[[float], None] | None":
    return None if progress is None else lambda share: progress(label, max(share, 1e-9))


def _fall_time(target: float, line: Line, device: str | None, water: bool) -> float | None:
    from layerjam.brake.fluid import closed_forms as forms

    if device == "valve":
        return None if line.leak.laminar else forms.fall_by_valve(target, line)
    is_alone = line.leak.laminar == 0 or water
    return forms.fall_by_pump(target, line, water) if device is not None and is_alone else None


def _tube_notices(
    line: Line, tube: Tube, rise: float, delay: float, lag: float
) -> Iterator[Notice]:
    """Yield notices about a tube with a long delay or with a flow that is not laminar."""
    from layerjam.brake.fluid.pump import pump_throughput
    from layerjam.brake.fluid.tube import LAMINAR_UP_TO, reynolds_number

    if delay > MATTERS * rise and not tube.cells:
        yield Notice(
            f"tube: a pressure wave takes {show(delay, 's')} to cross it, {delay / rise:.0%} "
            f"of the rise; set tube.cells = {CELLS} to include it",
            "tube-delay",
        )
    if lag > MATTERS * rise:
        yield Notice(
            f"tube: its resistance causes a lag of {show(lag, 's')} at the target, "
            f"{lag / rise:.0%} of the rise, which is included; a wider or shorter "
            "tube is faster",
            "tube-lag",
        )
    a = line.site.atmosphere
    flow = reynolds_number(pump_throughput(a, line.pump, a) * line.pump.count, tube.bore)
    if flow > LAMINAR_UP_TO:
        yield Notice(
            f"tube: at full flow the Reynolds number is {flow:.0f}, above "
            f"{LAMINAR_UP_TO:.0f}: the flow is turbulent at first, but laminar "
            "resistance is assumed; the real line is slower than this",
            "turbulent",
        )
