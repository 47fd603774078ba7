"""`bench check` and `bench zero`: wiring, tightness and the sensor's zero, before the first run."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from layerjam.commands.bench import BenchAddress
from layerjam.commands.declare import Help, Input, command
from layerjam.commands.lines import AnyLine, line_file
from layerjam.commands.results import Result, result
from layerjam.fluid.file import LineFile
from layerjam.rig.outcomes import Checked, Zero


def _line(value: AnyLine, _given: Mapping[str, Any]) -> LineFile:
    return line_file(value)


@result
class BenchChecked(Result, Checked):
    """What a first look at a bench finds."""


VentRest = Annotated[
    Literal["open", "closed"] | None,
    Help("The vent valve without power, where the board does not know it."),
]


@result
class BenchZeroed(Result, Zero):
    """The zero of a bench's sensor."""


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
        return BenchZeroed.of(measure_zero(bench, vent_rest=vent_rest))


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
        LineFile | None,
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
    from layerjam.rig.plant import LINEAR_AT

    plant = plant_of(line.line, vacuum=LINEAR_AT) if isinstance(line, LineFile) else None
    with open_bench(address) as bench:
        return BenchChecked.of(check_bench(bench, vent_rest=vent_rest, plant=plant))
