"""`bench check` and `bench zero`: tests of wiring, leaks and sensor zero before the first run."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Literal

from layerjam.bench.commands.bench import BenchAddress
from layerjam.bench.commands.regulator import SENSOR_RANGE, make_sensor
from layerjam.bench.rig.outcomes import Checked, Zero
from layerjam.brake.commands.arguments import Overwrite
from layerjam.brake.commands.lines import convert_line
from layerjam.brake.fluid.line import Line, Sensor
from layerjam.brake.fluid.line_file import LineFile
from layerjam.core.command.declare import Help, Input, OutFile, command
from layerjam.core.command.results import Result, fact, result
from layerjam.core.errors import QuantityError
from layerjam.core.store import store_file
from layerjam.core.system import format_command_line
from layerjam.core.toml_files.changes import collect_values
from layerjam.core.toml_files.source import Source
from layerjam.core.units import build, show

MEASURED = MappingProxyType({"rate": "1/s", "top": "Pa", "leak": "1/s", "vent": "1/s", "lag": "s"})
"""Values of a line that `bench check` measures, and their units."""
REPLACED = (
    "pump.flow",
    "pump.ultimate",
    "valve.conductance",
    "leak.laminar",
    "sensor.lag",
    "sensor.noise",
)
"""Fields of a line file that the measured values replace."""
FIRST_RUN = (
    *("--procedure", "evacuate to 20 kPa and hold 5 s; vent"),
    *("--brake", "choi2018-kapton", "--out", "first-run.ljrun"),
)
"""Options of a first run that do not depend on the bench."""
DIGITS = 4
"""Number of significant digits written; the fits are accurate to about 1 %."""


@result
class BenchChecked(Result, Checked):
    """Result of a bench check."""

    tuned: str | None = fact("file of the measured line; null unless --tune is given", default=None)
    next_step: str | None = fact("next command to run", listed=False, default=None)

    def lines(self) -> Iterator[str]:
        """Yield each measured value with the value for which the controller is tuned."""
        if self.expected is not None:
            yield ""
            for name, unit in MEASURED.items():
                value = getattr(self, name)
                value_text = "not measured" if value is None else f"measured {show(value, unit)}"
                yield f"{name}: {value_text}, controller tuned to {show(self.expected[name], unit)}"
        if self.next_step is not None:
            yield from ("", "next:", f"  {self.next_step}")


VentRest = Annotated[
    Literal["open", "closed"] | None,
    Help("Position of the vent valve when unpowered. Required if the board has not stored it."),
]


@result
class BenchZeroed(Result, Zero):
    """Zero of a bench's sensor."""


@command("bench", parent="bench")
def bench_zero(address: BenchAddress, *, vent_rest: VentRest = None) -> BenchZeroed:
    """Measure the sensor's zero with the brake vented, and store it on the board.

    The vent is open for 4.5 s; the mean of the last second is the zero. The board stores it, with
    the date in the calibration's name. Raises QuantityError if the reading is not steady or is far
    from zero, LockedError if another client has the lock, InstrumentError for a bench that is not
    in SAFE.
    """
    from layerjam.bench.rig.check import limit_speed, measure_zero
    from layerjam.bench.rig.driver import open_bench

    with open_bench(limit_speed(address)) as bench:
        return BenchZeroed.create(measure_zero(bench, vent_rest=vent_rest))


@command("bench", parent="bench")
def bench_check(
    address: BenchAddress,
    *,
    line: Annotated[
        LineFile | None,
        Input("Expected vacuum line: name or TOML file.", metavar="LINE", convert=convert_line),
    ] = None,
    vent_rest: VentRest = None,
    tune: Annotated[
        str | Path | None,
        OutFile(
            "Write a line file with the measured values, for the controller of bench run.",
            metavar="FILE.toml",
            endings=(".toml",),
        ),
    ] = None,
    sensor_range: Annotated[
        float | None, SENSOR_RANGE, Help("Measuring range of the vacuum sensor, for --tune.")
    ] = None,
    overwrite: Overwrite = False,
) -> BenchChecked:
    """Check the wiring of a bench, and measure pump, leak, vent and the sensor's lag.

    Pump and vent are driven for ten seconds; the brake must carry no load. The controller of `bench
    run` is tuned for the values of `line`. `tune` is a file for this line with the measured values.
    Raises QuantityError if the valve's rest position is unknown or a value for `tune` is missing,
    LockedError if another client has the lock, InstrumentError for a bench that is not in SAFE.
    """
    from layerjam.bench.control.plant import linearise_line
    from layerjam.bench.rig.check import check_bench, limit_speed
    from layerjam.bench.rig.driver import open_bench
    from layerjam.bench.rig.virtual_plant import LINEAR_AT

    if tune is not None and line is None:
        raise QuantityError.of("line", "missing: give --line, whose values --tune replaces")
    sensor = None if line is None or tune is None else make_sensor(line, sensor_range)
    plant, lag = None, 0.0
    if line is not None:
        plant = linearise_line(line.line, vacuum=LINEAR_AT)
        lag = 0.0 if line.line.sensor is None else line.line.sensor.lag
    with open_bench(limit_speed(address)) as bench:
        data = check_bench(bench, vent_rest=vent_rest, plant=plant, lag=lag, tune=tune is not None)
        vent_position = bench.vent_rest
    if line is None or data.wiring or (tune is not None and not data.feasible):
        return BenchChecked.create(data)
    words = ["--vent-rest", vent_position or "open", "--line"]
    if tune is None or sensor is None:
        words.append(line.path if Path(line.path).is_file() else line.name)
        words += [] if line.line.sensor else ["--sensor-range", "103kPa"]
        words = ["check", str(address), *words, "--tune", "measured.toml"]
    else:
        measured_line = _set_measured_values(line, data, sensor, str(address))
        store_file(tune, measured_line.render(Path(tune).stem), overwrite)
        safe_state = "hold" if vent_position == "closed" else "release"
        words = ["run", str(address), *words, str(tune), "--safe-state", safe_state, *FIRST_RUN]
    next_step = format_command_line(["layerjam", "bench", *words])
    return BenchChecked.create(data, tuned=None if tune is None else str(tune), next_step=next_step)


def _set_measured_values(line: LineFile, checks: Checked, sensor: Sensor, address: str) -> LineFile:
    """Return a line with the measured values and their source; a missing value is an error."""
    from layerjam.bench.control.plant import Plant, match_line
    from layerjam.bench.rig.virtual_plant import LINEAR_AT

    values = {name: getattr(checks, name) for name in (*MEASURED, "noise")}
    missing_names = ", ".join(name for name, value in values.items() if value is None)
    if missing_names:
        raise QuantityError.of(missing_names, "not measured, so --tune writes no file")
    lag, noise = values.pop("lag"), max(sensor.noise, values.pop("noise"))
    new_line = match_line(line.line, Plant(**values), vacuum=LINEAR_AT)
    new_line = replace(new_line, sensor=replace(sensor, lag=lag, noise=noise))
    numbers = collect_values(new_line)
    new_line = build(
        Line, numbers | {name: float(f"{numbers[name]:.{DIGITS}g}") for name in REPLACED}
    )
    text = f"bench check of {address}, {datetime.now(UTC).date().isoformat()}"
    source = Source(kind="synthetic" if checks.simulated else "measured", text=text)
    sources = {**line.sources, **dict.fromkeys(REPLACED, source)}
    return replace(line, line=new_line, sources=sources, text="", parts={})
