"""`leak` and `pump_down`: what a log of pressure tells of the vacuum line."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.commands.answer import Answer, Quantity, si
from layerjam.commands.quantities import LOG_TIME
from layerjam.device.mount import Site
from layerjam.errors import FileError, QuantityError
from layerjam.identify.logs import leak as leaking
from layerjam.identify.logs import pump_down as emptying
from layerjam.measure.log import PRESSURE, TEMPERATURE, TIME, Log, read_log
from layerjam.measure.options import ReadingOptions
from layerjam.measure.readers.unit_words import convert
from layerjam.units import QuantitySpec, show, spec_of

VOLUME = QuantitySpec("m^3", "volume", lo=1e-10, hi=1e3)
FLOW = QuantitySpec("m^3/s", "flow of the pump", lo=1e-12, hi=10)
COMPLIANCE = QuantitySpec("m^3/Pa", "volume lost per vacuum", lo=-1e-3, hi=1e-3)
ZERO = QuantitySpec("Pa", "reading of the sensor at the atmosphere", lo=-1e6, hi=1e6)
ROOM = 293.15
"""Temperature [K] of the gas where none is given: 20 °C, assumed."""


def temperature_of(text: Quantity | None) -> float | None:
    """Kelvin of "23 °C", "296 K" or a number of kelvin; QuantityError for what is none."""
    if text is None:
        return None
    value = float(text) if isinstance(text, int | float) else None
    if isinstance(text, str):
        match = re.fullmatch(r"\s*([+-]?\d{1,6}(?:\.\d{1,12})?)\s*(\S.{0,15}?)\s*", text)
        known = convert(match[2], "K") if match else None
        if not match or known is None:
            raise QuantityError(
                f"temperature: '{text[:40]}' is no temperature; write '23 °C' or '296 K'"
            )
        value = float(match[1]) * float(known[0]) + known[1]
    if value is None or not 150 <= value <= 600:
        raise QuantityError(
            f"temperature: {value:.4g} K is not allowed; the gas has 150 K to 600 K"
            if value is not None else "temperature: give '23 °C' or '296 K'"
        )  # fmt: skip
    return value


def _absolute(
    log: Log, reading: str | None, atmosphere: float, zero: float
) -> tuple[Any, str, list[str]]:
    """Absolute pressure [Pa], which reading it was, and what to say."""
    kind, says = log.pressure_reference(reading)
    said = []
    if says not in (None, kind):
        said.append(f"{log.name}: its column says {says}; --reading {kind} counts")
    value = log["pressure"] - zero
    made = {"absolute": value, "gauge": atmosphere + value, "vacuum": atmosphere - value}[kind]
    if (made < -0.01 * atmosphere).any():
        raise FileError(
            log.path,
            f"read as {kind}, its pressure falls to {show(float(made.min()), 'Pa')} absolute, "
            "which cannot be: check --reading, the unit and --zero",
        )
    return np.maximum(made, 1.0), kind, said


def read_pressure(
    file: str | Path, reading: str | None, atmosphere: Quantity | None,
    zero: Quantity | None = None, columns: str | None = None, decimal: str | None = None,
    warm: bool = False,
) -> tuple[Log, Any, str, float, list[str]]:  # fmt: skip
    """(log, absolute pressure [Pa] shape (N,), kind of reading, atmosphere [Pa], what to say)."""
    options = ReadingOptions(reading=reading, columns=columns, decimal=decimal)
    site = spec_of(Site, "atmosphere")
    around = 101325.0 if atmosphere is None else si(atmosphere, site, "atmosphere")
    off = 0.0 if zero is None else si(zero, ZERO, "zero")
    log = read_log(file, [TIME, PRESSURE, *[TEMPERATURE] * warm], options)
    absolute, kind, said = _absolute(log, reading, around, off)
    return log, absolute, kind, around, said


def window(start: Quantity | None, end: Quantity | None) -> tuple[float | None, float | None]:
    """Begin and end [s] of what counts; QuantityError where they are the wrong way round."""
    first = None if start is None else si(start, LOG_TIME, "from")
    last = None if end is None else si(end, LOG_TIME, "to")
    if first is not None and last is not None and first >= last:
        raise QuantityError(f"from: {show(first, 's')} is not below to, {show(last, 's')}")
    return first, last


def leak(
    file: str | Path,
    *,
    volume: Quantity | None = None,
    reading: str | None = None,
    temperature: Quantity | None = None,
    atmosphere: Quantity | None = None,
    zero: Quantity | None = None,
    start: Quantity | None = None,
    end: Quantity | None = None,
    columns: str | None = None,
    decimal: str | None = None,
) -> Answer:
    """Leak of a closed chamber from a pressure-hold log.

    `reading` says what the pressure counts from (absolute, gauge, vacuum) where the file does not.
    Without `volume` only rates can be told. Leak rates are at the window's mean pressure, positive
    out of the chamber. A column of temperature is used; else `temperature` is that of the gas all
    the time. `record` is the Leak.
    """
    held = None if volume is None else si(volume, VOLUME, "volume")
    given, span = temperature_of(temperature), window(start, end)
    log, absolute, kind, around, warnings = read_pressure(
        file, reading, atmosphere, zero, columns, decimal, True
    )
    warm: Any = given if given is not None else ROOM
    if "temperature" in log:
        warm = log["temperature"]
        if given is not None:
            warnings.append("the log has a column of temperature, which counts, not --temperature")
    found = leaking.fit_leak(
        log["time"], absolute, atmosphere=around, window=span, temperature=warm
    )
    best = found.fits[found.best]
    warnings += [*found.warnings, *_of_heat(found, "temperature" in log)]
    gas = float(np.mean(warm))
    if held is None:
        warnings.append("without --volume only the rate is known, not the leak")
    elif given is None and "temperature" not in log:
        warnings.append("the gas is taken to have 20 °C for sccm; --temperature says otherwise")
    if not found.distinct:
        warnings.append(
            "the log does not tell the leak's laws apart: the leak near the pressures measured is "
            "known, at others it depends on the law (see models)"
        )
    lean, low, high = best.flow_interval(found.mean, around)
    scaled = [None if held is None else held * v for v in (lean, low, high)]
    if low <= 0 <= high:
        warnings.append("the interval of the leak holds zero: no leak is shown by this log")
    slow, fast = best.series.interval(lambda v: float(v[1]))
    size = 1.0 if found.mean > around else -1.0
    values: dict[str, Any] = {
        "model": found.best,
        "distinct": found.distinct,
        "rate": best.rate,
        "rate_low": slow,
        "rate_high": fast,
        "time_constant": 1 / best.rate if best.rate > 0 else None,
        "time_constant_low": 1 / fast if fast > 0 else None,
        "time_constant_high": 1 / slow if slow > 0 else None,
        "conductance": None if held is None else held * best.rate,
        "leak_rate": scaled[0],
        "leak_rate_low": scaled[1],
        "leak_rate_high": scaled[2],
        "leak_rate_sccm": None if scaled[0] is None else leaking.sccm(scaled[0], gas),
        "pressure_change_rate": -lean,
        "mean_pressure": found.mean,
        "side": "over the atmosphere" if size > 0 else "under the atmosphere",
        "reading": kind,
        "atmosphere": around,
        "zero_fitted": best.zero,
        "temperature": gas,
        "temperature_equivalent": found.heat,
        "window": list(found.window),
        "samples": len(found.time),
        "models": {n: _of_leak(f, found, held) for n, f in found.fits.items()},
        "understood": list(log.understood),
    }
    return Answer(values=values, units=_LEAK_UNITS, warnings=warnings, record=found)


_LEAK_UNITS = {
    **dict.fromkeys(("rate", "rate_low", "rate_high"), "1/s"),
    **dict.fromkeys(("time_constant", "time_constant_low", "time_constant_high", "window"), "s"),
    "conductance": "m^3/s",
    **dict.fromkeys(("leak_rate", "leak_rate_low", "leak_rate_high"), "Pa m^3/s"),
    "leak_rate_sccm": "cm^3/min at 0 °C and 101325 Pa",
    "pressure_change_rate": "Pa/s",
    **dict.fromkeys(("mean_pressure", "atmosphere", "zero_fitted"), "Pa"),
    **dict.fromkeys(("temperature", "temperature_equivalent"), "K"),
    "samples": "1",
}


def _of_leak(fit: leaking.LeakFit, found: leaking.Leak, held: float | None) -> dict[str, Any]:
    empty = leaking.flow(fit.model, 0.0, fit.rate, found.atmosphere)
    return {
        "rate": fit.rate,
        "time_constant": 1 / fit.rate if fit.rate > 0 else None,
        "conductance": None if held is None else held * fit.rate,
        "rmse": fit.series.rmse,
        "worse_by": fit.series.worse_by(found.fits[found.best].series),
        "correlation": fit.series.correlation,
        "leak_rate_at_full_vacuum": None if held is None else held * empty,
    }


def _of_heat(found: leaking.Leak, known: bool) -> list[str]:
    """Whether a change of temperature could have made the log."""
    if known or abs(found.heat) > 10:
        return []
    way = "cooling" if found.heat < 0 else "warming"
    return [
        f"a {way} of {abs(found.heat):.2g} K alone would change the pressure as much as the log "
        "shows; log the temperature too, or hold longer"
    ]


def pump_down(
    file: str | Path,
    with_volume: str | Path | None = None,
    *,
    volume: Quantity | None = None,
    flow: Quantity | None = None,
    added_volume: Quantity | None = None,
    compliance: Quantity | None = None,
    reading: str | None = None,
    atmosphere: Quantity | None = None,
    zero: Quantity | None = None,
    start: Quantity | None = None,
    end: Quantity | None = None,
    columns: str | None = None,
    decimal: str | None = None,
) -> Answer:
    """Volume and pump flow from a pump-down log, as far as it tells them.

    One log gives flow over volume. `volume`, `flow`, or the log `with_volume` of the same line with
    `added_volume` gives both. `compliance` is the volume lost per vacuum, or "fit". `record` is
    (PumpDown, PumpDown or None, the alternative PumpDown or None).
    """
    if (with_volume is None) != (added_volume is None):
        raise QuantityError("added volume: give the second log and --added-volume, or neither")
    known = [
        n for n, v in (("volume", volume), ("flow", flow), ("added volume", added_volume)) if v
    ]
    if len(known) > 1:
        raise QuantityError(f"{known[0]} and {known[1]}: one of them is enough; give one")
    v0 = None if volume is None else si(volume, VOLUME, "volume")
    s0 = None if flow is None else si(flow, FLOW, "flow")
    extra = None if added_volume is None else si(added_volume, VOLUME, "added volume")
    if compliance is not None and extra is not None:
        raise QuantityError("compliance: two logs are compared at constant volume; leave it out")
    span = window(start, end)

    def one(path: str | Path, shrink: float | None = 0.0) -> tuple[Any, str, list[str], Log, float]:
        log, absolute, kind, around, said = read_pressure(
            path, reading, atmosphere, zero, columns, decimal, False
        )
        made = emptying.fit_pump_down(
            log["time"], absolute, atmosphere=around, window=span, shrink=shrink
        )
        return made, kind, said, log, around

    alone, kind, warnings, log, around = one(file)
    constant = alone
    if compliance == "fit":
        alone = one(file, None)[0]
        if not emptying.better_with_shrink(constant, alone):
            warnings.append(
                "a volume that changes with vacuum is not clearly better than a constant one "
                "(AICc); its compliance is not shown by this log"
            )
    elif compliance is not None:
        if v0 is None and s0 is None:
            raise QuantityError("compliance: needs --volume or --flow, or write --compliance fit")
        loss = si(compliance, COMPLIANCE, "compliance")
        shrink = emptying.with_compliance(v0, s0, loss, constant)
        for _ in range(12 if v0 is None else 1):  # the volume follows from the flow, and back
            alone = one(file, shrink)[0]
            shrink = emptying.with_compliance(v0, s0, loss, alone)
    warnings += alone.warnings
    second = None
    knowns: dict[str, emptying.Known | None] = {"volume": None, "flow": None}
    if extra is not None and with_volume is not None:
        second, _, said, _, _ = one(with_volume)
        warnings += [*said, *second.warnings]
        knowns["volume"], knowns["flow"] = emptying.from_two(alone, second, extra)
    elif v0 is not None:
        knowns["flow"] = emptying.flow_of(alone, v0)
    elif s0 is not None:
        knowns["volume"] = emptying.volume_of(alone, s0)
    else:
        warnings.append(
            "one log tells flow over volume only: any pump and volume in this proportion draw the "
            "same curve; give --volume, --flow, or a second log with --added-volume"
        )
    values = _of_pump(alone, second, knowns, v0, s0)
    values |= {
        "identifiable": "flow and volume" if v0 or s0 or extra else "flow/volume",
        "reading": kind, "atmosphere": around, "window": list(alone.window),
        "samples": len(alone.time), "understood": list(log.understood),
    }  # fmt: skip
    warnings.append(
        "the ultimate pressure holds the pump's own limit and the line's leak together; a "
        "pressure-hold log (layerjam leak) tells the leak"
    )
    return Answer(
        values=values, units=_PUMP_UNITS, warnings=warnings,
        record=(alone, second, constant if alone is not constant else None),
    )  # fmt: skip


_PUMP_UNITS = {
    **dict.fromkeys(("rate", "rate_low", "rate_high", "rate_with_volume"), "1/s"),
    "time_constant": "s",
    "window": "s",
    **dict.fromkeys(("volume", "volume_low", "volume_high"), "m^3"),
    **dict.fromkeys(("flow", "flow_low", "flow_high"), "m^3/s"),
    **dict.fromkeys(("ultimate_pressure", "ultimate_pressure_low", "ultimate_pressure_high",
                     "ultimate_vacuum", "start_pressure", "atmosphere", "rmse"), "Pa"),
    **dict.fromkeys(("compliance_ratio", "compliance_ratio_low", "compliance_ratio_high"), "1/Pa"),
    "compliance": "m^3/Pa",
    "samples": "1",
}  # fmt: skip


def _of_pump(
    alone: emptying.PumpDown, second: emptying.PumpDown | None, knowns: Mapping[str, Any],
    volume: float | None, flow: float | None,
) -> dict[str, Any]:  # fmt: skip
    low, high = alone.interval(2)
    ultimate = alone.interval(1)
    shrink = alone.interval(3) if alone.shrink_fitted else (None, None)
    stated = {"volume": volume, "flow": flow}
    out: dict[str, Any] = {
        "rate": alone.rate, "rate_low": low, "rate_high": high,
        "rate_with_volume": second.rate if second else None,
        "time_constant": 1 / alone.rate,
    }  # fmt: skip
    for name, made in knowns.items():
        out[name] = made.value if made else stated[name]
        out[f"{name}_low"], out[f"{name}_high"] = made.interval if made else (None, None)
    base = out["volume"]
    return out | {
        "ultimate_pressure": alone.ultimate,
        "ultimate_pressure_low": ultimate[0],
        "ultimate_pressure_high": ultimate[1],
        "ultimate_vacuum": alone.atmosphere - alone.ultimate,
        "start_pressure": alone.start,
        "compliance_ratio": alone.shrink if alone.shrink else None,
        "compliance_ratio_low": shrink[0],
        "compliance_ratio_high": shrink[1],
        "compliance": alone.shrink * base if base and alone.shrink else None,
        "rmse": alone.series.rmse,
    }
