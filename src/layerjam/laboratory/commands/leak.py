"""`leak`: leak rate of a closed chamber from a pressure-hold log."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from layerjam.brake.commands.arguments import Accept, Atmosphere
from layerjam.core.command.declare import Help, command
from layerjam.core.command.log_options import LogOptions
from layerjam.core.command.results import Figure, Judged, fact, number, result
from layerjam.core.errors import Notice
from layerjam.core.outputs import bounds
from layerjam.core.verdict import judge
from layerjam.laboratory.commands.pressure_log import (
    ROOM,
    VOLUME,
    End,
    LogFile,
    Start,
    Temperature,
    Zero,
    check_window,
    format_span,
    read_pressure,
)

if TYPE_CHECKING:
    from layerjam.laboratory.identify.logs.leak import Leak, LeakFit


@result
class LeakFound(Judged):
    """Leak of a closed chamber, according to the law that fits the log best; `record` is the Leak.

    Leak rates apply at the window's mean pressure and are positive out of the chamber; they are
    None if no volume is given.
    """

    record: "Leak"
    model: str = fact("law that fits best")
    distinct: bool = fact("whether it fits clearly better than the others")
    rate: float = number("1/s", "ratio of conductance to volume", listed=False, interval=True)
    time_constant: float | None = number("s", "time constant of the leak", interval=True)
    conductance: float | None = number("m^3/s", "conductance of the leak")
    leak_rate: float | None = number("Pa m^3/s", "leak rate at the mean pressure", interval=True)
    leak_rate_sccm: float | None = number("cm^3/min at 0 °C and 101325 Pa", "leak rate in sccm")
    pressure_change_rate: float = number("Pa/s", "rate of pressure change there")
    mean_pressure: float = number("Pa", "mean absolute pressure of the window")
    side: str = fact("whether the mean pressure is above or below atmospheric pressure")
    reading: str = fact("pressure reference")
    atmosphere: float = number("Pa", "atmospheric pressure at the site")
    zero_fitted: float | None = number("Pa", "fitted zero of the sensor")
    temperature: float = number("K", "temperature of the gas")
    temperature_equivalent: float = number("K", "temperature change with the same effect")
    window: Sequence[float] = number("s", "part of the log used", shown=format_span)
    samples: int = number("1", "samples used")
    models: Mapping[str, Any] = fact("every fitted law", listed=False)
    understood: Sequence[str] = fact("how the file was read", listed=False)

    def lines(self) -> Iterator[str]:
        """Yield one line per law."""
        yield ""
        for name, fit in self.models.items():
            constant = f"{fit['time_constant']:.4g} s" if fit["time_constant"] else "none"
            yield f"{name}: time constant {constant}, RMSE {fit['rmse']:.3g} Pa"

    def draw(self) -> Figure:
        """Return the figure of pressure versus time with the fitted laws."""
        from layerjam.core.drawing.style import mark_figure
        from layerjam.laboratory.figures import measurement_figures

        return mark_figure(measurement_figures.draw_leak(self.record), self.synthetic)


@command("vacuum")
def leak(
    file: LogFile,
    *,
    volume: Annotated[float | None, VOLUME, Help("Volume of the chamber and its line.")] = None,
    temperature: Temperature = None,
    zero: Zero = None,
    start: Start = None,
    end: End = None,
    accept: Accept = None,
    atmosphere: Atmosphere = None,
    options: LogOptions = LogOptions(),
) -> LeakFound:
    """Fit the leak of a closed chamber to a pressure-hold log.

    `reading` is the pressure reference (absolute, gauge, vacuum) if the file does not state it.
    Without `volume`, only rates can be determined. A temperature column is used if present;
    otherwise the gas has the constant `temperature`.
    """
    from layerjam.laboratory.identify.logs.leak import fit_leak, select_hold, to_sccm
    from layerjam.laboratory.identify.logs.log_checks import check_leak

    span = check_window(start, end)
    test = partial(select_hold, window=span)
    read = read_pressure(file, options, atmosphere, zero, warm=True, test=test)
    log, around = read.log, read.atmosphere
    logged = "temperature" in log
    warm: Any = log["temperature"] if logged else ROOM if temperature is None else temperature
    with log.locate_errors():
        fit = fit_leak(log["time"], read.absolute, atmosphere=around, window=span, temperature=warm)
    best = fit.fits[fit.best]
    lean, low, high = best.flow_interval(fit.mean, around)
    slow, fast = best.rate_interval()
    gas = float(np.mean(warm))

    def flow_at_rate(rate: float) -> float | None:
        return None if volume is None else volume * rate

    leaks = flow_at_rate(lean)
    checks = list(check_leak(fit, best, logged))
    if best.zero is None:
        checks += read.check_vented(fit.mean, "the time constant")
    unsure = _leak_notices(fit, volume is None, logged, temperature is not None)
    return LeakFound.create(
        best,
        fit,
        read,
        judge(checks, accept),
        **bounds(rate=(slow, fast), time_constant=(_time_constant(fast), _time_constant(slow))),
        **bounds(leak_rate=(flow_at_rate(low), flow_at_rate(high))),
        time_constant=_time_constant(best.rate),
        conductance=flow_at_rate(best.rate),
        leak_rate=leaks,
        leak_rate_sccm=None if leaks is None else to_sccm(leaks, gas),
        pressure_change_rate=-lean,
        mean_pressure=fit.mean,
        side="over the atmosphere" if fit.mean > around else "under the atmosphere",
        zero_fitted=best.zero,
        temperature=gas,
        temperature_equivalent=fit.heat,
        samples=len(fit.time),
        models={n: _leak_results(f, fit, volume) for n, f in fit.fits.items()},
        warnings=[*read.notices, *fit.warnings, *unsure],
        record=fit,
    )


def _time_constant(rate: float) -> float | None:
    return 1 / rate if rate > 0 else None


def _leak_notices(result: "Leak", no_volume: bool, logged: bool, given: bool) -> Iterator[Notice]:
    """Yield notices of unknown numbers, each with the measurement that would determine it."""
    if logged and given:
        sentence = "the log has a temperature column, which overrides --temperature"
        yield Notice(sentence, "temperature-logged")
    if no_volume:
        yield Notice("without --volume only the rate is known, not the leak", "no-volume")
    elif not (given or logged):
        sentence = "sccm assumes a gas temperature of 20 °C; set --temperature if it differs"
        yield Notice(sentence, "temperature-assumed")
    if not result.distinct:
        yield Notice(
            "the log does not distinguish the leak laws: the leak is known near the "
            "measured pressures; elsewhere it depends on the law (see models)",
            "laws-alike",
        )


def _leak_results(fit: "LeakFit", result: "Leak", volume_factor: float | None) -> dict[str, Any]:
    from layerjam.laboratory.identify.logs.leak import flow

    empty = flow(fit.model, 0.0, fit.rate, result.atmosphere)
    return {
        "rate": fit.rate,
        "time_constant": _time_constant(fit.rate),
        "conductance": None if volume_factor is None else volume_factor * fit.rate,
        "rmse": fit.series.rmse,
        "worse_by": fit.series.excess_over(result.fits[result.best].series),
        "correlation": fit.series.correlation,
        "leak_rate_at_full_vacuum": None if volume_factor is None else volume_factor * empty,
    }
