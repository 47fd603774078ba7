"""Regulator of a vacuum line from command options, and its plant from a recorded step."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from layerjam.bench.control.plant import Plant, linearise_line
from layerjam.bench.control.settings import Regulator
from layerjam.bench.control.tuning import Identified, identify_air, identify_water
from layerjam.brake.commands.arguments import LOG_TIME
from layerjam.brake.commands.lines import ONLY_COMPLIANCE, Fluid
from layerjam.brake.fluid.line import Sensor
from layerjam.brake.fluid.line_file import LineFile
from layerjam.brake.fluid.tube import wave_delay
from layerjam.core.command.declare import Help, options
from layerjam.core.command.log_options import LogOptions
from layerjam.core.errors import FitError, Notice, QuantityError, count_text
from layerjam.core.units import get_spec, show
from layerjam.laboratory.measure.trace import Array

SAMPLE_TIME = replace(get_spec(Regulator, "sample_time"), example="20ms")
SENSOR_RANGE = replace(get_spec(Sensor, "range"), example="103kPa")
NOISE = replace(get_spec(Sensor, "noise"), example="50Pa")
LEAST_RUN = replace(get_spec(Regulator, "minimum_on"), example="0.2s")
FAR_OFF = 1.2
"""Ratio of identified to expected rate above which a notice is given."""
FELT = 1.05
"""Ratio of time constants with and without the tube, above which a step is not exponential."""
FEWEST = 20
"""Minimum number of samples in a step."""


@options
class RegulatorSettings:
    """Settings of the controller and of the sensor."""

    safe_state: Annotated[
        Literal["release", "hold"] | None,
        Help("Safe state after a fault: vented, or with the valves closed. Required."),
    ] = None
    kind: Annotated[Literal["bang-bang", "pi", "scheduled"], Help("Control law.")] = "pi"
    fluid: Fluid = "air"
    sample_time: Annotated[
        float | None, SAMPLE_TIME, Help("Sampling interval. Default: 10 ms.")
    ] = None
    sensor_range: Annotated[float | None, SENSOR_RANGE, Help("Measuring range of the sensor.")] = (
        None
    )
    noise: Annotated[float | None, NOISE, Help("Standard deviation of a sensor reading.")] = None
    reversible: Annotated[bool, Help("Reduce the vacuum by running the pump backwards.")] = False
    least_run: Annotated[
        float | None, LEAST_RUN, Help("Minimum run time and rest time of the pump.")
    ] = None


@options
class RecordedStep:
    """A log of the real line while its pump runs at full command from rest."""

    step: Annotated[
        str | Path | None,
        Help("Log of the real line with the pump at full power, to tune the controller.", "FILE"),
    ] = None
    reading: Annotated[
        Literal["absolute", "gauge", "vacuum"] | None,
        Help("Pressure reference of the log."),
    ] = None
    start: Annotated[
        float | None, LOG_TIME, Help("Start of the step in the log.", option="--from")
    ] = None
    end: Annotated[
        float | None, LOG_TIME, Help("Time at which the pump stops in the log.", option="--to")
    ] = None


def make_regulator(
    file: LineFile, vacuum: float, settings: RegulatorSettings
) -> tuple[Regulator, list[Notice]]:
    """Return a controller for a line linearised at a vacuum [Pa], and its assumptions."""
    plant = linearise_line(file.line, vacuum=vacuum, water=settings.fluid == "water")
    sensor = make_sensor(file, settings.sensor_range, settings.noise)
    notices, run = [*file.warnings(), *_omission_notices(file, plant)], settings.least_run
    regulator = Regulator(
        plant=plant,
        sensor=sensor,
        kind=settings.kind,
        safe_state=settings.safe_state or "",
        # without a valve, the vacuum can be lowered only by reversing the pump
        reversible=settings.reversible or (file.line.valve is None and plant.backwards > 0),
        tuned_at=vacuum,
        **_known_options(sample_time=settings.sample_time, minimum_on=run, minimum_off=run),
    )
    return regulator, notices


def make_sensor(file: LineFile, span: float | None, noise: float | None = None) -> Sensor:
    """Return a line's sensor with a given range and noise [Pa]; a missing range is an error."""
    if file.line.sensor is None and span is None:
        raise QuantityError.of(
            "sensor", f"{file.name} has no sensor; give the range of yours (--sensor-range)"
        )
    return replace(file.line.sensor or Sensor(range=1.0), **_known_options(range=span, noise=noise))


