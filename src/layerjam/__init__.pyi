"""The public names as a caller sees them, from `_names.pyi` by `docs/generate.py`.

The functions of the commands take text with units as well as SI numbers.
"""

from collections.abc import Callable as _Callable
from collections.abc import Collection as _Collection
from collections.abc import Mapping as _Mapping
from collections.abc import Sequence as _Sequence
from pathlib import Path as _Path
from typing import Literal

from numpy.typing import ArrayLike as _ArrayLike

from layerjam import laws as laws
from layerjam._version import __version__ as __version__
from layerjam.cli.demo import DemoResult as _DemoResult
from layerjam.commands.ageing import Ageing as _Ageing
from layerjam.commands.array import ArrayPull as _ArrayPull
from layerjam.commands.bench import BenchCleared as _BenchCleared
from layerjam.commands.bench import BenchServed as _BenchServed
from layerjam.commands.bench import BenchState as _BenchState
from layerjam.commands.bench_check import BenchChecked as _BenchChecked
from layerjam.commands.bench_check import BenchZeroed as _BenchZeroed
from layerjam.commands.bench_faults import FaultCampaign as _FaultCampaign
from layerjam.commands.bench_faults import Soak as _Soak
from layerjam.commands.bench_flash import BoardFlashed as _BoardFlashed
from layerjam.commands.bench_run import RunExported as _RunExported
from layerjam.commands.bench_run import RunLogged as _RunLogged
from layerjam.commands.bench_run import RunRecorded as _RunRecorded
from layerjam.commands.bench_wiring import BoardWiring as _BoardWiring
from layerjam.commands.bend import Bend as _Bend
from layerjam.commands.build import Built as _Built
from layerjam.commands.calibration import BrakeCalibration as _BrakeCalibration
from layerjam.commands.calibration import Sampling as _Sampling
from layerjam.commands.compare import Comparison as _Comparison
from layerjam.commands.crash import CrashFound as _CrashFound
from layerjam.commands.design import DesignResult as _DesignResult
from layerjam.commands.drop_rig import DropRigOptions as _DropRigOptions
from layerjam.commands.edit import edit as edit
from layerjam.commands.edit import edit_line as edit_line
from layerjam.commands.export import Exported as _Exported
from layerjam.commands.export import ExportedFmu as _ExportedFmu
from layerjam.commands.export import ExportedMujoco as _ExportedMujoco
from layerjam.commands.follow import FollowedForce as _FollowedForce
from layerjam.commands.follow import ScheduledSettings as _ScheduledSettings
from layerjam.commands.follow import Swing as _Swing
from layerjam.commands.friction import Friction as _Friction
from layerjam.commands.friction import FrictionTest as _FrictionTest
from layerjam.commands.impact import Stop as _Stop
from layerjam.commands.impact import observed as observed
from layerjam.commands.lab import PracticeFiles as _PracticeFiles
from layerjam.commands.lab import lab_example as example_campaign
from layerjam.commands.leak import LeakFound as _LeakFound
from layerjam.commands.left_out import LeftOut as _LeftOut
from layerjam.commands.measurements import Measurements as _Measurements
from layerjam.commands.parts import PartList as _PartList
from layerjam.commands.plan import CollisionPlan as _CollisionPlan
from layerjam.commands.predict import BrakeForce as _BrakeForce
from layerjam.commands.predict import BrakeSummary as _BrakeSummary
from layerjam.commands.predict import NewBrake as _NewBrake
from layerjam.commands.predict import VacuumForForce as _VacuumForForce
from layerjam.commands.publish import Published as _Published
from layerjam.commands.publish import Recomputed as _Recomputed
from layerjam.commands.pull import Pulls as _Pulls
from layerjam.commands.pump_down import PumpFound as _PumpFound
from layerjam.commands.reading import DataFrame as _DataFrame
from layerjam.commands.reading import FileOptions as _FileOptions
from layerjam.commands.reading import LogOptions as _LogOptions
from layerjam.commands.reading import TableOptions as _TableOptions
from layerjam.commands.records import RecordsAdded as _RecordsAdded
from layerjam.commands.records import RecordShown as _RecordShown
from layerjam.commands.records import RecordsListed as _RecordsListed
from layerjam.commands.records import RecordsVerified as _RecordsVerified
from layerjam.commands.records import RecordWithdrawn as _RecordWithdrawn
from layerjam.commands.regulate import Regulation as _Regulation
from layerjam.commands.regulator import RecordedStep as _RecordedStep
from layerjam.commands.regulator import RegulatorSettings as _RegulatorSettings
from layerjam.commands.report import Issued as _Issued
from layerjam.commands.report import Report as _Report
from layerjam.commands.results import Result as Result
from layerjam.commands.schema import Schemas as _Schemas
from layerjam.commands.sensor import Sensing as _Sensing
from layerjam.commands.sensor import Warmth as _Warmth
from layerjam.commands.sensor import heating as heating
from layerjam.commands.sensor import reading as reading
from layerjam.commands.sleeve import SiliconeFit as _SiliconeFit
from layerjam.commands.stick_slip import StickSlip as _StickSlip
from layerjam.commands.sweep import DesignSweep as _DesignSweep
from layerjam.commands.tensile import Tensile as _Tensile
from layerjam.commands.tuning import TunedVacuum as _TunedVacuum
from layerjam.commands.vacuum_line import VacuumRise as _VacuumRise
from layerjam.commands.validation import ModelErrors as _ModelErrors
from layerjam.design.requirements import DesignSpecification as _DesignSpecification
from layerjam.design.specification import load_spec as load_spec
from layerjam.device.brake import Brake as Brake
from layerjam.device.brake import Brake as _Brake
from layerjam.device.enclosure import Enclosure as Enclosure
from layerjam.device.file import BrakeFile as BrakeFile
from layerjam.device.file import BrakeFile as _BrakeFile
from layerjam.device.load import catalogue as catalogue
from layerjam.device.load import load as load
from layerjam.device.mount import Mount as Mount
from layerjam.device.mount import Rope as Rope
from layerjam.device.mount import Site as Site
from layerjam.device.sheets import Film as Film
from layerjam.device.sheets import Sheets as Sheets
from layerjam.errors import LayerjamError as LayerjamError
from layerjam.errors import Notice as Notice
from layerjam.fluid.file import LineFile as _LineFile
from layerjam.fluid.file import load_line as load_line
from layerjam.fluid.line import Line as _Line
from layerjam.identify.friction.standards import Standard as Standard
from layerjam.lab.campaign import Campaign as Campaign
from layerjam.lab.spec import Spec as _Spec
from layerjam.measure.history import read_history as read_history
from layerjam.measure.log import read_log as read_log
from layerjam.measure.options import ReadingOptions as ReadingOptions
from layerjam.measure.readers.read import read_trace as read_trace
from layerjam.measure.readers.read import read_traces as read_traces
from layerjam.measure.trace import Trace as Trace
from layerjam.measure.trace import Trace as _Trace
from layerjam.mechanics.stick_slip.curve import Stribeck as Stribeck
from layerjam.records.source import Source as Source
from layerjam.simulate.accelerometer import Accelerometer as Accelerometer
from layerjam.simulate.accelerometer import Accelerometer as _Accelerometer
from layerjam.simulate.batch import batch as batch
from layerjam.simulate.procedure import Procedure as Procedure
from layerjam.simulate.procedure import Procedure as _Procedure
from layerjam.simulate.procedure import parse_procedure as parse_procedure
from layerjam.simulate.record import DropRecord as DropRecord
from layerjam.simulate.record import Outcome as Outcome
from layerjam.simulate.record import TensileRecord as TensileRecord
from layerjam.simulate.stack_layout import Housing as Housing
from layerjam.simulate.stack_layout import Housing as _Housing
from layerjam.simulate.stack_layout import Interfaces as Interfaces
from layerjam.simulate.stack_layout import Interfaces as _Interfaces
from layerjam.simulate.vacuum_history import History as History
from layerjam.simulate.vacuum_history import History as _History
from layerjam.studies.choi2018.reproduce import Reproduction as _Reproduction
from layerjam.studies.machines.apply import MachineResult as _MachineResult

