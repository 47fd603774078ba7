"""`bench run`, `bench log`, `bench export`: a procedure on a bench, and the file it leaves."""

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.commands.bench import BenchAddress
from layerjam.commands.declare import Help, OutFile, command, options
from layerjam.commands.lines import LineInput
from layerjam.commands.pressure_log import End, Start, window
from layerjam.commands.quantities import Accept, BrakeInput, Overwrite, RopeStiffness
from layerjam.commands.regulator import RegulatorSettings, regulator_of
from layerjam.commands.results import Judged, Result, fact, number, result
from layerjam.control.settings import Regulator, validate
from layerjam.device.file import BrakeFile
from layerjam.errors import Notice, QuantityError
from layerjam.fluid.file import LineFile
from layerjam.rig.address import Address, address_of
from layerjam.rig.outcomes import Logged
from layerjam.rig.trigger import LEVEL
from layerjam.simulate.procedure import Procedure, Pull, parse_procedure
from layerjam.simulate.quantities import ARRIVAL_SPEED, MASS
from layerjam.units import QuantitySpec, exact_text, show
from layerjam.verdict import Verdict, judge

if TYPE_CHECKING:
    from layerjam.rig.crosshead import Crosshead
    from layerjam.rig.driver import Bench
    from layerjam.rig.execute import RunResult
    from layerjam.rig.shots import DropRig


@options
class DropRigOptions:
    """Mass dropped on the brake during a run, and whether its accelerometer is recorded."""

    shot: Annotated[
        bool, Help("Record the accelerometer of a mass that falls on the brake in a hold.")
    ] = False
    mass: Annotated[
        float | None, MASS, Help("Mass that falls; on a virtual board it does in each hold.")
    ] = None
    speed: Annotated[float | None, ARRIVAL_SPEED, Help("Speed with which it arrives.")] = None
    rope_stiffness: RopeStiffness | None = None
    trigger_level: Annotated[
        float | None, LEVEL, Help("Acceleration that triggers, in g; 5 unless given.")
    ] = None

    def rig(self, brake: BrakeFile) -> "DropRig | None":
        """The drop rig, None if no shot is asked for; QuantityError for what needs one."""
        from layerjam.rig.shots import DropRig

        if not self.shot:
            names = (f.name for f in fields(self) if getattr(self, f.name) not in (None, False))
            if (name := next(names, None)) is not None:
                raise QuantityError.of(name.replace("_", " "), "it belongs to a drop; add --shot")
            return None
        capture: dict[str, Any] = {}
        if self.trigger_level is not None:
            capture["level"] = self.trigger_level
        return DropRig(
            capture=capture,
            file=brake,
            mass=self.mass,  # type: ignore[arg-type]
            speed=self.speed,  # type: ignore[arg-type]
            rope_stiffness=self.rope_stiffness,  # type: ignore[arg-type]
        )


RECORDED = QuantitySpec("s", "time to record, by the board's clock", lo=0.1, hi=1e8, example="60s")
BOARD_PERIOD = 0.01
RunInput = Annotated[str | Path, Help("File of a run.", metavar="FILE.ljrun")]
FINISHED, STOPPED = "FINISHED", "OPERATOR_STOPPED"


@result
class RunRecorded(Judged):
    """Outcome of a procedure on a bench; `record` is None if a check failed first."""

    record: "RunResult | None" = None
    outcome: str = fact("FINISHED, or what ended it")
    reason: str | None = fact("why it did not finish")
    run_id: str = fact("number of the run, also in the file")
    samples: int = number("1", "samples in the file")
    gaps: int = number("1", "samples that are missing in between")
    duration: float = number("s", "time from the beginning to the last sample")
    steps: Sequence[Mapping[str, Any]] = fact("each step and when it was done", listed=False)
    fault: str | None = fact("fault that ended it")
    fault_time: float | None = number("s", "time of that fault")
    file: str | None = fact("file of the run; null if a check failed")
    simulated: bool = fact("whether no hardware was behind it")
    shots: Sequence[Mapping[str, Any]] | None = fact(
        "each record of the accelerometer; null unless --shot is given", listed=False, default=None
    )

    @property
    def exit_code(self) -> int:
        """4 if a check failed, 1 where the procedure did not finish."""
        return super().exit_code or (0 if self.outcome == FINISHED else 1)

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """Return the units of the columns of steps and shots."""
        return {"started": "s", "ended": "s", "time": "s", "rate": "Hz"}

    def lines(self) -> Iterator[str]:
        """One line a step, one a shot."""
        yield ""
        for step in self.steps:
            if step["started"] is None:
                yield f"{step['text']}: not begun"
                continue
            times = f"{step['started']:.2f} s to {step['ended']:.2f} s"
            yield f"{step['text']}: {times}{'' if step['reached'] else ', not reached'}"
        for shot in self.shots or ():
            cut = "" if shot["whole"] else ", cut off"
            yield f"shot {shot['shot']}: {shot['time']:.3f} s, {shot['samples']} samples{cut}"