def _omission_notices(file: LineFile, plant: Plant) -> Iterator[Notice]:
    """Yield notices about a missing valve, and effects of tube and reservoir that are neglected."""
    line = file.line
    if not plant.vent or line.valve is None:
        yield Notice(
            f"{file.name} has no valve: it is vented by running the pumps backwards, "
            "so a pump fault prevents release",
            "no-valve",
        )
    if plant.water and line.tube is not None:
        yield ONLY_COMPLIANCE
    if plant.passage is not None and line.tube is not None and line.tube.cells:
        delay = wave_delay(line.tube, line.polytropic)
        yield Notice(
            "tube: its resistance and gas are modelled, its cells are not; a pressure wave "
            f"takes {show(delay, 's')}",
            "tube-waves",
        )
    if line.reservoir is not None:
        yield Notice(
            "reservoir: its valve stays closed, because the controller acts only on pump and vent",
            "reservoir-closed",
        )


def _known_options(**values: Any) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}


def _check_step(plant: Plant) -> None:
    """Raise QuantityError if, because of the tube, a step is not a single exponential."""
    tube = plant.passage
    if tube is None or plant.time_constant(tube.vacuum) < FELT / (plant.rate + plant.leak):
        return
    raise QuantityError.of(
        "step",
        f"the line's tube adds a lag of {show(tube.filling_time(tube.vacuum), 's')} at "
        f"{show(tube.vacuum, 'Pa')} and {tube.volume:.3g} of the chamber's gas. A step is then "
        "not a single exponential, and pump and tube cannot be distinguished. Omit --step, or "
        "record the step with the pump at the brake and give a line without [tube]",
    )


def tune_from_step(
    regulator: Regulator,
    step: str | Path,
    options: RecordedStep,
    atmosphere: float,
    keep_noise: bool,
) -> tuple[Regulator, Identified, list[str]]:
    """Return the controller with the plant identified from a step.

    Leak and vent are those of the line.

    The scatter of the readings about the fit becomes the sensor's noise unless `keep_noise`. Raises
    FileError if the log cannot be read or contains no step.
    """
    _check_step(regulator.plant)
    from layerjam.laboratory.commands.pressure_log import check_window, read_pressure

    first, last = check_window(options.start, options.end)
    old: Plant = regulator.plant

    def identify(time: Array, absolute: Array, atmosphere: float) -> Identified:
        is_inside = (time >= (-np.inf if first is None else first)) & (
            time <= (np.inf if last is None else last)
        )
        if is_inside.sum() < FEWEST:
            count = int(is_inside.sum())
            raise FitError(
                f"{count_text(count, 'sample')} between --from and --to; {FEWEST} are needed"
            )
        time, vacuum = time[is_inside], atmosphere - absolute[is_inside]
        try:
            if old.water:
                return identify_water(time, vacuum, vent=old.vent, top=old.top, leak=old.leak)
            return identify_air(time, vacuum, vent=old.vent, leak=old.leak, atmosphere=atmosphere)
        except FitError as error:
            raise FitError(
                f"{error}; a step needs the pump at full power from rest (--from, --to)"
            ) from None

    read = read_pressure(step, LogOptions(reading=options.reading), atmosphere, test=identify)
    log = read.log
    fit = identify(log["time"], read.absolute, atmosphere)
    notices = [*read.notices]
    plant = replace(fit.plant, backwards=old.backwards)
    ratio = plant.rate / old.rate
    if not 1 / FAR_OFF < ratio < FAR_OFF:
        notices.append(
            Notice(
                f"the step's rate of {show(plant.rate, '1/s')} is {ratio:.3g} times that "
                f"of the line file, {show(old.rate, '1/s')}; the step takes precedence",
                "step-far-off",
            )
        )
    sentence = (
        f"tuned to the step in {log.name} ({'; '.join(log.understood)}); leak and vent are from "
        "the line file"
    )
    sensor = regulator.sensor if keep_noise else replace(regulator.sensor, noise=fit.noise)
    regulator_tuned = replace(regulator, plant=plant, sensor=sensor)
    return regulator_tuned, fit, [*notices, Notice(sentence, "tuned-to-step")]