__all__ = ["design_brake", "example_campaign", "write_campaign", "write_report"]

def demo(
    *,
    out: str | _Path = ...,
    typed: str = ...,
) -> _DemoResult:
    """Show all of it in about a minute: test, calibrate, predict, build, run a bench, publish.

    Rebuilds the folder `out`, prints one line with its time for each step, and writes a page that
    compares the paper's claims with layerjam. Each command with its answer is in `demo.log` next to
    the page. Raises FileError, and writes nothing, if the folder is not the demo's own, and
    LayerjamError if a step fails.
    """

def ageing(
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    test: _FrictionTest = ...,
    hold: float | str | None = ...,
    brake: str | _Path | _BrakeFile | _Brake | None = ...,
    out: str | _Path | None = ...,
    partial: bool = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
    overwrite: bool = ...,
) -> _Ageing:
    """How static friction grows while the films rest under load, from pulls after holds.

    Each file is a friction test whose sidecar states its `hold`; static friction is read as
    `friction` reads it. With `brake` and `out` static friction at `hold` (the geometric mean of all
    holds unless given) and its growth are written into a copy of the brake's file.
    """

def array(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    parallel: int | str = ...,
    series: int | str = ...,
    vacuum: float | str | None = ...,
    until: float | str | None = ...,
    atmosphere: float | str | None = ...,
) -> _ArrayPull:
    """Pull equal brakes side by side and in series, slowly.

    At the site's full vacuum unless another is given, to the elongation `until` or to the end of
    the travel. `outcome` is how the pull ends: FINISHED, BOTTOMED_OUT, or SNAPS where a slipping
    brake softens faster than those in series with it relax. `travel` and `energy` are by slip
    alone. An even share is assumed.
    """

def bench_clear(
    address: str,
) -> _BenchCleared:
    """Clear the latched fault of a bench, its error queue and its registers; starts nothing.

    The bench is in SAFE afterwards. Find the cause first: `bench check` looks after the wiring.
    Raises FileError, LineError and QuantityError for a bench that cannot be reached.
    """

def bench_serve(
    address: str,
    *,
    port: int | str = ...,
    host: str = ...,
    token_file: str | _Path | None = ...,
    pty: str | _Path | None = ...,
) -> _BenchServed:
    """Let many clients talk to one bench, over TCP and as a serial port.

    The first line that is printed is JSON: `listening`, `pid`, `address`. It stays until SIGTERM or
    Ctrl-C, then switches the outputs off. Raises FileError where the port cannot be had.
    """

def bench_status(
    address: str,
) -> _BenchState:
    """What a bench is and does now.

    Asks only. On the board's own line it is the only client; where a gateway runs, use its `tcp:`
    address. Raises FileError, LineError and QuantityError for a bench that cannot be reached.
    """

