"""`bench run`, `bench log`, `bench export`: procedures on a bench, and their files."""

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.bench.commands.bench import BenchAddress
from layerjam.bench.commands.regulator import RegulatorSettings, make_regulator
from layerjam.bench.control.settings import Regulator, validate
from layerjam.bench.rig.address import Address, address_of
from layerjam.bench.rig.outcomes import Logged
from layerjam.bench.rig.trigger import LEVEL
from layerjam.brake.commands.arguments import Accept, BrakeInput, Overwrite, RopeStiffness
from layerjam.brake.commands.lines import LineInput
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line_file import LineFile
from layerjam.brake.simulate.procedure import Procedure, Pull, parse_procedure
from layerjam.brake.simulate.quantities import ARRIVAL_SPEED, MASS
from layerjam.core.command.declare import Help, OutFile, command, options
from layerjam.core.command.results import Judged, Result, fact, number, result
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.units import QuantitySpec, exact_text, show
from layerjam.core.verdict import Verdict, judge
from layerjam.laboratory.commands.pressure_log import End, Start, check_window

if TYPE_CHECKING:
    from layerjam.bench.rig.crosshead import Crosshead
    from layerjam.bench.rig.driver import Bench
    from layerjam.bench.rig.execute import RunResult
    from layerjam.bench.rig.shots import DropRig


@options
class DropRigOptions:
    """Options of a mass that is dropped on the brake during a run, with its accelerometer."""

    shot: Annotated[
        bool, Help("During a hold, record the accelerometer of a mass that falls into the brake.")
    ] = False
    mass: Annotated[
        float | None, MASS, Help("Falling mass. On a virtual board it falls during each hold.")
    ] = None
    speed: Annotated[float | None, ARRIVAL_SPEED, Help("Arrival speed of the mass.")] = None
    rope_stiffness: RopeStiffness | None = None
    trigger_level: Annotated[
        float | None, LEVEL, Help("Acceleration that triggers the recording, in g. Default: 5.")
    ] = None

    def make_rig(self, brake: BrakeFile) -> "DropRig | None":
        """Return the drop rig, None if there is no shot; QuantityError if an option needs one."""
        from layerjam.bench.rig.shots import DropRig

        if not self.shot:
            names = (f.name for f in fields(self) if getattr(self, f.name) not in (None, False))
            if (name := next(names, None)) is not None:
                raise QuantityError.of(name.replace("_", " "), "only valid for a drop; add --shot")
            return None
        capture = {} if self.trigger_level is None else {"level": self.trigger_level}
        numbers: dict[str, Any] = {"mass": self.mass, "speed": self.speed}
        numbers["rope_stiffness"] = self.rope_stiffness
        return DropRig(capture=capture, file=brake, **numbers)


RECORDED = QuantitySpec("s", "recording time, by the board's clock", lo=0.1, hi=1e8, example="60s")
BOARD_PERIOD = 0.01
RunInput = Annotated[str | Path, Help("Run file.", metavar="FILE.ljrun")]
FINISHED, STOPPED = "FINISHED", "OPERATOR_STOPPED"


@result
class RunRecorded(Judged):
    """Outcome of a procedure on a bench; `record` is None if a check failed first."""

    record: "RunResult | None" = None
    outcome: str = fact("FINISHED, or the reason that the run ended")
    reason: str | None = fact("why the run did not finish")
    run_id: str = fact("number of the run, also in the file")
    samples: int = number("1", "samples in the file")
    gaps: int = number("1", "samples missing between the first and the last")
    duration: float = number("s", "time from the start to the last sample")
    steps: Sequence[Mapping[str, Any]] = fact("each step with its completion time", listed=False)
    fault: str | None = fact("fault that ended the run")
    fault_time: float | None = number("s", "time of that fault")
    file: str | None = fact("file of the run; null if a check failed")
    simulated: bool = fact("whether the bench was simulated")
    shots: Sequence[Mapping[str, Any]] | None = fact(
        "each record of the accelerometer; null unless --shot is given", listed=False, default=None
    )

    @property
    def exit_code(self) -> int:
        """Exit code: 4 if a check failed, 1 if the procedure did not finish."""
        return super().exit_code or (0 if self.outcome == FINISHED else 1)

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """Return the units of the columns of steps and shots."""
        return {"started": "s", "ended": "s", "time": "s", "rate": "Hz"}

    def lines(self) -> Iterator[str]:
        """Yield one line for each step and each shot."""
        yield ""
        for step in self.steps:
            if step["started"] is None:
                yield f"{step['text']}: not started"
                continue
            times = f"{step['started']:.2f} s to {step['ended']:.2f} s"
            yield f"{step['text']}: {times}{'' if step['reached'] else ', not reached'}"
        for shot in self.shots or ():
            cut = "" if shot["whole"] else ", truncated"
            yield f"shot {shot['shot']}: {shot['time']:.3f} s, {shot['samples']} samples{cut}"