@result
class RunLogged(Result, Logged):
    """Result of a log."""

    record: Logged

    @property
    def exit_code(self) -> int:
        """1 where line or disk ended it."""
        return 0 if self.outcome in (FINISHED, STOPPED) else 1


@result
class RunExported(Result):
    """Files written from a run."""

    samples: int = number("1", "samples written")
    gaps: int = number("1", "samples that are missing in between")
    interrupted: bool = fact("whether nobody closed the run")
    outcome: str | None = fact("how the run ended")
    file: str = fact("file that was written")
    sidecar: str | None = fact("file with the facts of a CSV")
    shots: Sequence[str] = fact("files of the accelerometer's records", listed=False)
    simulated: bool = fact("whether no hardware was behind it")


@command(
    "bench",
    place=12,
    parent="bench",
    examples=(
        'layerjam bench run "sim:choi2018?speed=0" --procedure "evacuate to 40 kPa and hold 5 s; '
        'vent" --brake choi2018-kapton --line choi2018 --safe-state release --vent-rest open '
        "--sensor-range 103kPa --out first.ljrun",
        'layerjam bench run "sim:choi2018?speed=0" --procedure "evacuate to 80 kPa and hold 2 s; '
        'vent" --brake choi2018-kapton --line choi2018 --safe-state release --vent-rest open '
        "--sensor-range 103kPa --shot --mass 1kg --speed 2.5m/s --out drop.ljrun",
    ),
    computes=False,
)
def bench_run(
    address: BenchAddress,
    *,
    procedure: Annotated[str, Help("Steps, as for tensile --procedure.", metavar="TEXT")],
    brake: BrakeInput,
    line: LineInput,
    vent_rest: Annotated[
        Literal["open", "closed"] | None,
        Help("State of the vent valve without power. Must be declared."),
    ] = None,
    settings: RegulatorSettings = RegulatorSettings(),
    crosshead: Annotated[
        Literal["manual", "trigger", "virtual"] | None,
        Help("Who pulls: a person, a machine by two contacts, or the virtual machine."),
    ] = None,
    drop: DropRigOptions = DropRigOptions(),
    out: Annotated[
        str | Path, OutFile("File of the run.", metavar="FILE.ljrun", endings=(".ljrun",))
    ],
    accept: Accept = None,
    overwrite: Overwrite = False,
) -> RunRecorded:
    """Carry out a procedure on a bench and record every sample.

    The regulator is made for the line, at the highest vacuum of the procedure, and given to the
    board. With `shot` the accelerometer of a falling mass waits from the first hold on, and every
    drop is kept in the file. Whatever happens, the last act is safe outputs and a closed file;
    Ctrl-C ends it with OPERATOR_STOPPED. Raises QuantityError for what the bench cannot do,
    InstrumentError if it refuses, FileError for the file. Nothing moves if a check of the
    regulator fails; the file stores the failed checks that `accept` accepts.
    """
    from layerjam.rig.execute import open_procedure_bench

    steps = parse_procedure(procedure)
    regulator, notices = _regulator(line, steps, settings)
    if vent_rest is None:
        raise QuantityError.of(
            "vent rest", "it must be declared; write open or closed, as the valve is without power"
        )
    rig, verdict = drop.rig(brake), _verdict(regulator, steps, accept, out)
    if verdict.failed:
        return _not_begun(steps, verdict, str(address), notices)
    with open_procedure_bench(_resolve_address(str(address), steps)) as bench:
        bench.safe_state, bench.vent_rest = regulator.safe_state, vent_rest
        bench.regulator = regulator
        drive = _crosshead(crosshead, bench, brake, line, steps)
        meta = {"brake": brake.name, "brake_toml": brake.render(brake.name)}
        meta["line_toml"] = line.render(line.name)
        meta["accepted"] = json.dumps([decision.to_toml() for decision in verdict.decisions])
        record = bench.run(
            steps, out=out, crosshead=drive, meta=meta, overwrite=overwrite, rig=rig, say=_report
        )
    notices += simulated_notice(record.simulated) + companion_notice(record.file)
    if record.shots is not None and not record.shots:
        notices.append(Notice("nothing fell: the accelerometer was not triggered", "no-shot"))
    return RunRecorded.of(
        record,
        verdict,
        steps=[vars(step) for step in record.steps],
        shots=None if record.shots is None else [vars(shot) for shot in record.shots],
        file=str(record.file),
        warnings=notices,
        record=record,
    )


def _verdict(
    regulator: Regulator, steps: Procedure, accept: Mapping[str, str] | None, out: str | Path
) -> Verdict:
    """Return the verdict of a regulator at the highest vacuum of a procedure, if it has one."""
    from layerjam.control.checks import step_check

    highest = steps.highest_vacuum()
    return judge([step_check(regulator, highest)] if highest else [], accept, file=out)


def _not_begun(steps: Procedure, verdict: Verdict, address: str, notices: list[str]) -> RunRecorded:
    """Return the result of a run that a failed check forbids."""
    waiting = {"started": None, "ended": None, "reached": False}
    return RunRecorded.of(
        verdict,
        outcome="NOT_BEGUN",
        reason="a check of the regulator failed, so that nothing was moved",
        run_id="",
        samples=0,
        gaps=0,
        duration=0.0,
        steps=[{"text": step.text(), **waiting} for step in steps.steps],
        simulated=address_of(address).simulated,
        warnings=notices,
    )