def bench_check(
    address: str,
    *,
    line: str | _Path | _LineFile | _Line | None = ...,
    vent_rest: Literal["open", "closed"] | None = ...,
) -> _BenchChecked:
    """Look after a bench's wiring: drive pump and vent for ten seconds, and say what moves.

    Nothing may hang on the brake meanwhile. `line` is what the pump's rate and the leak are held
    against. Raises QuantityError where nobody knows the valve's rest, LockedError where another
    client commands, InstrumentError for a bench that is not in SAFE.
    """

def bench_zero(
    address: str,
    *,
    vent_rest: Literal["open", "closed"] | None = ...,
) -> _BenchZeroed:
    """Measure the zero of the sensor with the brake vented, and store it on the board.

    The vent is open for 4.5 s; the mean of the last second is the zero. The board keeps it, and the
    date in the calibration's name. Raises QuantityError if the reading is not steady or far from
    zero, LockedError if another client commands, InstrumentError for a bench that is not in SAFE.
    """

def bench_faults(
    address: str = ...,
    *,
    only: _Sequence[str] = ...,
    runs: int | str = ...,
    seed: int | str = ...,
    mismatch: bool = ...,
    progress: _Callable[[str, float], None] = ...,
) -> _FaultCampaign:
    """Break a virtual board in every way, many times over, and time how it becomes safe.

    Each run draws a line around that of the address, a regulator, a target and a moment from the
    seed. With `mismatch` pump, vent, zero, lag and noise of the real line differ from the model,
    leak and vent are orifices, the pump's flow ripples and the supply dips; ten runs in which
    nothing breaks go with each round of faults. The firmware is the board's own; its clock runs as
    fast as samples are computed. Raises
    UnknownNameError for a fault that nobody knows, QuantityError for an address that is no virtual
    board.
    """

def bench_soak(
    *,
    line: str = ...,
    hours: float | str = ...,
    kind: Literal["bang-bang", "pi", "scheduled"] = ...,
    seed: int | str = ...,
    progress: _Callable[[str, float], None] = ...,
) -> _Soak:
    """Let a virtual board regulate for hours of its own time, in which nothing may happen.

    Targets, releases and holds are drawn from the seed. A day takes minutes. Raises QuantityError
    for an address that is no virtual board.
    """

def bench_flash(
    port: str,
    *,
    board: str = ...,
    image: str | _Path | None = ...,
    settings: str | _Path | None = ...,
) -> _BoardFlashed:
    """Put firmware and wiring onto a board.

    With an image the board's boot loader takes it; a board with plain MicroPython gets the
    firmware's files otherwise. Raises FileError, ImageError, LineError, QuantityError and
    UnknownNameError.
    """

def bench_export(
    run: str | _Path,
    *,
    out: str | _Path,
    start: float | str | None = ...,
    end: float | str | None = ...,
    overwrite: bool = ...,
) -> _RunExported:
    """Write a run for other programs: CSV with its sidecar, Parquet, or NetCDF.

    Friction, calibrate, leak, pump-down and regulate read the CSV as it is. Each drop in the run is
    a file of its own beside it, FILE-shot1.csv, which crash reads; NetCDF holds it inside. A run
    that nobody closed is `interrupted`; its file is read in place, with the `-wal` file beside it.
    """

def bench_log(
    address: str,
    *,
    out: str | _Path,
    duration: float | str | None = ...,
    resume: bool = ...,
    overwrite: bool = ...,
) -> _RunLogged:
    """Record every sample of a bench that others command.

    A sample is acknowledged to the board only after it is on disk. A killed process loses nothing
    that was acknowledged, and `resume` fetches what the board still has, the last ten seconds.
    Ctrl-C or SIGTERM ends it. Raises FileError for the file, LineError for the bench.
    """

def bench_run(
    address: str,
    *,
    procedure: str,
    brake: str | _Path | _BrakeFile | _Brake,
    line: str | _Path | _LineFile | _Line,
    vent_rest: Literal["open", "closed"] | None = ...,
    settings: _RegulatorSettings = ...,
    crosshead: Literal["manual", "trigger", "virtual"] | None = ...,
    drop: _DropRigOptions = ...,
    out: str | _Path,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    overwrite: bool = ...,
) -> _RunRecorded:
    """Carry out a procedure on a bench and record every sample.

    The regulator is made for the line, at the highest vacuum of the procedure, and given to the
    board. With `shot` the accelerometer of a falling mass waits from the first hold on, and every
    drop is kept in the file. Whatever happens, the last act is safe outputs and a closed file;
    Ctrl-C ends it with OPERATOR_STOPPED. Raises QuantityError for what the bench cannot do,
    InstrumentError where it refuses, FileError for the file. Nothing moves if a check of the
    regulator fails; the file stores the failed checks that `accept` accepts.
    """

def bench_wiring(
    board: str | _Path,
    *,
    out: str | _Path | None = ...,
) -> _BoardWiring:
    """List a board's wires and parts, calculate their worst case, and draw the circuit.

    Raises FileError for a file that is no board's, or that is there already; UnknownNameError for
    a board that nobody knows.
    """

def bend(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    vacuum: float | str,
    angle: float | str,
    slip: float | str = ...,
    radius: float | str | None = ...,
    limb_friction: float | str | None = ...,
    atmosphere: float | str | None = ...,
) -> _Bend:
    """Bend a brake between its caps: how soft it is when off, how stiff when jammed.

    The caps turn against each other by `angle` and may approach. With the `radius` of a joint also
    what the sheets' friction becomes where the pull presses them together, with the enclosure's
    outer face at its tension of that slip; `limb_friction` tells how far the caps' pulls differ
    when the brake slides on the limb.
    """

