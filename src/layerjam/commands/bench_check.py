"""`bench check` and `bench zero`: wiring, tightness and the sensor's zero, before the first run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from layerjam.commands.bench import BenchAddress
from layerjam.commands.declare import Help, Input, command
from layerjam.commands.lines import AnyLine, line_file
from layerjam.commands.results import Result, fact, number, result
from layerjam.fluid.file import LineFile


def _line(value: Any, _given: Mapping[str, Any]) -> LineFile:
    return line_file(value)


@result
class BenchChecked(Result):
    """What a first look at a bench finds."""

    self_test: int = fact("sum of what the board's own test finds wrong; 0: nothing")
    wiring: Sequence[str] = fact("what is wired wrong; empty where all is right")
    leak: float | None = number("1/s", "decay of the vacuum with pump off and vent shut")
    rate: float | None = number("1/s", "flow of the pump over the volume")
    top: float | None = number("Pa", "vacuum at which the pump ends, by its curve")
    zero: float | None = number("Pa", "reading with the vent open")
    feasible: bool = fact("whether the bench can regulate, as the line's file says")
    reason: str | None = fact("why not")
    simulated: bool = fact("whether no hardware is behind it")


VentRest = Annotated[
    Literal["open", "closed"] | None,
    Help("The vent valve without power, where the board does not know it."),
]


@result
class BenchZeroed(Result):
    """The zero of a bench's sensor."""

    zero: float = number("Pa", "reading with the vent open, before")
    zero_scatter: float = number("Pa", "standard deviation of the readings")
    sensor_offset: float = number("Pa", "offset that the board subtracts from now on")
    date: str = fact("date that is stored with it")
    simulated: bool = fact("whether no hardware is behind it")


@command(
    "bench",
    place=16,
    under="bench",
    examples=("layerjam bench zero sim:choi2018 --vent-rest open",),
    computes=False,
)
def bench_zero(address: BenchAddress, *, vent_rest: VentRest = None) -> BenchZeroed:
    """Measure the zero of the sensor with the brake vented, and store it on the board.

    The vent is open for 4.5 s; the mean of the last second is the zero. The board keeps it, and the
    date in the calibration's name. Raises QuantityError if the reading is not steady or far from
    zero, LockedError if another client commands, InstrumentError for a bench that is not in SAFE.
    """
    from layerjam.rig.check import measure_zero
    from layerjam.rig.driver import open_bench

    with open_bench(address) as bench:
        zero = measure_zero(bench, vent_rest=vent_rest)
        return BenchZeroed(
            zero=zero.reading,
            zero_scatter=zero.scatter,
            sensor_offset=zero.offset,
            date=zero.date,
            simulated=bench.simulated,
        )


@command(
    "bench",
    place=15,
    under="bench",
    examples=("layerjam bench check sim:choi2018 --vent-rest open --line choi2018",),
    computes=False,
)
def bench_check(
    address: BenchAddress,
    *,
    line: Annotated[
        AnyLine | None,
        Input("Vacuum line that it should be: name or TOML file.", metavar="LINE", convert=_line),
    ] = None,
    vent_rest: VentRest = None,
) -> BenchChecked:
    """Look after a bench's wiring: drive pump and vent for ten seconds, and say what moves.

    Nothing may hang on the brake meanwhile. `line` is what the pump's rate and the leak are held
    against. Raises QuantityError where nobody knows the valve's rest, LockedError where another
    client commands, InstrumentError for a bench that is not in SAFE.
    """
    from layerjam.control.plant import plant_of
    from layerjam.rig.check import check_bench
    from layerjam.rig.driver import open_bench
    from layerjam.rig.plant import AT

    plant = plant_of(line.line, vacuum=AT) if isinstance(line, LineFile) else None
    with open_bench(address) as bench:
        made = check_bench(bench, vent_rest=vent_rest, plant=plant)
        return BenchChecked(
            self_test=made.self_test,
            wiring=made.wiring,
            leak=made.leak,
            rate=made.rate,
            top=made.top,
            zero=made.zero,
            feasible=made.feasible,
            reason=made.reason,
            simulated=bench.simulated,
        )