@result
class RunLogged(Result, Logged):
    """Result of a log."""

    record: Logged

    @property
    def exit_code(self) -> int:
        """Exit code: 1 if the connection or the disk failed."""
        return 0 if self.outcome in (FINISHED, STOPPED) else 1


@result
class RunExported(Result):
    """Files written from a run."""

    samples: int = number("1", "samples written")
    gaps: int = number("1", "samples missing between the first and the last")
    interrupted: bool = fact("whether the run was interrupted before its file was closed")
    outcome: str | None = fact("outcome of the run")
    file: str = fact("file written")
    sidecar: str | None = fact("metadata file (sidecar) of a CSV file")
    shots: Sequence[str] = fact("files of the accelerometer's records", listed=False)
    simulated: bool = fact("whether the bench was simulated")


@command("bench", parent="bench")
def bench_run(
    address: BenchAddress,
    *,
    procedure: Annotated[str, Help("Steps, in the format of tensile --procedure.", metavar="TEXT")],
    brake: BrakeInput,
    line: LineInput,
    vent_rest: Annotated[
        Literal["open", "closed"] | None,
        Help("Position of the vent valve when unpowered. Required."),
    ] = None,
    settings: RegulatorSettings = RegulatorSettings(),
    crosshead: Annotated[
        Literal["manual", "trigger", "virtual"] | None,
        Help(
            "Crosshead drive: a person, a machine connected by two contacts, or the virtual "
            "test machine."
        ),
    ] = None,
    drop: DropRigOptions = DropRigOptions(),
    out: Annotated[
        str | Path, OutFile("Run file to write.", metavar="FILE.ljrun", endings=(".ljrun",))
    ],
    accept: Accept = None,
    overwrite: Overwrite = False,
) -> RunRecorded:
    """Run a procedure on a bench and record every sample.

    The controller is tuned to the line at the highest vacuum of the procedure, and sent to the
    board. With `shot`, the accelerometer of a falling mass is armed from the first hold onwards,
    and the file keeps every drop. In every case the outputs are left safe and the file is closed;
    Ctrl-C ends the run with OPERATOR_STOPPED. Raises QuantityError for a procedure that the bench
    cannot run, InstrumentError if it rejects a command, FileError for the file. Nothing moves if a
    check of the controller fails; the file stores the failed checks that `accept` accepts.
    """
    from layerjam.bench.rig.execute import open_procedure_bench

    steps = parse_procedure(procedure)
    regulator, notices = _tune_regulator(line, steps, settings)
    if vent_rest is None:
        raise QuantityError.of(
            "vent rest", "required; write open or closed, the position of the unpowered vent valve"
        )
    rig, verdict = drop.make_rig(brake), _judge_regulator(regulator, steps, accept, out)
    if verdict.failed:
        return _make_refused_run(steps, verdict, str(address), notices)
    with open_procedure_bench(_resolve_address(str(address), steps)) as bench:
        bench.safe_state, bench.vent_rest = regulator.safe_state, vent_rest
        bench.regulator = regulator
        drive = _open_crosshead(crosshead, bench, brake, line, steps)
        meta = {"brake": brake.name, "brake_toml": brake.render(brake.name)}
        meta["line_toml"] = line.render(line.name)
        meta["accepted"] = json.dumps([decision.to_toml() for decision in verdict.decisions])
        record = bench.run(
            steps, out=out, crosshead=drive, meta=meta, overwrite=overwrite, rig=rig, say=_report
        )
    notices += simulation_notice(record.simulated) + companion_notice(record.file)
    if record.shots is not None and not record.shots:
        notices.append(Notice("no fall was detected: the accelerometer did not trigger", "no-shot"))
    return RunRecorded.create(
        record,
        verdict,
        steps=[vars(step) for step in record.steps],
        shots=None if record.shots is None else [vars(shot) for shot in record.shots],
        file=str(record.file),
        warnings=notices,
        record=record,
    )


def _judge_regulator(
    regulator: Regulator, steps: Procedure, accept: Mapping[str, str] | None, out: str | Path
) -> Verdict:
    """Return the verdict of a controller at a procedure's highest vacuum; no check if it is 0."""
    from layerjam.bench.control.checks import step_check

    highest = steps.highest_vacuum()
    return judge([step_check(regulator, highest)] if highest else [], accept, file=out)