def build(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    workshop: str | _Path | None = ...,
    cutter: str | None = ...,
    kerf: float | str | None = ...,
    stock: str | _Collection[float] | None = ...,
    laser_bed: str | _Collection[float] | None = ...,
    print_bed: str | _Collection[float] | None = ...,
    parallel: int | str = ...,
    series: int | str = ...,
    coupons: bool = ...,
    no_step: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] = ...,
) -> _Built:
    """Write what a workshop needs to make a brake: patterns, parts, mould, instructions.

    The folder appears whole or not at all, and the same brake gives the same bytes. `feasible` is
    False if the brake cannot be drawn (exit code 1), or if a part is loaded beyond its strength or
    a seal leaks (exit code 4); `reason` names the checks, and nothing is written. `accept` accepts
    failed checks by their code, {code: reason}; the folder then states them. Nothing here was cut,
    printed or cast by us. Raises FileError, QuantityError, MissingExtraError.
    """

def calibrate(
    brake: str | _Path | _BrakeFile | _Brake,
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    depth: Literal["exact", "curves", "bayesian"] = ...,
    free: _Sequence[str] = ...,
    vacuum: float | str | None = ...,
    out: str | _Path | None = ...,
    partial: bool = ...,
    atmosphere: float | str | None = ...,
    left_out: _LeftOut = ...,
    within: float | str | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    sampling: _Sampling = ...,
    progress: _Callable[[str, float], None] | None = ...,
    overwrite: bool = ...,
) -> _BrakeCalibration:
    """Scale factor and stiffness of a brake from one or several pulls.

    `files` are paths or traces, several or one. `depth` "exact" takes the numbers from each pull's
    peak and slope; "curves" fits whole curves, all at once, and the enclosure's factor with them,
    and what `free` names: "pressure_exponent", "speed", "force_offset"; "bayesian" samples the same
    parameters (`draws` of each of `chains`, from `seed`). `vacuum` serves files without a sidecar
    that states it. With `out` the calibrated brake is written. `exclude` leaves files or specimens
    out, each with its reason in `because` (in Python also {file: reason}); both stay with result
    and brake. `within` asks how many more pulls, and where, narrow each interval to plus or minus
    this part of its value. If a check fails, nothing is written; `accept` accepts failed checks by
    name, {check: reason}.
    """

def compare(
    *brakes: _Sequence[str | _Path | _BrakeFile | _Brake],
    vacuum: float | str | None = ...,
    atmosphere: float | str | None = ...,
) -> _Comparison:
    """Force over mass of brakes, beside what others make.

    Every row names its source. Without brakes, those of the catalogue (paper, III-F). The first
    brake is also shown at lower vacuums, side by side with others like it, and with more sheets.
    `devices` is a list of rows; `computed` is True for ours. `sheet` compares what a sheet adds
    with the paper's words. `none_found` maps a class without a sourced device to what was looked
    at.
    """

def crash(
    file: str | _Path,
    *,
    filter_class: str = ...,
    sampling: float | str | None = ...,
    before: float | str | None = ...,
    sensor_range: float | str | None = ...,
    falling: bool = ...,
    hic: float | str | None = ...,
    shot: int | str | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _TableOptions = ...,
) -> _CrashFound:
    """Peak, filtered peak, velocity change and duration of an impact in an accelerometer's log.

    The greatest pulse of the log counts. `filter_class` is none, cfc60, cfc180, cfc600 or cfc1000;
    `before` is the length of the quiet part at the beginning. `falling`: the sensor fell freely
    before, so the weight is taken off the velocity change. `hic` is the longest window of the head
    injury criterion. The file may be a run that `bench run --shot` recorded; it states rate and
    range itself.
    """

