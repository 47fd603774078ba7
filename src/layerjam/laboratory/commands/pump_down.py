"""`pump-down`: volume and pump flow from pump-down logs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.brake.commands.arguments import Accept, Atmosphere
from layerjam.brake.fluid.line import Pump
from layerjam.core.command.declare import Help, command
from layerjam.core.command.log_options import LogOptions
from layerjam.core.command.results import Figure, Judged, fact, number, result
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.outputs import bounds
from layerjam.core.units import QuantitySpec, get_spec
from layerjam.core.verdict import judge
from layerjam.laboratory.commands.pressure_log import (
    VOLUME,
    End,
    LogFile,
    PressureLog,
    Start,
    Zero,
    check_window,
    format_span,
    read_pressure,
)

if TYPE_CHECKING:
    from layerjam.laboratory.identify.logs.pump_down import DerivedValue, PumpDown

FLOW = replace(get_spec(Pump, "flow"), text="flow of the pump", example="20mL/s")
COMPLIANCE = QuantitySpec(
    "m^3/Pa", "compliance of the pumped volume", lo=-1e-3, hi=1e-3, example="0.01mL/kPa"
)

PROPORTION = (
    "one log determines only the ratio of flow to volume: any pump and volume with this ratio fit "
    "it; give --volume, --flow, or a second log with --added-volume"
)
LIMIT_AND_LEAK = (
    "the ultimate pressure combines the pump's own limit and the leak of the line; a "
    "pressure-hold log (layerjam leak) shows the leak alone"
)
NO_COMPLIANCE = (
    "a volume that changes with vacuum does not fit clearly better than a constant one "
    "(AICc); this log does not show its compliance"
)


@result
class PumpFound(Judged):
    """Volume and pump flow, as far as the logs determine them.

    `record` is (PumpDown, PumpDown with the added volume or None, PumpDown of a constant volume or
    None). The last element is None unless a compliance is used.
    """

    record: tuple[PumpDown, PumpDown | None, PumpDown | None]
    rate: float = number("1/s", "ratio of flow to volume", interval=True)
    rate_with_volume: float | None = number("1/s", "ratio of flow to volume, with the added volume")
    time_constant: float = number("s", "time constant of the pump-down")
    volume: float | None = number("m^3", "pumped volume", interval=True)
    flow: float | None = number("m^3/s", "flow of the pump", interval=True)
    ultimate_pressure: float = number(
        "Pa", "absolute pressure that the pump reaches", interval=True
    )
    ultimate_vacuum: float = number("Pa", "vacuum that the pump reaches")
    start_pressure: float = number("Pa", "absolute pressure at the start")
    compliance_ratio: float | None = number("1/Pa", "relative compliance", interval=True)
    compliance: float | None = number("m^3/Pa", "compliance of the pumped volume")
    rmse: float = number("Pa", "root mean square error")
    identifiable: str = fact("quantities that the logs determine")
    reading: str = fact("pressure reference")
    atmosphere: float = number("Pa", "atmospheric pressure at the site")
    window: Sequence[float] = number("s", "part of the log used", shown=format_span)
    samples: int = number("1", "samples used", listed=False)
    understood: Sequence[str] = fact("how the file was read", listed=False)

    def draw(self) -> Figure:
        """Return the figure of pressure versus time with the fit."""
        from layerjam.core.drawing.style import mark_figure
        from layerjam.laboratory.figures import measurement_figures

        single_fit, second, constant = self.record
        return mark_figure(
            measurement_figures.draw_pump_down(single_fit, second, constant), self.synthetic
        )


@command("vacuum")
def pump_down(
    file: LogFile,
    with_volume: Annotated[
        str | Path | None, Help("The same line with a known volume added.", metavar="FILE2")
    ] = None,
    *,
    volume: Annotated[float | None, VOLUME, Help("Pumped volume, if known.")] = None,
    flow: Annotated[float | None, FLOW, Help("Flow of the pump, if known.")] = None,
    added_volume: Annotated[float | None, VOLUME, Help("Volume added for FILE2.")] = None,
    compliance: Annotated[
        float | Literal["fit"] | None,
        COMPLIANCE,
        Help("Volume lost per unit vacuum, or 'fit' to fit it too."),
    ] = None,
    zero: Zero = None,
    start: Start = None,
    end: End = None,
    accept: Accept = None,
    atmosphere: Atmosphere = None,
    options: LogOptions = LogOptions(),
) -> PumpFound:
    """Fit the volume and the pump flow to pump-down logs, as far as the logs determine them.

    One log determines only the ratio of flow to volume. `volume`, `flow`, or the log `with_volume`
    of the same line with `added_volume` determine both. `compliance` is the volume lost per unit of
    vacuum, or "fit".
    """
    from layerjam.laboratory.identify.logs.log_checks import check_pump_downs
    from layerjam.laboratory.identify.logs.pump_down import fit_pump_down, is_flexible_better

    if (with_volume is None) != (added_volume is None):
        raise QuantityError("added volume: give the second log and --added-volume, or neither")
    names_given = _list_given_options(volume, flow, added_volume, compliance)
    span = check_window(start, end)

    def fit_log(path: str | Path, shrink: float | None = 0.0) -> tuple[PumpDown, PressureLog]:
        read = _read_pump_log(path, options, atmosphere, zero, span)
        time, around = read.log["time"], read.atmosphere
        with read.log.locate_errors():
            fit = fit_pump_down(time, read.absolute, atmosphere=around, window=span, shrink=shrink)
        return fit, read

    first, read = fit_log(file)
    single_fit, constant, second, warnings = first, None, None, list(read.notices)
    zeros = list(read.check_vented(first.ultimate, "the ultimate vacuum"))
    if compliance is not None:
        constant = first
        single_fit = _fit_compliance(first, compliance, volume, flow, lambda s: fit_log(file, s)[0])
        if compliance == "fit" and not is_flexible_better(first, single_fit):
            warnings.append(Notice(NO_COMPLIANCE, "no-compliance"))
    if with_volume is not None:
        second, alternative = fit_log(with_volume)
        warnings += alternative.notices
        zeros += alternative.check_vented(second.ultimate, "the ultimate vacuum")
    if not names_given:
        warnings.append(Notice(PROPORTION, "flow-over-volume"))
    numbers = _compute_pump_results(single_fit, second, volume, flow, added_volume)
    logs = [log for log in (single_fit, second) if log is not None]
    checks = check_pump_downs(logs, dict(_list_intervals({**numbers, "rate": single_fit.rate})))
    return PumpFound.create(
        numbers,
        single_fit,
        single_fit.series,
        read,
        judge([*checks, *zeros], accept),
        identifiable="flow and volume" if names_given else "flow/volume",
        samples=len(single_fit.time),
        warnings=[*warnings, Notice(LIMIT_AND_LEAK, "limit-and-leak")],
        record=(single_fit, second, constant),
    )


def _read_pump_log(
    path: str | Path,
    options: LogOptions,
    atmosphere: float | None,
    zero: float | None,
    span: tuple[float | None, float | None],
) -> PressureLog:
    """Return a log whose pressure falls while the pump runs, as read by `read_pressure`."""
    from layerjam.laboratory.identify.logs.pump_down import select_pump_down

    test = partial(select_pump_down, window=span)
    return read_pressure(path, options, atmosphere, zero, test=test)


def _list_given_options(volume: Any, flow: Any, added_volume: Any, compliance: Any) -> list[str]:
    """Return the quantities given in addition to the log; QuantityError if there are several."""
    numbers = {"volume": volume, "flow": flow, "added volume": added_volume}
    names = [name for name, value in numbers.items() if value is not None]
    if len(names) > 1:
        raise QuantityError(f"{names[0]} and {names[1]}: give only one of them")
    if compliance is not None and added_volume is not None:
        raise QuantityError("compliance: two logs are compared at constant volume; omit it")
    return names


def _fit_compliance(
    constant: PumpDown,
    compliance: Any,
    volume: float | None,
    flow: float | None,
    fit_with: Callable[[float | None], PumpDown],
) -> PumpDown:
    """Return the fit with a volume that shrinks under vacuum, by `compliance` [m^3/Pa] or "fit"."""
    from layerjam.laboratory.identify.logs.pump_down import compliance_ratio

    if compliance == "fit":
        return fit_with(None)
    if volume is None and flow is None:
        raise QuantityError("compliance: requires --volume or --flow, or use --compliance fit")
    fit = constant
    for _ in range(12 if volume is None else 1):  # the flow determines the volume, and vice versa
        fit = fit_with(compliance_ratio(volume, flow, compliance, fit))
    return fit


def _compute_pump_results(
    first: PumpDown,
    second: PumpDown | None,
    volume: float | None,
    flow: float | None,
    volume_added: float | None,
) -> dict[str, Any]:
    """Return the values of pump and volume that the fits determine."""
    from layerjam.laboratory.identify.logs.pump_down import chamber_volume, combine_logs, pump_flow

    derivations: dict[str, DerivedValue] = {}
    if second is not None and volume_added is not None:
        derivations["volume"], derivations["flow"] = combine_logs(first, second, volume_added)
    elif volume is not None:
        derivations["flow"] = pump_flow(first, volume)
    elif flow is not None:
        derivations["volume"] = chamber_volume(first, flow)
    values = {name: entry.value for name, entry in derivations.items()}
    base = values.get("volume", volume)
    return {
        **bounds(rate=first.interval(2), ultimate_pressure=first.interval(1)),
        **bounds(compliance_ratio=first.interval(3) if first.shrink_fitted else None),
        **bounds(**{name: entry.interval for name, entry in derivations.items()}),
        **{"volume": volume, "flow": flow, **values},
        "rate_with_volume": second and second.rate,
        "time_constant": 1 / first.rate,
        "ultimate_pressure": first.ultimate,
        "ultimate_vacuum": first.atmosphere - first.ultimate,
        "start_pressure": first.start,
        "compliance_ratio": first.shrink or None,
        "compliance": first.shrink * base if base and first.shrink else None,
    }


def _list_intervals(numbers: Mapping[str, Any]) -> Iterator[tuple[str, tuple[float, float, float]]]:
    """Yield (quantity, (value, low, high)) of positive quantities with a 95 % interval."""
    for name in ("rate", "ultimate_pressure", "volume", "flow"):
        value, low, high = (numbers.get(f"{name}{end}") for end in ("", "_low", "_high"))
        if value is not None and low is not None and high is not None:
            yield name.replace("_", " "), (value, low, high)
