"""`bench faults` and `bench soak`: behaviour of the board with and without faults."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.bench.rig.address import VIRTUAL
from layerjam.bench.rig.outcomes import Soaked
from layerjam.brake.commands.arguments import Seed
from layerjam.core.command.declare import Help, Progress, command
from layerjam.core.command.results import Result, fact, number, result
from layerjam.core.errors import Notice, count_text
from layerjam.core.units import QuantitySpec, show

if TYPE_CHECKING:
    from layerjam.bench.rig.campaign import Trial

RUNS = QuantitySpec("1", "runs per fault", lo=1, hi=1e5, whole=True, example="100")
HOURS = QuantitySpec("1", "hours of board time", hi=1e4, open_lo=True, example="24")
TABLE_UNITS = {
    "onset": "s",
    "safe_after": "s",
    "named_after": "s",
    "deadline": "s",
    "vacuum_after": "Pa",
    "doubted_after": "s",
}
FALSE = 0.01
"""Largest fraction of healthy runs in which a fault may be reported."""
Row = Mapping[str, Any]


@result
class FaultCampaign(Result):
    """Results of each fault; `record` holds the runs.

    Each row shows the run that came nearest to its deadline. `onset` is the time from the pump's
    start to the fault, `safe_after` that from the fault to safe outputs in the plant's log.
    `vacuum_after` is the true vacuum at the time when a working vent would have released it.
    `named` counts the faults that the board reported, by name. `deadline` is null if there is no
    deadline.
    """

    record: "tuple[Trial, ...]"
    address: str = fact("virtual board under test", listed=False)
    board: str = fact("Python interpreter that runs the firmware")
    faults: Sequence[Row] = fact(
        "each fault: text, onset, named, safe_after, named_after, deadline, met, vacuum_after, "
        "doubted_after, runs, missed, worst_run",
        listed=False,
    )
    runs: int = number("1", "completed runs")
    missed: int = fact(
        "runs in which the bench was not safe, or the fault not identified, by the deadline"
    )
    healthy: int = fact("runs without a fault", listed=False, default=0)
    false_faults: int = fact(
        "runs without a fault in which the board reported one", listed=False, default=0
    )
    left_out: Mapping[str, str] = fact("faults not tested, with reasons", listed=False)
    complete: bool = fact("always true, because a stopped command has no result")

    @property
    def exit_code(self) -> int:
        """Exit code: 1 if a deadline was missed or too many healthy runs fail."""
        return 1 if self.missed or self.false_faults > FALSE * self.healthy else 0

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """Return the units of the rows' keys."""
        return TABLE_UNITS

    def lines(self) -> Iterator[str]:
        """Yield a line for each fault."""
        yield ""
        width = max((len(row["fault"]) for row in self.faults), default=0)
        for row in self.faults:
            yield f"{row['fault']:<{width}}  {_describe_fault(row)}"
        if self.healthy:
            runs = count_text(self.healthy, "run")
            yield f"no fault injected: {count_text(self.false_faults, 'false fault')} in {runs}"
        for name, reason in self.left_out.items():
            yield f"{name}: not tested; {reason}"


def _describe_fault(row: Row) -> str:
    names = ", ".join(f"{name} {count}" for name, count in row["named"].items()) or "not identified"
    safe_text = (
        "never safe" if row["safe_after"] is None else f"safe after {show(row['safe_after'], 's')}"
    )
    if row["deadline"] is None:
        promise = "no deadline"
    else:
        verdict = "met" if row["met"] else f"MISSED {row['missed']}"
        promise = f"deadline {show(row['deadline'], 's')}, {verdict}"
    vacuum_left = show(row["vacuum_after"], "Pa")
    return f"{safe_text}, {promise}, {vacuum_left} left, {names}, {count_text(row['runs'], 'run')}"


@result
class Soak(Result, Soaked):
    """Result of hours of operation without injected faults."""

    @property
    def exit_code(self) -> int:
        """Exit code: 1 if anything unexpected happened."""
        return 1 if self.false_faults or self.gaps or (self.heap_growth or 0) > 0 else 0