def design_brake(
    spec: str | _Path | _DesignSpecification,
    *,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _DesignResult:
    """Find the best brake for a set of requirements.

    Beside it: the front, the runner-up and why it lost, what forbids better ones. `feasible` is
    False with `reason`, `killed_by` and `reachable` where nothing meets the constraints;
    contradictions that follow from bounds are found before anything is swept. `chosen` is the best
    design of the grid, `refined` the best between its steps.
    """

def export_c(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    precision: Literal["double", "single"] = ...,
    rope_stiffness: float | str | None = ...,
    strict: bool = ...,
    overwrite: bool = ...,
) -> _Exported:
    """Write the brake as C source for a microcontroller or a simulator.

    C99 that allocates nothing, keeps no global data and needs `sqrt` alone (`pow` too with a
    pressure exponent). A rope counts in series with the brake's stiffness. The law holds c L2 at
    rest; static friction above it is not exported. Raises FileError if a file exists unless
    `overwrite`, QuantityError for sheets that fan out, a speed law or a hyperelastic enclosure.
    """

def export_fmu(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    fmi: Literal["3", "2"] = ...,
    platforms: str | None = ...,
    sources_only: bool = ...,
    rope_stiffness: float | str | None = ...,
    strict: bool = ...,
    overwrite: bool = ...,
) -> _ExportedFmu:
    """Write the brake as a functional mock-up unit for Simulink, Dymola, OpenModelica and others.

    FMI 3.0 or 2.0, co-simulation and model exchange, compiled C: no Python at the target. Inputs
    are elongation, velocity and vacuum, outputs force, slip and energies; parameters carry the
    brake file's own names, units and bounds. Raises FileError if the file exists unless
    `overwrite`, QuantityError for sheets that fan out, a speed law or a hyperelastic enclosure, or
    a platform that is not known; CompilerError where no compiler is found.
    """

def export_mujoco(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    tendon: str = ...,
    vacuum_lag: float | str | None = ...,
    coupling: Literal["limited", "explicit", "implicit"] = ...,
    no_build: bool = ...,
    rope_stiffness: float | str | None = ...,
    strict: bool = ...,
    overwrite: bool = ...,
) -> _ExportedMujoco:
    """Write the brake as an actuator plugin of MuJoCo whose control is the vacuum.

    `actuator.xml` is for `<include>` in a model that has the tendon, `brake.xml` is a model to look
    at. The library is compiled for the MuJoCo that is installed. Raises FileError if a file
    exists unless `overwrite`, CompilerError, MissingExtraError, QuantityError for sheets that fan
    out, a speed law or a hyperelastic enclosure.
    """

def follow(
    line: str | _Path | _LineFile | _Line,
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    profile: str | _Path,
    swing: _Swing = ...,
    settings: _ScheduledSettings = ...,
    slip_noise: float | str = ...,
    model_error: float | str = ...,
    seed: int | str = ...,
    atmosphere: float | str | None = ...,
) -> _FollowedForce:
    """Make a sliding brake's force follow a profile, and say what it cannot follow.

    The profile is drawn between the forces `low` and `high` with a `period` while the brake slips
    at `speed`, or it is a file with time, force and slip.
    """

def friction(
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    test: _FrictionTest = ...,
    brake: str | _Path | _BrakeFile | _Brake | None = ...,
    out: str | _Path | None = ...,
    partial: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
    overwrite: bool = ...,
) -> _Friction:
    """Static and kinetic friction from friction tests: as the paper, ASTM D1894 or ISO 8295 has it.

    `files` are paths or traces, several or one. `normal_force` may come from the files' sidecars,
    or from the 200 g of the two standards; `start` and `end` bound the displacement of the kinetic
    mean, counted from the record's first sample; `area` is that under the sled, for the pressure of
    the test. Where a record sticks and slips, kinetic is None; `accept_stick_slip` takes the middle
    of the stick–slip. With `brake` and `out` the result is written into a copy of the brake's file.
    If a check fails, nothing is written; `accept` accepts failed checks by name, {check: reason}.
    """

def drop(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    mass: float | str,
    speed: float | str | None = ...,
    height: float | str | None = ...,
    vacuum: Literal["tuned"] | float | str | None = ...,
    travel: float | str | None = ...,
    rope_stiffness: float | str | None = ...,
    rope_damping: float | str | None = ...,
    vacuum_history: str | _Path | _History | None = ...,
    log: _LogOptions = ...,
    vacuum_share: float | str | None = ...,
    leak_time: float | str | None = ...,
    held: float | str | None = ...,
    duration: float | str | None = ...,
    sensing: _Sensing = ...,
    warmth: _Warmth = ...,
    no_brake: bool = ...,
    horizontal: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _Stop:
    """Stop a falling mass with the brake, at a vacuum or at "tuned" for a travel (slip).

    Without `rope_stiffness` the mass hangs on the brake alone; with `no_brake` on the rope alone.
    Slip, peak and time refer to the first standstill or the end of travel. Exact at constant
    vacuum; with `rope_damping`, a `vacuum_history` (a file with time and vacuum, or a History) or a
    `duration` (to follow the rebound) it is marched in time. `reading` says what a file's pressure
    counts from (absolute, gauge or vacuum) where its column does not; `columns` and `decimal` are
    as for every log. `vacuum_share` of what the gauge reads presses the sheets. With `leak_time`
    the line is shut off `held` before the rope is taut, and the vacuum leaks away. A mass that has
    not stopped when `duration` is over has the outcome FINISHED and no `stopping_time`; one that
    creeps to rest on an overdamped rope has neither.
    """

def write_campaign(
    spec: str | _Path | _Spec | None = ...,
    *,
    out: str | _Path | None = ...,
    example: bool = ...,
    seed: int | str | None = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _PracticeFiles:
    """Practice files of a virtual laboratory: the truth is known, the machine has its faults.

    The files of a campaign and the truth beside them are written into the folder `out`. `spec` is
    the path of a TOML file, a Spec, or "practice", which is built in; `seed` counts instead of its
    own. Every file says that it is synthetic. Stopped by the keyboard, the files written are whole
    and the result says so. Raises FileError where `out` is not empty and `overwrite` is not set.
    """

def leak(
    file: str | _Path,
    *,
    volume: float | str | None = ...,
    temperature: float | str | None | None = ...,
    zero: float | str | None = ...,
    start: float | str | None = ...,
    end: float | str | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | None = ...,
    options: _LogOptions = ...,
) -> _LeakFound:
    """Leak of a closed chamber from a pressure-hold log.

    `reading` says what the pressure counts from (absolute, gauge, vacuum) where the file does not.
    Without `volume` only rates can be told. A column of temperature is used; else `temperature` is
    that of the gas all the time.
    """

def parts(
    name: str | None = ...,
) -> _PartList:
    """Pumps, valves and sensors of the catalogue, with their numbers in SI and their sources.

    Raises UnknownNameError.
    """

def plan(
    line: str | _Path | _LineFile | _Line,
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    mass: float | str,
    speed: float | str,
    warning: float | str,
    travel: float | str,
    mass_sd: float | str = ...,
    speed_sd: float | str = ...,
    standing: float | str = ...,
    stored: float | str | None = ...,
    rope_stiffness: float | str | None = ...,
    horizontal: bool = ...,
    fluid: Literal["air", "water"] = ...,
    vacuum_share: float | str | None = ...,
    leak_time: float | str | None = ...,
    samples: int | str = ...,
    seed: int | str = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | None = ...,
) -> _CollisionPlan:
    """Whether the vacuum is there when a collision comes, and what to build if not.

    The estimate is the mean of mass and speed. The reservoir begins as low as pump and leak come
    to unless `stored` says otherwise. `vacuum_share` of what the gauge reads presses the sheets.
    `leak_time` is a laminar leak of the chamber, which goes on during the stop.
    """

def force(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str | _ArrayLike,
    vacuum: float | str | _ArrayLike,
    sliding_speed: float | str | None = ...,
    atmosphere: float | str | None = ...,
) -> _BrakeForce:
    """Force of the sliding brake at a slip and a vacuum.

    Arrays of slip and vacuum broadcast. Without a `sliding_speed` it is the force at the speed at
    which friction was measured. Raises QuantityError for a slip beyond the overlap or a vacuum
    above the atmosphere.
    """

def new(
    name: str,
    start: str | _Path,
    out: str | _Path,
    *,
    overwrite: bool = ...,
) -> _NewBrake:
    """Write a commented brake file to edit, starting from another brake.

    Raises FileError where `out` exists and `overwrite` is not set, or the name will not do.
    """

def show(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    atmosphere: float | str | None = ...,
) -> _BrakeSummary:
    """What a brake weighs, holds, stores and bears, and where each of its numbers comes from."""

def vacuum(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str | _ArrayLike,
    force: float | str | _ArrayLike,
    sliding_speed: float | str | None = ...,
    atmosphere: float | str | None = ...,
) -> _VacuumForForce:
    """Vacuum that makes the sliding brake resist with a force at a slip.

    `feasible` is False, with a `reason`, for a force below the enclosure's own or above that at
    the site's full vacuum. Arrays of slip and force broadcast; the vacuum is NaN for elements
    without one. Without a `sliding_speed` the force is that at the speed at which friction was
    measured.
    """

def publish(
    campaign: str | _Path,
    *,
    out: str | _Path,
    brake: str | _Path | _BrakeFile | _Brake | None = ...,
    line: str | _Path | None = ...,
    measurements: _Measurements = ...,
    test: _FrictionTest = ...,
    depth: Literal["exact", "curves"] = ...,
    vacuum: float | str | None = ...,
    atmosphere: float | str | None = ...,
    left_out: _LeftOut = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    title: str | None = ...,
    licence: str | None = ...,
    author: _Sequence[str] = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _Published:
    """Write one campaign as a dataset that stands alone, so that others can recompute its numbers.

    The raw files are copied untouched, with their sidecars and all else that lies in the folder
    `campaign`. Beside them stand brake and line, report, results, recipe, checksums, and a
    description that repositories read (RO-Crate 1.1). A measurement that states a normal force is a
    friction test, any other a pull; a calibrated brake in the folder says which pulls it was
    calibrated on, and `measurements` say it otherwise, as in `report`. If a check fails, nothing is
    written; `accept` accepts failed checks by name, {check: reason}, and the dataset states them.
    Raises FileError where the
    folder does not say which brake was tested and `brake` does not either, or where `out` exists
    and is not a dataset to be replaced with `overwrite`.
    """

def recompute(
    dataset: str | _Path,
    *,
    progress: _Callable[[str, float], None] | None = ...,
) -> _Recomputed:
    """Compute a published dataset again from its raw files, and list everything that differs.

    Numbers, tables, page, PDF, figures, calibrated brake and description are derived again. Two
    numbers are the same up to a relative difference of 1e-6. A file that does not hold what its
    checksum says, has no checksum, or is missing is named, whatever the numbers do. If other
    versions of the programs wrote the dataset, words and drawings may differ: then the numbers in
    them are compared, and `not_compared` lists the rest. Nothing is written. Raises FileError for
    a folder that is not a dataset.
    """

def pull(
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    tare: bool = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _Pulls:
    """What measured pulls show: slack, preload, onset, stiffness, peak, stick–slip, unloading.

    `files` are paths or traces, several or one. Nothing is subtracted from a force unless `tare`
    asks for the force before the load rises.
    """

def pump_down(
    file: str | _Path,
    with_volume: str | _Path | None = ...,
    *,
    volume: float | str | None = ...,
    flow: float | str | None = ...,
    added_volume: float | str | None = ...,
    compliance: Literal["fit"] | float | str | None = ...,
    zero: float | str | None = ...,
    start: float | str | None = ...,
    end: float | str | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | None = ...,
    options: _LogOptions = ...,
) -> _PumpFound:
    """Volume and pump flow from pump-down logs, as far as they tell them.

    One log gives flow over volume. `volume`, `flow`, or the log `with_volume` of the same line with
    `added_volume` gives both. `compliance` is the volume lost per vacuum, or "fit".
    """

def records_add(
    files: _Sequence[str | _Path] | str | _Path,
    *,
    db: str | None = ...,
    serial: str | None = ...,
) -> _RecordsAdded:
    """Add files to the records, linked with what they come from.

    Links follow from digests inside the files. A file that is in the records already, or that is
    nothing the records take, is refused; the others are added in one transaction. Raises
    RecordsError for the database, and then nothing was added.
    """

def records_list(
    *,
    db: str | None = ...,
) -> _RecordsListed:
    """Every record, oldest first.

    Raises RecordsError for the database.
    """

def records_show(
    ident: str,
    *,
    db: str | None = ...,
) -> _RecordShown:
    """One record, what it comes from and what comes from it.

    Raises RecordsError where there is none, or several have that name.
    """

def records_verify(
    folders: _Sequence[str | _Path] = ...,
    *,
    db: str | None = ...,
) -> _RecordsVerified:
    """Whether every file still has the bytes that it had.

    Withdrawn files are not looked for. Exits with 1 where something is changed or missing. Raises
    RecordsError for the database.
    """

def records_withdraw(
    ident: str,
    *,
    why: str,
    db: str | None = ...,
) -> _RecordWithdrawn:
    """Mark a record as one that counts no more; it stays, with the reason.

    A file that was withdrawn cannot be added again. Raises RecordsError where there is no such
    record, or it was withdrawn before.
    """

def regulate(
    line: str | _Path | _LineFile | _Line,
    *,
    target: float | str,
    settings: _RegulatorSettings = ...,
    duration: float | str | None = ...,
    recorded: _RecordedStep = ...,
    fault: Literal[
        "pump-dead",
        "pump-weak",
        "line-blocked",
        "leak",
        "sensor-nan",
        "sensor-stuck",
        "sensor-offset",
    ]
    | None = ...,
    fault_at: float | str | None = ...,
    seed: int | str = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | None = ...,
) -> _Regulation:
    """Bring a line to a vacuum and hold it there, in closed loop with a noisy sensor.

    With a recorded `step` gains, detectors and the line simulated are those that the log shows
    (`identified`), and its scatter is the noise unless that is given. `detection` is the longest
    time [s] until each fault is said at this vacuum (None: never). `fault` breaks the line or the
    sensor from `fault_at` on; `said_after` is None where it said nothing, or spoke before.
    """

def write_report(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    measurements: _Measurements = ...,
    test: _FrictionTest = ...,
    depth: Literal["exact", "curves"] = ...,
    vacuum: float | str | None = ...,
    atmosphere: float | str | None = ...,
    left_out: _LeftOut = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    issued: _Issued = ...,
    overwrite: bool = ...,
    command: str = ...,
    date: str | None = ...,
    names: _Mapping[str, str] | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _Report:
    """Measurements of one brake as a page: friction, calibration, validation, HTML and PDF.

    Writes report.html, report.pdf, figures, numbers.csv and results.json into the folder `out`.
    `friction` tests give the friction, `pulls` the calibration, `validate` is what the calibrated
    brake is compared with; each may be left out. Of `pulls` alone some can be kept for validation:
    `calibrate_on` names those to calibrate on, or `holdout` holds back a vacuum ("46.1 kPa"), a
    speed ("19 mm/s") or a repeat ("repeat 3"). Without any of these the brake is compared with the
    pulls it was calibrated on, and the page says so. `vacuum` serves files without a sidecar; the
    options of friction tests, `depth` and `exclude` are as in `friction` and `calibrate`. `command`
    is what the page says it was made with, `date` (ISO) is today unless given; `names` {file name:
    what the report calls it} serves files that lie under other names than their own.
    `report_number` and `customer` appear on the pages; sidecars may state them instead. If a check
    fails, nothing is written; `accept` accepts failed checks by name, {check: reason}. Raises
    FileError where a report exists and `overwrite` is not set.
    """

def schema(
    name: str | None = ...,
) -> _Schemas:
    """JSON Schema of what a command prints with --json.

    Draft 2020-12; beside type and meaning each key has its SI `unit`. What is printed is itself a
    schema: `anyOf` refers to the definitions of `$defs`, one for each command.
    """

class Sensing(_Sensing):
    """What measures the stop: an accelerometer, its low-pass and rate, and a filter after it."""

    def __init__(
        self,
        *,
        accelerometer: str | _Accelerometer = ...,
        filter_class: str | None = ...,
        low_pass: float | str | None = ...,
        sampling: float | str | None = ...,
    ) -> None: ...

class Warmth(_Warmth):
    """What the temperature rise of the sheets is judged by."""

    def __init__(
        self,
        *,
        allowed_rise: float | str | None = ...,
        film_coefficient: float | str | None = ...,
    ) -> None: ...

def sleeve(
    files: _Sequence[str | _Path] | str | _Path,
    *,
    area: float | str | None = ...,
    gauge_length: float | str | None = ...,
    start: float | str = ...,
    end: float | str = ...,
    fit_to: float | str | None = ...,
    material: str | None = ...,
    brake: str | _Path | _BrakeFile | _Brake | None = ...,
    out: str | _Path | None = ...,
    hyperelastic: bool = ...,
    partial: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _TableOptions = ...,
    overwrite: bool = ...,
) -> _SiliconeFit:
    """Modulus and hyperelastic fit of the enclosure's silicone from ASTM D412 curves.

    `start` and `end` bound the strain of the initial slope, `fit_to` is the greatest strain that is
    fitted. Each file is one specimen; specimens of one material are pooled. `material` names the
    silicone of the catalogue to compare with, where the files do not. With `brake` and `out` the
    mean 100 % modulus is written into a copy of the brake, with `hyperelastic` the model too.
    """

def stick_slip(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    vacuum: float | str,
    speed: float | str,
    mass: float | str | None = ...,
    mount_stiffness: float | str | None = ...,
    damping: float | str = ...,
    stribeck_speed: float | str = ...,
    static: float | str | None = ...,
    slip: float | str = ...,
    travel: float | str | None = ...,
    atmosphere: float | str | None = ...,
) -> _StickSlip:
    """Pull a brake at one speed and see whether it sticks and slips, and what would stop it.

    It starts from rest at `slip`. Amplitude and forces are those of the last slip of the run.
    `critical_speed`, `stable_speed` and `stiffness_needed` hold friction at its value at `slip`.
    `stribeck_speed` 0 means that static friction is lost at once. Raises FitError for a run of too
    many steps.
    """

def sweep(
    spec: str | _Path | _DesignSpecification,
    *,
    out: str | _Path,
    scheduler: str | None = ...,
    block: int | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _DesignSweep:
    """Compute every design of a specification, in blocks on disk.

    The folder is new, empty or that of the same sweep, which then goes on: `blocks_found` of its
    blocks were there already. `block` is the number of designs in one, `scheduler` the address of a
    Dask cluster. Stopped from the keyboard, `complete` is False and the same call goes on. Raises
    FileError for a folder of something else, MissingExtraError without pyarrow or Dask, and
    ClusterError.
    """

def tensile(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    vacuum: float | str | None = ...,
    speed: float | str | None = ...,
    travel: float | str | None = ...,
    procedure: str | _Procedure | None = ...,
    model: Literal["lumped", "stack"] = ...,
    static: bool = ...,
    one_by_one: bool = ...,
    interfaces: _Interfaces | None = ...,
    housing: _Housing | None = ...,
    scatter: float | str | None = ...,
    samples: int | str | None = ...,
    seed: int | str | None = ...,
    vacuum_share: float | str | None = ...,
    leak_time: float | str | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
    atmosphere: float | str | None = ...,
) -> _Tensile:
    """Pull a brake in a simulated test machine.

    Either vacuum, speed and travel (elongation of the crosshead), or a procedure. Only for the
    model "stack": `static` friction before an interface slides, and `one_by_one`: interfaces that a
    break overloads let go one after the other, the most overloaded first, and not together;
    `interfaces` that differ, a `housing` that rubs, and `scatter`, the relative SD of the
    interfaces' friction: then `samples` (1000) stacks, drawn from `seed` (1), give mean and SD of
    peak, stiffness and onset; interrupted from the keyboard, of those that are done. `vacuum_share`
    of what the gauge reads presses the sheets. With `leak_time` the line is shut off after every
    evacuation and the vacuum leaks away from then on; not in the stack, which keeps the vacuum it
    starts with. Raises ProcedureError or QuantityError for what contradicts itself.
    """

def tune(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    mass: float | str,
    travel: float | str,
    speed: float | str | None = ...,
    height: float | str | None = ...,
    rope_stiffness: float | str | None = ...,
    horizontal: bool = ...,
    atmosphere: float | str | None = ...,
) -> _TunedVacuum:
    """Vacuum that stops a mass within a travel (slip of the brake), exactly and by eq. 10.

    The mass arrives with `speed` or falls from `height`. Where there is no such vacuum, `reason`
    says why and what would do: the speeds that can be stopped so, another travel, another number
    of sheets, more brakes side by side, each by itself. Each was tuned before it is named.
    """

def rise(
    line: str | _Path | _LineFile | _Line,
    *,
    target: float | str,
    fluid: Literal["air", "water"] = ...,
    atmosphere: float | str | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _VacuumRise:
    """How fast a line brings a vacuum, and how fast it lets go of it.

    The pump runs full on until the target is reached. `rise_time` is None, `feasible` False and
    `reason` says what can be had where the target is never reached. In air the line is integrated;
    `closed_form` beside it holds where the volume is rigid and no tube or orifice counts.
    `fall_time` is by the vent valve from when it is open, or the pumps run backwards (`fall_by`),
    with `closed_form_fall` likewise; None where the line has neither. `tube_delay` and `tube_lag`
    are None without a tube, and in water. A tube in many cells takes a while.
    """

def validate(
    brake: str | _Path | _BrakeFile | _Brake,
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    vacuum: float | str | None = ...,
    atmosphere: float | str | None = ...,
    left_out: _LeftOut = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _ModelErrors:
    """How far the brake's model lies from measured pulls.

    `files` are paths or traces, several or one. identify.validation.metrics says over which window.
    `uncalibrated` holds the same errors of the brake with a scale factor of 1 and the sheets' own
    stiffness. A warning says where the brake was calibrated on one of the files. `exclude` leaves
    files out, each with its reason in `because` (in Python also {file: reason}).
    """

def reproduce(
    out: str | _Path,
    *,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _Reproduction:
    """Recompute the paper and compare every claim with our result.

    Writes report.html, results.json and the figures. Raises FileError if the report exists and
    `overwrite` is not set, or the folder cannot be created.
    """

def apply(
    scenario: str | _Path | None = ...,
    *,
    out: str | _Path | None = ...,
    names: bool = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _MachineResult:
    """Check a machine of the paper's Fig. 13 against its limits.

    It is a seat belt, neck guard, ankle clutch or rehabilitation orthosis with its loads and
    limits. With `out` a page with pictures is written there (`page`). `feasible` is whether every
    one of `limits` is met, `reason` the one that decides, and `conclusion` a summary with the
    requirements. `brakes_needed` is None if no number of brakes is enough. `results` has the
    machine's own keys; `units` the unit of each. Raises FileError for an invalid file,
    QuantityError for values out of bounds.
    """