def _regulator(
    line: LineFile, steps: Procedure, settings: RegulatorSettings
) -> tuple[Regulator, list[str]]:
    """The regulator that a board is given, for the highest vacuum of a procedure."""
    if settings.sample_time not in (None, BOARD_PERIOD):
        raise QuantityError.of(
            "sample time",
            f"{show(settings.sample_time, 's')} is not allowed; a board samples every 10 ms",
        )
    highest = steps.highest_vacuum()
    regulator, notices = regulator_of(line, highest or 0.5 * line.line.site.atmosphere, settings)
    if highest:
        validate(regulator, highest)
    return regulator, notices


def _crosshead(
    kind: str | None, bench: "Bench", brake: BrakeFile, line: LineFile, steps: Procedure
) -> "Crosshead | None":
    from layerjam.rig.crosshead import Manual, Trigger, Virtual
    from layerjam.rig.machine import check_brake

    if kind == "manual":
        return Manual()
    if kind == "trigger":
        return Trigger()
    if kind == "virtual":
        for step in steps.steps:
            if isinstance(step, Pull):
                check_brake(brake.brake, step.until)
        return Virtual(bench, brake.brake, line.line)
    return None


def _resolve_address(address: str, steps: Procedure) -> Address:
    """The address; a virtual line is made linear where the regulator is, unless it says where."""
    target = address_of(address)
    highest = steps.highest_vacuum()
    if not target.simulated or "at" in target.options or not highest:
        return target
    return replace(target, options={**target.options, "at": exact_text(highest, "Pa")})


def _report(sentence: str) -> None:
    print(f"layerjam: {sentence}", file=sys.stderr, flush=True)


def companion_notice(file: Path) -> list[str]:
    """Return a notice about the file of unmerged samples that a full disk leaves with a run."""
    companion = Path(f"{file}-wal")
    if not companion.exists():
        return []
    return [
        Notice(
            f"{file.name} and {companion.name} belong together: copy both, or free room on the "
            f"disk and run 'layerjam bench export {file.name}'",
            "two-files",
        )
    ]


def simulated_notice(simulated: bool) -> list[str]:
    """Return the notice that the numbers come from a virtual bench."""
    text = "simulated: a virtual bench computed it, nothing was measured"
    return [Notice(text, "simulated")] if simulated else []


@command(
    "bench",
    place=13,
    parent="bench",
    examples=("layerjam bench log sim:choi2018 --out log.ljrun --duration 1s",),
    computes=False,
)
def bench_log(
    address: BenchAddress,
    *,
    out: Annotated[str | Path, Help("File of the run.", metavar="FILE.ljrun")],
    duration: Annotated[
        float | None, RECORDED, Help("Time to record; until Ctrl-C unless given.")
    ] = None,
    resume: Annotated[bool, Help("Go on in a file that an interrupted log has left.")] = False,
    overwrite: Overwrite = False,
) -> RunLogged:
    """Record every sample of a bench that others command.

    A sample is acknowledged to the board only after it is on disk. A killed process loses nothing
    that was acknowledged, and `resume` fetches what the board still has, the last ten seconds.
    Ctrl-C or SIGTERM ends it. Raises FileError for the file, LineError for the bench.
    """
    from layerjam.rig.recorder import log

    record = log(
        str(address),
        out,
        duration=duration,
        resume=resume,
        overwrite=overwrite,
        say=_report,
    )
    notices = simulated_notice(record.simulated) + companion_notice(Path(record.file))
    return RunLogged.of(record, warnings=notices, record=record)


@command(
    "bench",
    place=14,
    parent="bench",
    examples=("layerjam bench export first.ljrun --out first.csv",),
    computes=False,
)
def bench_export(
    run: RunInput,
    *,
    out: Annotated[
        str | Path,
        OutFile("CSV, Parquet or NetCDF.", metavar="FILE", endings=(".csv", ".parquet", ".nc")),
    ],
    start: Start = None,
    end: End = None,
    overwrite: Overwrite = False,
) -> RunExported:
    """Write a run for other programs: CSV with its sidecar, Parquet, or NetCDF.

    Friction, calibrate, leak, pump-down and regulate read the CSV as it is. Each drop in the run is
    a file of its own in the same folder, FILE-shot1.csv, which crash reads; NetCDF contains it. A
    run that nobody closed is `interrupted`; its file is read in place, together with its `-wal`
    file.
    """
    from layerjam.rig.export import export

    first, last = window(start, end)
    exports = export(run, out, start=first, end=last, overwrite=overwrite)
    return RunExported.of(
        Verdict(decisions=exports.run.decisions),
        exports.run,
        file=str(exports.file),
        sidecar=None if exports.sidecar is None else str(exports.sidecar),
        shots=[str(file) for file in exports.shots],
        warnings=simulated_notice(exports.run.simulated),
    )