def _make_refused_run(
    steps: Procedure, verdict: Verdict, address: str, notices: list[Notice]
) -> RunRecorded:
    """Return the result of a run that was not started because a check failed."""
    waiting = {"started": None, "ended": None, "reached": False}
    return RunRecorded.create(
        verdict,
        outcome="NOT_BEGUN",
        reason="a check of the controller failed, so the bench did not switch anything on",
        run_id="",
        samples=0,
        gaps=0,
        duration=0.0,
        steps=[{"text": step.text(), **waiting} for step in steps.steps],
        simulated=address_of(address).simulated,
        warnings=notices,
    )


def _tune_regulator(
    line: LineFile, steps: Procedure, settings: RegulatorSettings
) -> tuple[Regulator, list[Notice]]:
    """Return the controller to send to a board, for the highest vacuum of a procedure."""
    if settings.sample_time not in (None, BOARD_PERIOD):
        raise QuantityError.of(
            "sample time",
            f"{show(settings.sample_time, 's')} is not allowed; a board samples every 10 ms",
        )
    highest = steps.highest_vacuum()
    regulator, notices = make_regulator(line, highest or 0.5 * line.line.site.atmosphere, settings)
    if highest:
        validate(regulator, highest)
    return regulator, notices


def _open_crosshead(
    kind: str | None, bench: "Bench", brake: BrakeFile, line: LineFile, steps: Procedure
) -> "Crosshead | None":
    from layerjam.bench.rig.crosshead import Manual, Trigger, Virtual
    from layerjam.bench.rig.machine import check_brake

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
    """Return the address, with the vacuum at which a virtual line is linearised.

    This is the controller's vacuum unless the address states a different one.
    """
    target = address_of(address)
    highest = steps.highest_vacuum()
    if not target.simulated or "at" in target.options or not highest:
        return target
    return replace(target, options={**target.options, "at": exact_text(highest, "Pa")})


def _report(sentence: str) -> None:
    print(f"layerjam: {sentence}", file=sys.stderr, flush=True)


def companion_notice(file: Path) -> list[Notice]:
    """Return a notice about the file of unmerged samples that remains after the disk was full."""
    companion = Path(f"{file}-wal")
    if not companion.exists():
        return []
    return [
        Notice(
            f"{file.name} and {companion.name} belong together: copy both, or free disk "
            f"space and run 'layerjam bench export {file.name}'",
            "two-files",
        )
    ]


def simulation_notice(simulated: bool) -> list[Notice]:
    """Return the notice that the numbers are from a virtual bench."""
    text = "simulated: computed by a virtual bench, not measured"
    return [Notice(text, "simulated")] if simulated else []


@command("bench", parent="bench")
def bench_log(
    address: BenchAddress,
    *,
    out: Annotated[str | Path, Help("Run file to write.", metavar="FILE.ljrun")],
    duration: Annotated[
        float | None, RECORDED, Help("Recording time. Default: until Ctrl-C.")
    ] = None,
    resume: Annotated[bool, Help("Append to the file of an interrupted log.")] = False,
    overwrite: Overwrite = False,
) -> RunLogged:
    """Record every sample of a bench that another client controls.

    A sample is acknowledged to the board only after it is on disk. No acknowledged sample is lost
    if the process is killed; `resume` fetches up to ten seconds of samples from the board. Ctrl-C
    or SIGTERM ends the recording. Raises FileError for the file, LineError for the bench.
    """
    from layerjam.bench.rig.recorder import record_log

    options: dict[str, Any] = {"duration": duration, "resume": resume, "overwrite": overwrite}
    record = record_log(str(address), out, say=_report, **options)
    notices = simulation_notice(record.simulated) + companion_notice(Path(record.file))
    return RunLogged.create(record, warnings=notices, record=record)


@command("bench", parent="bench")
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
    """Export a run for other programs: CSV with its sidecar, Parquet, or NetCDF.

    Friction, calibrate, leak, pump-down and regulate read the CSV directly. Each drop in the run
    becomes a separate file in the same folder, FILE-shot1.csv, which `crash` reads; NetCDF contains
    the drops. A run that was not closed has the outcome `interrupted`; its file is read in place,
    together with its `-wal` file.
    """
    from layerjam.bench.rig.export import export

    first, last = check_window(start, end)
    exports = export(run, out, start=first, end=last, overwrite=overwrite)
    return RunExported.create(
        Verdict(decisions=exports.run.decisions),
        exports.run,
        file=str(exports.file),
        sidecar=None if exports.sidecar is None else str(exports.sidecar),
        shots=[str(file) for file in exports.shots],
        warnings=simulation_notice(exports.run.simulated),
    )
