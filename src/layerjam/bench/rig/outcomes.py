"""Results of operations on a bench: state, check, zero, log, soak test and flashed board.

The commands' results inherit the unit and description of each quantity.
"""

from layerjam.core.brief import brief
from layerjam.core.outputs import fact, number, outputs


@outputs
class BenchStatus:
    """State of a bench at one moment."""

    identity: str = fact("identification of the board")
    simulated: bool = fact("whether the bench is simulated")
    state: str = fact("SAFE, RUN, FAULT or DRIVE")
    fault: str | None = fact("the latched fault")
    vacuum: float | None = number("Pa", "last reading")
    target: float = number("Pa", "vacuum to hold")
    pump: float = number("1", "pump command, −1 to 1")
    vent: str = fact("whether the vent is open or closed")
    safe_state: str | None = fact("safe state after a fault; null if not declared")
    vent_rest: str | None = fact("position of the vent valve without power; null if not declared")
    lease: float = number("s", "time that outputs stay on after the host goes silent")
    boot: str = fact("random number that identifies this start of the board")
    reset_cause: str = fact("what triggered the start")
    uptime: float = number("s", "time since the board started")
    late_ticks: int = fact("samples more than 1 ms late")
    worst_lateness: float = number("s", "largest delay of a sample since the start")
    samples_lost: int = fact("samples overwritten before they were acknowledged")
    law_matches: bool = fact("whether the board runs the same law as this package")
    double: bool = fact("whether the board computes in double precision")
    zero_age: float | None = number("s", "time since the sensor's zero was last measured")
    errors: tuple[str, ...] = fact("device errors in the queue", listed=False)


@outputs
class Checked:
    """Result of a bench check."""

    self_test: int = fact("sum of the fault codes of the board's self-test; 0 if there are none")
    wiring: tuple[str, ...] = fact("wiring faults; empty if there are none")
    leak: float | None = number("1/s", "decay of the vacuum with the pump off and the vent shut")
    rate: float | None = number("1/s", "ratio of pump flow to volume")
    top: float | None = number("Pa", "ultimate vacuum of the pump, from its curve")
    vent: float | None = number("1/s", "additional decay of the vacuum with the vent open")
    lag: float | None = number("s", "time constant of the sensor's lag")
    zero: float | None = number("Pa", "reading with the vent open")
    noise: float | None = number("Pa", "standard deviation of the reading with the vent open")
    expected: dict[str, float] | None = fact(
        "rate, top, leak, vent and lag of the line in SI units; null unless a line is given",
        listed=False,
    )
    feasible: bool = fact("whether the bench can regulate, and matches the line if one is given")
    reason: str | None = fact("reason if it is not feasible")
    simulated: bool = fact("whether the bench is simulated")


@outputs
class Zero:
    """Zero of the sensor of a bench."""

    zero: float = number("Pa", "reading with the vent open, before the correction")
    zero_scatter: float = number("Pa", "standard deviation of the readings")
    sensor_offset: float = number("Pa", "offset that the board will subtract")
    date: str = fact("date stored with the offset")
    simulated: bool = fact("whether the bench is simulated")


@outputs
class Flashed:
    """Files on a board after flashing, and the identity that it reports."""

    board: str = fact("kind of board")
    image_sha256: str | None = fact("SHA-256 of the image; null unless an image is given")
    files: tuple[str, ...] = fact("files written to the board and read back", listed=False)
    verified: bool = fact("whether the flashed board runs this package's firmware")
    identity: str | None = fact("identification of the board after flashing")


@brief
@outputs
class Logged:
    """Result of logging a bench."""

    outcome: str = fact("FINISHED, or the reason why the log ended")
    reason: str | None = fact("explanation of an early end")
    samples: int = number("1", "samples in the file")
    gaps: int = number("1", "samples missing between the first and the last")
    boots: int = number("1", "number of board starts during the log")
    file: str = fact("file of the run")
    simulated: bool = fact("whether the bench was simulated")


@outputs
class Soaked:
    """Result of an endurance test."""

    address: str = fact("address of the virtual board", listed=False)
    board: str = fact("interpreter that ran the firmware")
    kind: str = fact("control law")
    hours: float = number("1", "hours of board time")
    ticks: int = fact("samples taken by the board")
    orders: int = fact("targets and releases sent to the board")
    false_faults: int = fact("false faults reported")
    faults: tuple[str, ...] = fact("names of the false faults", listed=False)
    gaps: int = fact("number of samples missing, repeated or not 10 ms after the previous one")
    wraps: int = fact("number of overflows of the board's 30-bit clock")
    heap_growth: int | None = number("B", "growth in memory use since the first minute")
    late_ticks: int = fact("samples more than 1 ms late")
    complete: bool = fact("always true, because a stopped command has no result")