@command("develop", parent="bench")
def bench_faults(
    address: Annotated[
        str,
        Help(
            ("Virtual board to inject faults into: sim:LINE with its options."), metavar="ADDRESS"
        ),
    ] = VIRTUAL,
    *,
    only: Annotated[
        Sequence[str], Help("Faults to inject. Default: all.", metavar="NAME...", greedy=True)
    ] = (),
    runs: Annotated[int, RUNS] = 10,
    seed: Annotated[Seed, Help("Random seed for lines, targets, times and noise.")] = 0,
    mismatch: Annotated[
        bool, Help("Vary the lines about the model within the stated tolerances.")
    ] = False,
    progress: Progress = lambda what, share: None,
) -> FaultCampaign:
    """Inject every fault into a virtual board many times and measure the time until it is safe.

    For each run, the seed determines a line similar to that of the address, a controller, a target
    and the time of the fault. With `mismatch`, pump, vent, zero, lag and noise of the line differ
    from the model. Leak and vent are then orifices, the pump flow ripples and the supply dips. Each
    round of faults includes ten runs without a fault. The firmware is the board's own; its clock
    advances as fast as samples are computed. Raises UnknownNameError for an unknown fault,
    QuantityError for an address that is not a virtual board.
    """
    from layerjam.bench.rig.campaign import campaign
    from layerjam.bench.rig.kinds import KINDS, NOT_HERE, NOTHING

    names = [only] if isinstance(only, str) else list(only)
    options: dict[str, Any] = {"only": names, "mismatch": mismatch, "progress": progress}
    record = campaign(address, runs=int(runs), seed=int(seed), **options)
    healthy = [trial for trial in record.trials if trial.plan.name == NOTHING]
    rows = [
        summarise_fault(name, kind_trials)
        for name in KINDS
        if (kind_trials := [trial for trial in record.trials if trial.plan.name == name])
    ]
    notices = [
        Notice(f"{t.plan.name}: {t.trouble}", "run-broken") for t in record.trials if t.trouble
    ]
    return FaultCampaign(
        address=address,
        board=record.board,
        faults=rows,
        runs=len(record.trials),
        healthy=len(healthy),
        false_faults=sum(trial.named is not None for trial in healthy),
        missed=sum(row["missed"] for row in rows),
        left_out={name: reason for name, reason in NOT_HERE.items() if name in names or not names},
        complete=True,
        warnings=notices,
        record=record.trials,
    )


def summarise_fault(name: str, trials: "Sequence[Trial]") -> Row:
    """Return a row that summarises the runs of one fault, with the worst run in full."""
    worst = max(trials, key=lambda trial: trial.deadline_ratio)
    misses, time_named = sum(not trial.is_met for trial in trials), worst.named_after
    return {
        "fault": name,
        "text": worst.plan.kind.text,
        "onset": worst.onset,
        "named": dict(Counter(trial.named for trial in trials if trial.named).most_common()),
        "safe_after": worst.safe_after,
        "named_after": time_named if time_named is not None and math.isfinite(time_named) else None,
        "deadline": worst.deadline,
        "met": not misses,
        "vacuum_after": worst.vacuum_after,
        "doubted_after": worst.doubted_after if worst.deadline is None else None,
        "runs": len(trials),
        "missed": misses,
        "worst_run": worst.plan.number,
    }


@command("develop", parent="bench")
def bench_soak(
    *,
    line: Annotated[
        str, Help("Line of the virtual board: a line, or sim:LINE with options.", metavar="LINE")
    ] = VIRTUAL,
    hours: Annotated[float, HOURS] = 24.0,
    kind: Annotated[Literal["bang-bang", "pi", "scheduled"], Help("Control law.")] = "pi",
    seed: Annotated[Seed, Help("Random seed for targets, holds and noise.")] = 0,
    progress: Progress = lambda what, share: None,
) -> Soak:
    """Run a virtual board for hours of board time and report any unexpected event.

    Targets, releases and holds are drawn from the seed. A simulated day takes minutes. Raises
    QuantityError for an address that is not a virtual board.
    """
    from layerjam.bench.rig.soak import soak

    address = line if ":" in line else f"sim:{line}"
    record = soak(address, kind=kind, hours=float(hours), seed=int(seed), progress=progress)
    text = f"{record.board} does not report its memory use, so heap growth is unknown"
    notices = [Notice(text, "memory-unknown")] if record.heap_growth is None else []
    return Soak.create(record, warnings=notices)
