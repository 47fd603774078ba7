"""The public names as a caller sees them, from `_names.pyi` by `docs/generate.py`.

The functions of the commands take text with units as well as SI numbers.
"""

from collections.abc import Callable as _Callable
from collections.abc import Collection as _Collection
from collections.abc import Mapping as _Mapping
from collections.abc import Sequence as _Sequence
from pathlib import Path as _Path
from typing import Any, Literal, overload

from numpy.typing import ArrayLike as _ArrayLike

from layerjam import laws as laws
from layerjam._version import __version__ as __version__
from layerjam.bench.commands.bench import BenchCleared as _BenchCleared
from layerjam.bench.commands.bench import BenchServed as _BenchServed
from layerjam.bench.commands.bench import BenchState as _BenchState
from layerjam.bench.commands.bench import BoardFlashed as _BoardFlashed
from layerjam.bench.commands.bench import BoardWiring as _BoardWiring
from layerjam.bench.commands.bench_check import BenchChecked as _BenchChecked
from layerjam.bench.commands.bench_check import BenchZeroed as _BenchZeroed
from layerjam.bench.commands.bench_faults import FaultCampaign as _FaultCampaign
from layerjam.bench.commands.bench_faults import Soak as _Soak
from layerjam.bench.commands.bench_run import DropRigOptions as _DropRigOptions
from layerjam.bench.commands.bench_run import RunExported as _RunExported
from layerjam.bench.commands.bench_run import RunLogged as _RunLogged
from layerjam.bench.commands.bench_run import RunRecorded as _RunRecorded
from layerjam.bench.commands.follow import FollowedForce as _FollowedForce
from layerjam.bench.commands.follow import ScheduledSettings as _ScheduledSettings
from layerjam.bench.commands.follow import Swing as _Swing
from layerjam.bench.commands.plan import CollisionPlan as _CollisionPlan
from layerjam.bench.commands.regulate import Regulation as _Regulation
from layerjam.bench.commands.regulator import RecordedStep as _RecordedStep
from layerjam.bench.commands.regulator import RegulatorSettings as _RegulatorSettings
from layerjam.brake.commands.bend import Bend as _Bend
from layerjam.brake.commands.drop import Stop as _Stop
from layerjam.brake.commands.drop import observed as observed
from layerjam.brake.commands.edit import edit as edit
from layerjam.brake.commands.edit import edit_line as edit_line
from layerjam.brake.commands.force import BrakeForce as _BrakeForce
from layerjam.brake.commands.force import VacuumForForce as _VacuumForForce
from layerjam.brake.commands.new import NewBrake as _NewBrake
from layerjam.brake.commands.parts import PartList as _PartList
from layerjam.brake.commands.sensor import Sensing as _Sensing
from layerjam.brake.commands.sensor import Warmth as _Warmth
from layerjam.brake.commands.sensor import heating as heating
from layerjam.brake.commands.sensor import reading as reading
from layerjam.brake.commands.stick_slip import StickSlip as _StickSlip
from layerjam.brake.commands.tensile import Tensile as _Tensile
from layerjam.brake.commands.tuning import TunedVacuum as _TunedVacuum
from layerjam.brake.commands.vacuum_line import VacuumRise as _VacuumRise
from layerjam.brake.device.brake import Brake as Brake
from layerjam.brake.device.brake import Brake as _Brake
from layerjam.brake.device.brake_file import BrakeFile as BrakeFile
from layerjam.brake.device.brake_file import BrakeFile as _BrakeFile
from layerjam.brake.device.enclosure import Enclosure as Enclosure
from layerjam.brake.device.load import load as load
from layerjam.brake.device.mount import Mount as Mount
from layerjam.brake.device.mount import Rope as Rope
from layerjam.brake.device.mount import Site as Site
from layerjam.brake.device.sheets import Film as Film
from layerjam.brake.device.sheets import Sheets as Sheets
from layerjam.brake.fluid.line import Line as _Line
from layerjam.brake.fluid.line_file import LineFile as _LineFile
from layerjam.brake.fluid.line_file import load_line as load_line
from layerjam.brake.mechanics.stick_slip.stribeck import Stribeck as Stribeck
from layerjam.brake.simulate.accelerometer import Accelerometer as Accelerometer
from layerjam.brake.simulate.accelerometer import Accelerometer as _Accelerometer
from layerjam.brake.simulate.batch import batch as batch
from layerjam.brake.simulate.procedure import Procedure as Procedure
from layerjam.brake.simulate.procedure import Procedure as _Procedure
from layerjam.brake.simulate.procedure import parse_procedure as parse_procedure
from layerjam.brake.simulate.record import DropRecord as DropRecord
from layerjam.brake.simulate.record import Outcome as Outcome
from layerjam.brake.simulate.record import TensileRecord as TensileRecord
from layerjam.brake.simulate.stack_layout import Housing as Housing
from layerjam.brake.simulate.stack_layout import Housing as _Housing
from layerjam.brake.simulate.stack_layout import Interfaces as Interfaces
from layerjam.brake.simulate.stack_layout import Interfaces as _Interfaces
from layerjam.brake.simulate.vacuum_history import History as History
from layerjam.brake.simulate.vacuum_history import History as _History
from layerjam.cli.demo import DemoResult as _DemoResult
from layerjam.core.command.log_options import LogOptions as _LogOptions
from layerjam.core.command.results import Result as Result
from layerjam.core.command.schema import Schemas as _Schemas
from layerjam.core.conversion import HasUnit as _HasUnit
from layerjam.core.errors import LayerjamError as LayerjamError
from layerjam.core.errors import Notice as Notice
from layerjam.core.toml_files.source import Source as Source
from layerjam.interop.commands.export import Exported as _Exported
from layerjam.interop.commands.export import ExportedFmu as _ExportedFmu
from layerjam.interop.commands.export import ExportedHtml as _ExportedHtml
from layerjam.interop.commands.export import ExportedMujoco as _ExportedMujoco
from layerjam.laboratory.campaigns.campaign import Campaign as Campaign
from layerjam.laboratory.campaigns.spec import Spec as _Spec
from layerjam.laboratory.commands.ageing import Ageing as _Ageing
from layerjam.laboratory.commands.calibration import BrakeCalibration as _BrakeCalibration
from layerjam.laboratory.commands.calibration import Sampling as _Sampling
from layerjam.laboratory.commands.crash import CrashFound as _CrashFound
from layerjam.laboratory.commands.enclosure import SiliconeFit as _SiliconeFit
from layerjam.laboratory.commands.friction import Friction as _Friction
from layerjam.laboratory.commands.friction import FrictionTest as _FrictionTest
from layerjam.laboratory.commands.lab import PracticeFiles as _PracticeFiles
from layerjam.laboratory.commands.lab import lab_example as example_campaign
from layerjam.laboratory.commands.leak import LeakFound as _LeakFound
from layerjam.laboratory.commands.left_out import LeftOut as _LeftOut
from layerjam.laboratory.commands.measurements import Measurements as _Measurements
from layerjam.laboratory.commands.publish import Published as _Published
from layerjam.laboratory.commands.publish import Recomputed as _Recomputed
from layerjam.laboratory.commands.pull import Pulls as _Pulls
from layerjam.laboratory.commands.pump_down import PumpFound as _PumpFound
from layerjam.laboratory.commands.reading import DataFrame as _DataFrame
from layerjam.laboratory.commands.reading import FileOptions as _FileOptions
from layerjam.laboratory.commands.reading import SpecimenOptions as _SpecimenOptions
from layerjam.laboratory.commands.reading import TableOptions as _TableOptions
from layerjam.laboratory.commands.records import RecordsAdded as _RecordsAdded
from layerjam.laboratory.commands.records import RecordShown as _RecordShown
from layerjam.laboratory.commands.records import RecordsListed as _RecordsListed
from layerjam.laboratory.commands.records import RecordsVerified as _RecordsVerified
from layerjam.laboratory.commands.records import RecordWithdrawn as _RecordWithdrawn
from layerjam.laboratory.commands.report import Issued as _Issued
from layerjam.laboratory.commands.report import Report as _Report
from layerjam.laboratory.commands.validation import ModelErrors as _ModelErrors
from layerjam.laboratory.identify.friction.standards import Standard as Standard
from layerjam.laboratory.measure.history import read_history as read_history
from layerjam.laboratory.measure.log import read_log as read_log
from layerjam.laboratory.measure.options import ReadingOptions as ReadingOptions
from layerjam.laboratory.measure.readers.read import read_trace as read_trace
from layerjam.laboratory.measure.readers.read import read_traces as read_traces
from layerjam.laboratory.measure.trace import Trace as Trace
from layerjam.laboratory.measure.trace import Trace as _Trace
from layerjam.studies.choi2018.reproduce import Reproduction as _Reproduction
from layerjam.studies.machines.apply import MachineResult as _MachineResult
from layerjam.workshop.commands.array import ArrayPull as _ArrayPull
from layerjam.workshop.commands.build import Built as _Built
from layerjam.workshop.commands.catalogue import Catalogue as _Catalogue
from layerjam.workshop.commands.compare import Comparison as _Comparison
from layerjam.workshop.commands.design import DesignResult as _DesignResult
from layerjam.workshop.commands.design_new import NewSpecification as _NewSpecification
from layerjam.workshop.commands.show import BrakeSummary as _BrakeSummary
from layerjam.workshop.commands.sweep import DesignSweep as _DesignSweep
from layerjam.workshop.design.requirements import DesignSpecification as _DesignSpecification
from layerjam.workshop.design.specification import load_spec as load_spec

class _BenchClearedResult(_BenchCleared):
    def require(self) -> _BenchClearedKnown: ...

class _BenchClearedKnown(_BenchClearedResult):
    fault: str
    vacuum: float

class _BoardFlashedResult(_BoardFlashed):
    def require(self) -> _BoardFlashedKnown: ...

class _BoardFlashedKnown(_BoardFlashedResult):
    image_sha256: str
    identity: str

class _BenchStateResult(_BenchState):
    def require(self) -> _BenchStateKnown: ...

class _BenchStateKnown(_BenchStateResult):
    fault: str
    vacuum: float
    safe_state: str
    vent_rest: str
    zero_age: float

class _BoardWiringResult(_BoardWiring):
    def require(self) -> _BoardWiringKnown: ...

class _BoardWiringKnown(_BoardWiringResult):
    out: str

class _BenchCheckedResult(_BenchChecked):
    def require(self) -> _BenchCheckedKnown: ...

class _BenchCheckedKnown(_BenchCheckedResult):
    leak: float
    rate: float
    top: float
    vent: float
    lag: float
    zero: float
    noise: float
    expected: dict[str, float]
    reason: str
    tuned: str
    next_step: str

class _SoakResult(_Soak):
    def require(self) -> _SoakKnown: ...

class _SoakKnown(_SoakResult):
    heap_growth: int

class _RunExportedResult(_RunExported):
    def require(self) -> _RunExportedKnown: ...

class _RunExportedKnown(_RunExportedResult):
    outcome: str
    sidecar: str

class _RunLoggedResult(_RunLogged):
    def require(self) -> _RunLoggedKnown: ...

class _RunLoggedKnown(_RunLoggedResult):
    reason: str

class _RunRecordedResult(_RunRecorded):
    def require(self) -> _RunRecordedKnown: ...

class _RunRecordedKnown(_RunRecordedResult):
    reason: str
    fault: str
    fault_time: float
    file: str
    shots: _Sequence[_Mapping[str, Any]]

class _FollowedForceResult(_FollowedForce):
    def require(self) -> _FollowedForceKnown: ...

class _FollowedForceKnown(_FollowedForceResult):
    bandwidth: float
    bode: list[dict[str, float]]
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _CollisionPlanResult(_CollisionPlan):
    def require(self) -> _CollisionPlanKnown: ...

class _CollisionPlanKnown(_CollisionPlanResult):
    reason: str
    needed: float
    safe_vacuum: float
    slip: float
    peak_force: float
    peak_g: float
    end_speed: float
    dissipated_energy: float
    vacuum_change: float
    slip_change: float
    peak_change: float
    coupling_matters: bool
    tuned_slip: float
    tuned_peak_force: float
    tuned_peak_g: float
    tuned_vacuum_change: float
    tuned_slip_change: float
    tuned_peak_change: float
    tuned_coupling_matters: bool
    coupling_rounds: int
    coupling_remaining: float
    full_expected_g: float
    full_g_95: float
    tuned_expected_g: float
    tuned_g_95: float
    expected_g_error: float
    warning_needed: float
    warning_needed_reason: str
    reservoir_needed: float
    reservoir_needed_reason: str
    conductance_needed: float
    conductance_needed_reason: str
    standing_needed: float
    standing_needed_reason: str
    cv_needed: float
    reservoir_conductance: float
    conductance_volume: float
    standing_needed_power: float
    standing_needed_electric: float
    standing_needed_force: float
    pump_energy: float
    standing_power: float
    standing_electric: float
    heat_per_work: float
    heat_per_pump_energy: float
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _RegulationResult(_Regulation):
    def require(self) -> _RegulationKnown: ...

class _RegulationKnown(_RegulationResult):
    rise_time: float
    steady_error: float
    ripple: float
    fault_time: float
    fault: str
    fault_at: float
    broken: str
    said_after: float
    gain: float
    integral_time: float
    identified: _Mapping[str, Any]
    detection: _Mapping[str, float | None]

class _BendResult(_Bend):
    def require(self) -> _BendKnown: ...

class _BendKnown(_BendResult):
    buckling_moment: float
    least_radius: float
    joint_friction: float
    joint_friction_off: float
    amplification: float
    sheet_stress: float
    end_force_ratio: float

class _StopResult(_Stop):
    def require(self) -> _StopKnown: ...

class _StopKnown(_StopResult):
    slip: float
    peak_force: float
    peak_deceleration: float
    peak_g: float
    stopping_time: float
    dissipated_energy: float
    end_speed: float
    crash_force: float
    crash_g: float
    vacuum: float
    outcome: str
    speed: float
    reason: str
    least_stiffness: float
    slip_at_end: float
    outcome_at_end: str
    measured_peak: float
    measured_peak_g: float
    measured_peak_time: float
    peak_loss: float
    measured_rate: float
    accelerometer: str
    filter: str
    saturated: bool
    temperature_rise: float
    temperature_rise_of_sheets: float
    stops_per_minute: float
    allowed_rise: float
    film_coefficient: float
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _BrakeForceResult(_BrakeForce):
    def require(self) -> _BrakeForceKnown: ...

class _BrakeForceKnown(_BrakeForceResult):
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _BrakeForceArray(_BrakeForce):
    sheet_friction: Any
    enclosure_force: Any
    force: Any

class _VacuumForForceResult(_VacuumForForce):
    def require(self) -> _VacuumForForceKnown: ...

class _VacuumForForceKnown(_VacuumForForceResult):
    safe_vacuum: float
    vacuum: float
    reason: str
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _VacuumForForceArray(_VacuumForForce):
    safe_vacuum: Any
    confidence: Any
    vacuum: Any
    feasible: Any
    least_force: Any
    greatest_force: Any

class _StickSlipResult(_StickSlip):
    def require(self) -> _StickSlipKnown: ...

class _StickSlipKnown(_StickSlipResult):
    amplitude: float
    relative_amplitude: float
    force_high: float
    force_low: float
    slip_per_event: float
    period: float
    critical_speed: float
    stable_speed: float
    stiffness_needed: float

class _TensileResult(_Tensile):
    def require(self) -> _TensileKnown: ...

class _TensileKnown(_TensileResult):
    samples: int
    seed: int
    scatter: float
    peak_mean: float
    peak_sd: float
    stiffness_mean: float
    stiffness_sd: float
    onset_mean: float
    onset_sd: float
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _TunedVacuumResult(_TunedVacuum):
    def require(self) -> _TunedVacuumKnown: ...

class _TunedVacuumKnown(_TunedVacuumResult):
    safe_vacuum: float
    confidence: float
    vacuum: float
    vacuum_eq10: float
    reason: str
    floor_g: float
    least_speed: float
    greatest_speed: float
    travel_needed: float
    sheets_needed: int
    brakes_needed: int
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _VacuumRiseResult(_VacuumRise):
    def require(self) -> _VacuumRiseKnown: ...

class _VacuumRiseKnown(_VacuumRiseResult):
    rise_time: float
    fall_time: float
    fall_by: str
    reason: str
    closed_form: float
    closed_form_fall: float
    gas_work: float
    tube_delay: float
    tube_lag: float

class _ExportedResult(_Exported):
    def require(self) -> _ExportedKnown: ...

class _ExportedKnown(_ExportedResult):
    reason: str

class _ExportedFmuResult(_ExportedFmu):
    def require(self) -> _ExportedFmuKnown: ...

class _ExportedFmuKnown(_ExportedFmuResult):
    reason: str
    bytes: int
    compiler: str

class _ExportedHtmlResult(_ExportedHtml):
    def require(self) -> _ExportedHtmlKnown: ...

class _ExportedHtmlKnown(_ExportedHtmlResult):
    reason: str
    bytes: int
    sheet_friction: float
    holds: float

class _ExportedMujocoResult(_ExportedMujoco):
    def require(self) -> _ExportedMujocoKnown: ...

class _ExportedMujocoKnown(_ExportedMujocoResult):
    reason: str
    library: str
    mujoco_version: str

class _AgeingResult(_Ageing):
    def require(self) -> _AgeingKnown: ...

class _AgeingKnown(_AgeingResult):
    file: str

class _BrakeCalibrationResult(_BrakeCalibration):
    def require(self) -> _BrakeCalibrationKnown: ...

class _BrakeCalibrationKnown(_BrakeCalibrationResult):
    scale_factor_eq8: float
    stiffness_eq9: float
    peak_force: float
    peak_elongation: float
    enclosure_factor: float
    pressure_exponent: float
    speed_slope: float
    reference_pressure: float
    reference_speed: float
    bootstrap: _Mapping[str, Any]
    leave_one_out: _Mapping[str, Any]
    identifiability: _Mapping[str, Any]
    posterior: _Mapping[str, Any]
    more_pulls: _Mapping[str, Any]
    file: str

class _CrashFoundResult(_CrashFound):
    def require(self) -> _CrashFoundKnown: ...

class _CrashFoundKnown(_CrashFoundResult):
    hic: float
    hic_window: _Sequence[float]

class _SiliconeFitResult(_SiliconeFit):
    def require(self) -> _SiliconeFitKnown: ...

class _SiliconeFitKnown(_SiliconeFitResult):
    material: str
    specimens: int
    modulus_100: float
    modulus_100_sd: float
    data_sheet: float
    difference: float
    initial_modulus: float
    initial_modulus_sd: float
    modulus_300: float
    strength: float
    strain_at_end: float
    model: str
    parameters: _Mapping[str, float]
    why: str
    model_modulus: float
    strain_range: _Sequence[float]
    rmse: float
    error_at_100: float
    stable: bool
    models: _Mapping[str, Any]
    file: str

class _FrictionResult(_Friction):
    def require(self) -> _FrictionKnown: ...

class _FrictionKnown(_FrictionResult):
    kinetic: float
    static_sd: float
    kinetic_sd: float
    stick_slip: _Mapping[str, Any]
    file: str

class _PracticeFilesResult(_PracticeFiles):
    def require(self) -> _PracticeFilesKnown: ...

class _PracticeFilesKnown(_PracticeFilesResult):
    folder: str
    files: _Sequence[str]
    friction_tests: int
    pulls: int
    samples: int
    faulty: int
    seed: int
    truth: str
    next: _Sequence[str]
    stopped: bool

class _LeakFoundResult(_LeakFound):
    def require(self) -> _LeakFoundKnown: ...

class _LeakFoundKnown(_LeakFoundResult):
    time_constant: float
    time_constant_low: float
    time_constant_high: float
    conductance: float
    leak_rate: float
    leak_rate_low: float
    leak_rate_high: float
    leak_rate_sccm: float
    zero_fitted: float

class _PublishedResult(_Published):
    def require(self) -> _PublishedKnown: ...

class _PublishedKnown(_PublishedResult):
    folder: str
    crate: str
    checksums: str
    fingerprint: str
    report: str
    licence: str

class _RecomputedResult(_Recomputed):
    def require(self) -> _RecomputedKnown: ...

class _RecomputedKnown(_RecomputedResult):
    equal: bool
    fingerprint: str

class _PumpFoundResult(_PumpFound):
    def require(self) -> _PumpFoundKnown: ...

class _PumpFoundKnown(_PumpFoundResult):
    rate_with_volume: float
    volume: float
    volume_low: float
    volume_high: float
    flow: float
    flow_low: float
    flow_high: float
    compliance_ratio: float
    compliance_ratio_low: float
    compliance_ratio_high: float
    compliance: float

class _ReportResult(_Report):
    def require(self) -> _ReportKnown: ...

class _ReportKnown(_ReportResult):
    report: str
    pdf: str
    numbers: str
    results: str
    friction: _Mapping[str, Any]
    calibration: _Mapping[str, Any]
    validation: _Mapping[str, Any]

class _ModelErrorsResult(_ModelErrors):
    def require(self) -> _ModelErrorsKnown: ...

class _ModelErrorsKnown(_ModelErrorsResult):
    mape_sd: float
    mape_conditions_sd: float
    r_squared: float
    scatter: _Mapping[str, Any]
    uncalibrated: _Mapping[str, Any]

class _MachineResultResult(_MachineResult):
    def require(self) -> _MachineResultKnown: ...

class _MachineResultKnown(_MachineResultResult):
    machine: str
    scenario: str
    feasible: bool
    reason: str
    conclusion: str
    brakes_needed: int
    mass: float
    limits: _Sequence[_Mapping[str, Any]]
    page: str
    results: _Mapping[str, Any]
    scenarios: _Sequence[str]

class _ArrayPullResult(_ArrayPull):
    def require(self) -> _ArrayPullKnown: ...

class _ArrayPullKnown(_ArrayPullResult):
    until: float
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _BuiltResult(_Built):
    def require(self) -> _BuiltKnown: ...

class _BuiltKnown(_BuiltResult):
    reason: str
    mass: float
    fittings_mass: float
    pin_to_pin: float
    overall_length: float
    sleeve_length: float
    strap_length: float
    film_pieces: int
    film_area: float
    film_used: float
    cut_length: float
    silicone_volume: float
    silicone_mass: float
    silicone_parts: _Mapping[str, float]
    printed_volume: float
    screw: str
    preload: float
    torque: float
    yoke_moment: float
    mass_parts: _Sequence[_Mapping[str, Any]]
    mass_missing: _Sequence[str]

class _ComparisonResult(_Comparison):
    def require(self) -> _ComparisonKnown: ...

class _ComparisonKnown(_ComparisonResult):
    calibration: str

class _DesignResultResult(_DesignResult):
    def require(self) -> _DesignResultKnown: ...

class _DesignResultKnown(_DesignResultResult):
    feasible: bool
    reason: str
    examined: int
    feasible_designs: int
    killed_by: str
    reachable: float
    excludes: _Sequence[str]
    chosen: _Mapping[str, Any]
    refined: _Mapping[str, Any]
    runner_up: _Mapping[str, Any]
    runner_up_lost: str
    binding: _Sequence[str]
    forbidden: _Sequence[_Mapping[str, Any]]
    front_size: int
    front: _Sequence[_Mapping[str, Any]]
    sensitivities: _Mapping[str, _Mapping[str, Any]]
    confidence: float
    robustness: _Mapping[str, _Mapping[str, Any]]
    surest: int
    file: str
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _BrakeSummaryResult(_BrakeSummary):
    def require(self) -> _BrakeSummaryKnown: ...

class _BrakeSummaryKnown(_BrakeSummaryResult):
    drawn_mass: float
    stiffness_measured: float
    stiffness_mount: float
    film_strength: float
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

class _DesignSweepResult(_DesignSweep):
    def require(self) -> _DesignSweepKnown: ...

class _DesignSweepKnown(_DesignSweepResult):
    feasible: bool
    reason: str
    examined: int
    feasible_designs: int
    killed_by: str
    reachable: float
    excludes: _Sequence[str]
    chosen: _Mapping[str, Any]
    refined: _Mapping[str, Any]
    runner_up: _Mapping[str, Any]
    runner_up_lost: str
    binding: _Sequence[str]
    forbidden: _Sequence[_Mapping[str, Any]]
    front_size: int
    front: _Sequence[_Mapping[str, Any]]
    sensitivities: _Mapping[str, _Mapping[str, Any]]
    confidence: float
    robustness: _Mapping[str, _Mapping[str, Any]]
    surest: int
    file: str
    intervals: _Mapping[str, _Mapping[str, Any]]
    basis: str

__all__ = ["design_brake", "example_campaign", "write_campaign", "write_report"]

def bench_clear(
    address: str,
) -> _BenchClearedResult:
    """Clear the latched fault, error queue and registers of a bench; no output is switched on.

    The bench is in SAFE afterwards. Find the cause first: `bench check` tests the wiring. Raises
    FileError, LineError and QuantityError for a bench that cannot be reached.
    """

def bench_flash(
    port: str,
    *,
    board: str = ...,
    image: str | _Path | None = ...,
    settings: str | _Path | None = ...,
) -> _BoardFlashedResult:
    """Write firmware and wiring to a board.

    An image is written through the board's boot loader. Without one, a board with plain MicroPython
    receives the firmware files. Raises FileError, ImageError, LineError, QuantityError and
    UnknownNameError.
    """

def bench_serve(
    address: str,
    *,
    port: int | str | _HasUnit = ...,
    host: str = ...,
    token_file: str | _Path | None = ...,
    pty: str | _Path | None = ...,
) -> _BenchServed:
    """Share one bench among many clients, over TCP and as a serial port.

    The first line printed is JSON: `listening`, `pid`, `address`. The gateway runs until SIGTERM or
    Ctrl-C, then switches the outputs off. Raises FileError if the port cannot be opened.
    """

def bench_status(
    address: str,
) -> _BenchStateResult:
    """Print the state of a bench.

    Only queries are sent. Only one client can use the board's serial line; if a gateway is running,
    use its `tcp:` address. Raises FileError, LineError and QuantityError if the bench cannot be
    reached.
    """

def bench_wiring(
    board: str | _Path,
    *,
    out: str | _Path | None = ...,
) -> _BoardWiringResult:
    """List a board's wires and parts, calculate its worst cases, and draw the circuit.

    Raises FileError for a file that does not describe a board, or that exists; UnknownNameError for
    an unknown board.
    """

def bench_check(
    address: str,
    *,
    line: str | _Path | _LineFile | _Line | None = ...,
    vent_rest: Literal["open", "closed"] | None = ...,
    tune: str | _Path | None = ...,
    sensor_range: float | str | _HasUnit | None = ...,
    overwrite: bool = ...,
) -> _BenchCheckedResult:
    """Check the wiring of a bench, and measure pump, leak, vent and the sensor's lag.

    Pump and vent are driven for ten seconds; the brake must carry no load. The controller of `bench
    run` is tuned for the values of `line`. `tune` is a file for this line with the measured values.
    Raises QuantityError if the valve's rest position is unknown or a value for `tune` is missing,
    LockedError if another client has the lock, InstrumentError for a bench that is not in SAFE.
    """

def bench_zero(
    address: str,
    *,
    vent_rest: Literal["open", "closed"] | None = ...,
) -> _BenchZeroed:
    """Measure the sensor's zero with the brake vented, and store it on the board.

    The vent is open for 4.5 s; the mean of the last second is the zero. The board stores it, with
    the date in the calibration's name. Raises QuantityError if the reading is not steady or is far
    from zero, LockedError if another client has the lock, InstrumentError for a bench that is not
    in SAFE.
    """

def bench_faults(
    address: str = ...,
    *,
    only: _Sequence[str] = ...,
    runs: int | str | _HasUnit = ...,
    seed: int | str | _HasUnit = ...,
    mismatch: bool = ...,
    progress: _Callable[[str, float], None] = ...,
) -> _FaultCampaign:
    """Inject every fault into a virtual board many times and measure the time until it is safe.

    For each run, the seed determines a line similar to that of the address, a controller, a target
    and the time of the fault. With `mismatch`, pump, vent, zero, lag and noise of the line differ
    from the model. Leak and vent are then orifices, the pump flow ripples and the supply dips. Each
    round of faults includes ten runs without a fault. The firmware is the board's own; its clock
    advances as fast as samples are computed. Raises UnknownNameError for an unknown fault,
    QuantityError for an address that is not a virtual board.
    """

def bench_soak(
    *,
    line: str = ...,
    hours: float | str | _HasUnit = ...,
    kind: Literal["bang-bang", "pi", "scheduled"] = ...,
    seed: int | str | _HasUnit = ...,
    progress: _Callable[[str, float], None] = ...,
) -> _SoakResult:
    """Run a virtual board for hours of board time and report any unexpected event.

    Targets, releases and holds are drawn from the seed. A simulated day takes minutes. Raises
    QuantityError for an address that is not a virtual board.
    """

def bench_export(
    run: str | _Path,
    *,
    out: str | _Path,
    start: float | str | _HasUnit | None = ...,
    end: float | str | _HasUnit | None = ...,
    overwrite: bool = ...,
) -> _RunExportedResult:
    """Export a run for other programs: CSV with its sidecar, Parquet, or NetCDF.

    Friction, calibrate, leak, pump-down and regulate read the CSV directly. Each drop in the run
    becomes a separate file in the same folder, FILE-shot1.csv, which `crash` reads; NetCDF contains
    the drops. A run that was not closed has the outcome `interrupted`; its file is read in place,
    together with its `-wal` file.
    """

def bench_log(
    address: str,
    *,
    out: str | _Path,
    duration: float | str | _HasUnit | None = ...,
    resume: bool = ...,
    overwrite: bool = ...,
) -> _RunLoggedResult:
    """Record every sample of a bench that another client controls.

    A sample is acknowledged to the board only after it is on disk. No acknowledged sample is lost
    if the process is killed; `resume` fetches up to ten seconds of samples from the board. Ctrl-C
    or SIGTERM ends the recording. Raises FileError for the file, LineError for the bench.
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
) -> _RunRecordedResult:
    """Run a procedure on a bench and record every sample.

    The controller is tuned to the line at the highest vacuum of the procedure, and sent to the
    board. With `shot`, the accelerometer of a falling mass is armed from the first hold onwards,
    and the file keeps every drop. In every case the outputs are left safe and the file is closed;
    Ctrl-C ends the run with OPERATOR_STOPPED. Raises QuantityError for a procedure that the bench
    cannot run, InstrumentError if it rejects a command, FileError for the file. Nothing moves if a
    check of the controller fails; the file stores the failed checks that `accept` accepts.
    """

def follow(
    line: str | _Path | _LineFile | _Line,
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    profile: str | _Path,
    swing: _Swing = ...,
    settings: _ScheduledSettings = ...,
    slip_noise: float | str | _HasUnit = ...,
    model_error: float | str | _HasUnit = ...,
    seed: int | str | _HasUnit = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    interval: Literal["next", "mean"] = ...,
) -> _FollowedForceResult:
    """Make a sliding brake's force follow a profile, and report where this is impossible.

    The profile varies between the forces `low` and `high` with a `period` while the brake slips at
    `speed`, or it is a file with time, force and slip. The controller assumes the brake of the
    file. The next brake differs from it, so the intervals of the errors may lie above their values.
    """

def plan(
    line: str | _Path | _LineFile | _Line,
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    mass: float | str | _HasUnit,
    speed: float | str | _HasUnit,
    warning: float | str | _HasUnit,
    travel: float | str | _HasUnit,
    mass_sd: float | str | _HasUnit = ...,
    speed_sd: float | str | _HasUnit = ...,
    standing: float | str | _HasUnit = ...,
    stored: float | str | _HasUnit | None = ...,
    rope_stiffness: float | str | _HasUnit | None = ...,
    horizontal: bool = ...,
    fluid: Literal["air", "water"] = ...,
    vacuum_share: float | str | _HasUnit | None = ...,
    leak_time: float | str | _HasUnit | None = ...,
    samples: int | str | _HasUnit = ...,
    seed: int | str | _HasUnit = ...,
    confidence: float | str | _HasUnit = ...,
    interval: Literal["next", "mean"] = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _CollisionPlanResult:
    """Predict whether the vacuum is reached before a collision, and the changes needed if not.

    The estimated mass and speed are means. Friction and mounting of the brake scatter too: at
    `safe_vacuum`, the share `confidence` of stops stays within the travel. By default `stored` is
    the pressure at which pump and leak balance. The fraction `vacuum_share` of the gauge's reading
    presses the sheets. `leak_time` is a laminar leak of the chamber, also during the stop.
    """

def regulate(
    line: str | _Path | _LineFile | _Line,
    *,
    target: float | str | _HasUnit,
    settings: _RegulatorSettings = ...,
    duration: float | str | _HasUnit | None = ...,
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
    fault_at: float | str | _HasUnit | None = ...,
    seed: int | str | _HasUnit = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _RegulationResult:
    """Simulate the closed-loop control of a line to a vacuum, with a noisy sensor.

    With a recorded `step`, gains, detectors and the simulated line are identified from the log
    (`identified`), and its scatter is used as the noise unless that is given. `detection` is the
    longest detection time [s] of each fault at this vacuum (None: never detected). `fault` is
    injected into the line or the sensor at `fault_at`; `said_after` is None if it was not reported,
    or if it was reported before that time.
    """

def bend(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    vacuum: float | str | _HasUnit,
    angle: float | str | _HasUnit,
    slip: float | str | _HasUnit = ...,
    radius: float | str | _HasUnit | None = ...,
    limb_friction: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
) -> _BendResult:
    """Bend a brake between its caps, and compute its stiffness, free and jammed.

    The caps rotate by `angle` relative to each other and may move closer. With the `radius` of a
    joint, also compute the friction of the sheets where the pull presses them together, with the
    outer face of the enclosure at its tension for that slip. `limb_friction` determines how much
    the forces at the two caps differ when the brake slides on the limb.
    """

def drop(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    mass: float | str | _HasUnit,
    speed: float | str | _HasUnit | None = ...,
    height: float | str | _HasUnit | None = ...,
    vacuum: Literal["tuned"] | float | str | _HasUnit | None = ...,
    travel: float | str | _HasUnit | None = ...,
    rope_stiffness: float | str | _HasUnit | None = ...,
    rope_damping: float | str | _HasUnit | None = ...,
    vacuum_history: str | _Path | _History | None = ...,
    log: _LogOptions = ...,
    vacuum_share: float | str | _HasUnit | None = ...,
    leak_time: float | str | _HasUnit | None = ...,
    held: float | str | _HasUnit | None = ...,
    duration: float | str | _HasUnit | None = ...,
    sensing: _Sensing = ...,
    warmth: _Warmth = ...,
    no_brake: bool = ...,
    horizontal: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
    interval: Literal["next", "mean"] = ...,
    has_intervals: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _StopResult:
    """Stop a falling mass with the brake, at a vacuum or at "tuned" for a travel (slip).

    Without `rope_stiffness` only the brake holds the mass, even if its file has a [rope]; with
    `no_brake` only the rope. Slip, peak and time refer to the first standstill or the end of
    travel. The result is exact at constant vacuum. With `rope_damping`, a `vacuum_history` or a
    `duration` that includes the rebound it is integrated in time. `reading` is the pressure
    reference of a file (absolute, gauge or vacuum) if its column does not state it. The fraction
    `vacuum_share` of the gauge's reading presses the sheets. With `leak_time` the line is shut off
    `held` before the rope is taut, and the vacuum leaks away. A mass that still moves after
    `duration` has the outcome FINISHED and no `stopping_time`, nor has one that creeps on a rope.
    """

@overload
def force(  # type: ignore[overload-overlap]
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str,
    vacuum: float | str,
    sliding_speed: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
    interval: Literal["next", "mean"] = ...,
) -> _BrakeForceResult: ...
@overload
def force(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str | _ArrayLike | _HasUnit,
    vacuum: float | str | _ArrayLike | _HasUnit,
    sliding_speed: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
    interval: Literal["next", "mean"] = ...,
) -> _BrakeForceArray:
    """Compute the force of the sliding brake at a slip and a vacuum.

    Arrays of slip and vacuum broadcast. Without a `sliding_speed` it is the force at the speed at
    which friction was measured. Raises QuantityError for a slip beyond the overlap or a vacuum
    above atmospheric pressure.
    """

@overload
def vacuum(  # type: ignore[overload-overlap]
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str,
    force: float | str,
    sliding_speed: float | str | _HasUnit | None = ...,
    confidence: float | str | _HasUnit = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
    interval: Literal["next", "mean"] = ...,
) -> _VacuumForForceResult: ...
@overload
def vacuum(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str | _ArrayLike | _HasUnit,
    force: float | str | _ArrayLike | _HasUnit,
    sliding_speed: float | str | _HasUnit | None = ...,
    confidence: float | str | _HasUnit = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
    interval: Literal["next", "mean"] = ...,
) -> _VacuumForForceArray:
    """Find the vacuum at which the sliding brake resists with a force at a slip.

    `vacuum` does so on average, `safe_vacuum` in the share `confidence` of tests. `feasible` is
    False, with a `reason`, for a force below the enclosure's own or above that at the site's full
    vacuum. Arrays of slip and force broadcast; the vacuum is NaN for elements without one. Without
    a `sliding_speed` the force is that at the speed at which friction was measured.
    """

def new(
    name: str,
    start: str | _Path,
    out: str | _Path,
    *,
    overwrite: bool = ...,
) -> _NewBrake:
    """Write a commented brake file to edit, starting from an existing brake.

    Raises FileError if `out` exists and `overwrite` is not set, or if the name is not allowed.
    """

def parts(
    name: str | None = ...,
) -> _PartList:
    """List pumps, valves and sensors in the catalogue, with their numbers in SI and their sources.

    Raises UnknownNameError.
    """

class Sensing(_Sensing):
    """Measuring chain of a stop: accelerometer, low-pass, sampling rate, and filter."""

    def __init__(
        self,
        *,
        accelerometer: str | _Accelerometer = ...,
        filter_class: str | None = ...,
        low_pass: float | str | _HasUnit | None = ...,
        sampling: float | str | _HasUnit | None = ...,
    ) -> None: ...

class Warmth(_Warmth):
    """Limits for the temperature rise of the sheets."""

    def __init__(
        self,
        *,
        allowed_rise: float | str | None = ...,
        film_coefficient: float | str | _HasUnit | None = ...,
    ) -> None: ...

def stick_slip(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    vacuum: float | str | _HasUnit,
    speed: float | str | _HasUnit,
    mass: float | str | _HasUnit | None = ...,
    mount_stiffness: float | str | _HasUnit | None = ...,
    damping: float | str | _HasUnit = ...,
    stribeck_speed: float | str | _HasUnit = ...,
    static: float | str | _HasUnit | None = ...,
    slip: float | str | _HasUnit = ...,
    elongation: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
) -> _StickSlipResult:
    """Simulate a pull at one speed to see whether the brake shows stick–slip, and its remedies.

    The pull starts from rest at `slip`. Amplitude and forces are those of the last slip of the run.
    `critical_speed`, `stable_speed` and `stiffness_needed` assume the friction at `slip`.
    `stribeck_speed` 0 means that static friction vanishes immediately. Raises FitError if the run
    would take too many steps.
    """

def tensile(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    vacuum: float | str | _HasUnit | None = ...,
    speed: float | str | _HasUnit | None = ...,
    elongation: float | str | _HasUnit | None = ...,
    procedure: str | _Procedure | None = ...,
    model: Literal["lumped", "stack"] = ...,
    static: bool = ...,
    one_by_one: bool = ...,
    interfaces: _Interfaces | None = ...,
    housing: _Housing | None = ...,
    scatter: float | str | _HasUnit | None = ...,
    samples: int | str | _HasUnit | None = ...,
    seed: int | str | _HasUnit | None = ...,
    vacuum_share: float | str | _HasUnit | None = ...,
    leak_time: float | str | _HasUnit | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
    interval: Literal["next", "mean"] = ...,
) -> _TensileResult:
    """Pull a brake in a simulated test machine.

    Give either vacuum, speed and elongation (of the crosshead), or a procedure. The
    following options are for the "stack" model. `static` uses static friction before an interface
    slides. With `one_by_one`, overloaded interfaces slip one at a time, the most overloaded first.
    `interfaces` may differ, and a `housing` may rub. `scatter` is the relative SD of the
    interfaces' friction: `samples` (1000) stacks, drawn from `seed` (1), then yield the mean and SD
    of peak, stiffness and onset; if interrupted, those of the stacks done so far. The fraction
    `vacuum_share` of the gauge's reading presses the sheets. With `leak_time` the line is shut off
    after every evacuation and the vacuum leaks away from then on, except in the "stack" model,
    which keeps its initial vacuum. Intervals are those of the brake's uncertain numbers, without
    the `scatter` of single interfaces. Raises ProcedureError or QuantityError for contradictions.
    """

def tune(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    mass: float | str | _HasUnit,
    travel: float | str | _HasUnit,
    speed: float | str | _HasUnit | None = ...,
    height: float | str | _HasUnit | None = ...,
    rope_stiffness: float | str | _HasUnit | None = ...,
    horizontal: bool = ...,
    confidence: float | str | _HasUnit = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
    interval: Literal["next", "mean"] = ...,
    searches: _Sequence[str] = ...,
) -> _TunedVacuumResult:
    """Find the vacuum that stops a mass within a travel (slip of the brake), exactly and by eq. 10.

    The mass arrives with `speed` or falls from `height`. At `vacuum` the average brake uses exactly
    the travel, so half of the stops exceed it; at `safe_vacuum` the share `confidence` of stops
    stays within it, because friction and mounting scatter. If there is no such vacuum, `reason`
    explains why and lists alternatives: the speeds that can be stopped, or a different travel,
    number of sheets or number of parallel brakes, each as the only change. Each alternative has
    been checked by tuning it. `searches` lists the other searches: "safety" for the safe vacuum and
    the intervals, "speeds" for those that can be stopped, "alternatives" for the changes.
    """

def rise(
    line: str | _Path | _LineFile | _Line,
    *,
    target: float | str | _HasUnit,
    fluid: Literal["air", "water"] = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _VacuumRiseResult:
    """Compute the time in which a line reaches a vacuum, and the time in which it releases it.

    The pump runs at full power until the target is reached. If it is never reached, `rise_time` is
    None, `feasible` False and `reason` states the vacuum that can be reached. In air the line is
    integrated; `closed_form` holds for a rigid volume without an effect of tube or orifice.
    `fall_time` and `closed_form_fall` count from the opening of the vent valve or the reversal of a
    pump (`fall_by`); None if the line has neither. `tube_delay` and `tube_lag` are None in water
    and for a line that has no tube. A tube with many cells takes a long time to compute.
    """

def demo(
    *,
    out: str | _Path = ...,
    typed: str = ...,
) -> _DemoResult:
    """Show everything in about a minute: test, calibrate, predict, build, run a bench, publish.

    Rebuilds the folder `out`, prints one line with its time for each step, and writes a page that
    compares the paper's claims with layerjam. Each command with its output is in `demo.log` next to
    the page. Raises FileError, and writes nothing, if the folder is not the demo's own, and
    LayerjamError if a step fails.
    """

def schema(
    name: str | None = ...,
) -> _Schemas:
    """Return the JSON Schema of the --json output of a command.

    Draft 2020-12; each key has type, meaning and SI `unit`. The output is itself a schema: `anyOf`
    refers to the definitions of `$defs`, one for each command.
    """

def export_c(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    precision: Literal["double", "single"] = ...,
    rope_stiffness: float | str | _HasUnit | None = ...,
    strict: bool = ...,
    overwrite: bool = ...,
) -> _ExportedResult:
    """Write the brake as C source for a microcontroller or a simulator.

    The C99 code allocates nothing, has no global data and needs only `sqrt` (and `pow` with a
    pressure exponent). A rope is in series with the brake's stiffness. At rest the exported law
    resists up to c L2, without additional static friction. Raises FileError if a file exists unless
    `overwrite`, QuantityError for sheets that fan out, a speed law or a hyperelastic enclosure.
    """

def export_fmu(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    fmi: Literal["3", "2"] = ...,
    platforms: str | None = ...,
    sources_only: bool = ...,
    rope_stiffness: float | str | _HasUnit | None = ...,
    strict: bool = ...,
    overwrite: bool = ...,
) -> _ExportedFmuResult:
    """Write the brake as a functional mock-up unit for Simulink, Dymola, OpenModelica and others.

    FMI 3.0 or 2.0, co-simulation and model exchange, compiled C, so the target needs no Python.
    Inputs are elongation, velocity and vacuum, outputs force, slip and energies; parameters carry
    the brake file's own names, units and bounds. Raises FileError if the file exists unless
    `overwrite`, QuantityError for sheets that fan out, a speed law or a hyperelastic enclosure, or
    an unknown platform; CompilerError if no compiler is found.
    """

def export_html(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    rope_stiffness: float | str | _HasUnit | None = ...,
    strict: bool = ...,
    overwrite: bool = ...,
) -> _ExportedHtmlResult:
    """Write the brake as one page that computes in a browser, without Python or a network.

    The page has the brake to scale, its numbers with sources, and its accepted checks. The reader
    moves vacuum, slip, elongation, mass, speed and travel, and sees the force, the hysteresis of a
    pull, and the safe vacuum for a stop. For a brake with a law that the C kernel lacks, it states
    that law and does not compute. Raises FileError if the file exists unless `overwrite`,
    MissingExtraError if the extra `report` is not installed.
    """

def export_mujoco(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    tendon: str = ...,
    vacuum_lag: float | str | _HasUnit | None = ...,
    coupling: Literal["limited", "explicit", "implicit"] = ...,
    no_build: bool = ...,
    rope_stiffness: float | str | _HasUnit | None = ...,
    strict: bool = ...,
    overwrite: bool = ...,
) -> _ExportedMujocoResult:
    """Write the brake as an actuator plugin of MuJoCo whose control is the vacuum.

    `actuator.xml` is for `<include>` in a model that has the tendon, `brake.xml` is a model for
    viewing. The library is compiled for the installed MuJoCo. Raises FileError if a file exists
    unless `overwrite`, CompilerError, MissingExtraError, QuantityError for sheets that fan out, a
    speed law or a hyperelastic enclosure.
    """

def ageing(
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    test: _FrictionTest = ...,
    hold: float | str | _HasUnit | None = ...,
    brake: str | _Path | _BrakeFile | _Brake | None = ...,
    out: str | _Path | None = ...,
    partial: bool = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
    overwrite: bool = ...,
) -> _AgeingResult:
    """Fit the growth of static friction while the films rest under load, from pulls after holds.

    Each file is a friction test whose sidecar states its `hold`; static friction is evaluated as in
    `friction`. With `brake` and `out`, static friction at `hold` (the geometric mean of all holds
    unless given) and its growth are written into a copy of the brake's file.
    """

def calibrate(
    brake: str | _Path | _BrakeFile | _Brake,
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    depth: Literal["exact", "curves", "bayesian"] = ...,
    free: _Sequence[str] = ...,
    vacuum: float | str | _HasUnit | None = ...,
    out: str | _Path | None = ...,
    partial: bool = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    left_out: _LeftOut = ...,
    within: float | str | _HasUnit | None = ...,
    tare: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    sampling: _Sampling = ...,
    progress: _Callable[[str, float], None] | None = ...,
    overwrite: bool = ...,
) -> _BrakeCalibrationResult:
    """Calibrate the scale factor and stiffness of a brake from one or more pulls.

    `files` are one or more paths or traces. `depth` "exact" uses the peak and slope of each pull;
    "curves" fits all whole curves at once, including the enclosure's factor and any quantities in
    `free`: "pressure_exponent", "speed", "force_offset"; "bayesian" samples the same parameters
    (`draws` of each of `chains`, from `seed`). `vacuum` applies to files whose sidecar does not
    state it. With `out` the calibrated brake is written. `exclude` leaves out files or specimens,
    each with its reason in `because` (in Python also {file: reason}). Both are stored in the result
    and in the brake. `within` requests how many more pulls, at which conditions, would narrow each
    interval to ± this fraction of its value. `tare` subtracts the force before the rise. If a check
    fails, nothing is written; `accept` accepts failed checks by name, {check: reason}.
    """

def crash(
    file: str | _Path,
    *,
    filter_class: str = ...,
    sampling: float | str | _HasUnit | None = ...,
    before: float | str | _HasUnit | None = ...,
    sensor_range: float | str | None = ...,
    falling: bool = ...,
    hic: float | str | _HasUnit | None = ...,
    shot: int | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _TableOptions = ...,
) -> _CrashFoundResult:
    """Compute peak, filtered peak, velocity change and duration of an impact from a log.

    The largest pulse of the log is used. `filter_class` is none, cfc60, cfc180, cfc600 or cfc1000;
    `before` is the duration of the quiet part at the start of the log. `falling` states that the
    sensor was in free fall before the impact; gravity is then subtracted from the velocity change.
    `hic` is the longest window of the head injury criterion. A run recorded by `bench run --shot`
    is accepted too; it already states rate and range.
    """

def enclosure(
    files: _Sequence[str | _Path] | str | _Path,
    *,
    area: float | str | _HasUnit | None = ...,
    gauge_length: float | str | _HasUnit | None = ...,
    start: float | str | _HasUnit = ...,
    end: float | str | _HasUnit = ...,
    fit_to: float | str | _HasUnit | None = ...,
    material: str | None = ...,
    brake: str | _Path | _BrakeFile | _Brake | None = ...,
    out: str | _Path | None = ...,
    tare: bool = ...,
    hyperelastic: bool = ...,
    partial: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _SpecimenOptions = ...,
    overwrite: bool = ...,
) -> _SiliconeFitResult:
    """Fit the modulus and a hyperelastic model of the enclosure's silicone to ASTM D412 curves.

    `start` and `end` bound the strain of the initial slope. `tare` subtracts the stress without
    strain. Specimens of one material are pooled. `material` names the silicone to compare with.
    `brake` and `out` write the mean 100 % modulus into a copy; `hyperelastic`, also the model.
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
) -> _FrictionResult:
    """Determine friction from friction tests, as in the paper, ASTM D1894 or ISO 8295.

    `files` are one or more paths or traces. `normal_force` may come from the files' sidecars, or
    from the 200 g of the two standards; `start` and `end` bound the displacement of the kinetic
    mean, counted from the record's first sample; `area` is the contact area of the sled, which sets
    the pressure. If a record shows stick–slip, `kinetic` is None; `accept_stick_slip` uses the
    midpoint of the stick–slip. With `tare` the force before the load rise is subtracted. With
    `brake` and `out` the result is written into a copy of the brake's file. If a check fails,
    nothing is written; `accept` accepts failed checks by name, {check: reason}.
    """

def lab(
    spec: str | _Path | _Spec | None = ...,
    *,
    out: str | _Path | None = ...,
    example: bool = ...,
    seed: int | str | _HasUnit | None = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _PracticeFilesResult:
    """Write practice files of a virtual laboratory, with known true values and machine faults.

    The files of a campaign and the true values are written into the folder `out`. `spec` is the
    path of a TOML file, a Spec, or "practice", which is built in; `seed` replaces the seed in it.
    Every file states that it is synthetic. Raises FileError if `out` is not empty and `overwrite`
    is not set.
    """

def write_campaign(
    spec: str | _Path | _Spec | None = ...,
    *,
    out: str | _Path | None = ...,
    example: bool = ...,
    seed: int | str | _HasUnit | None = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _PracticeFilesResult:
    """Write practice files of a virtual laboratory, with known true values and machine faults.

    The files of a campaign and the true values are written into the folder `out`. `spec` is the
    path of a TOML file, a Spec, or "practice", which is built in; `seed` replaces the seed in it.
    Every file states that it is synthetic. Raises FileError if `out` is not empty and `overwrite`
    is not set.
    """

def leak(
    file: str | _Path,
    *,
    volume: float | str | _HasUnit | None = ...,
    temperature: float | str | None | None = ...,
    zero: float | str | _HasUnit | None = ...,
    start: float | str | _HasUnit | None = ...,
    end: float | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    options: _LogOptions = ...,
) -> _LeakFoundResult:
    """Fit the leak of a closed chamber to a pressure-hold log.

    `reading` is the pressure reference (absolute, gauge, vacuum) if the file does not state it.
    Without `volume`, only rates can be determined. A temperature column is used if present;
    otherwise the gas has the constant `temperature`.
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
    vacuum: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    left_out: _LeftOut = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    title: str | None = ...,
    licence: str | None = ...,
    author: _Sequence[str] = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _PublishedResult:
    """Write one campaign as a self-contained dataset, so that others can recompute its numbers.

    The raw files are copied unchanged, with their sidecars and all other files in the folder
    `campaign`. The dataset adds brake and line, report, results, recipe, checksums, and a
    description that repositories read (RO-Crate 1.1). A measurement that states a normal force is a
    friction test, any other a pull; a calibrated brake in the folder lists its calibration pulls;
    without one, `measurements` does, as in `report`. If a check fails, nothing is written; `accept`
    accepts failed checks by name, {check: reason}, and the dataset states them. Raises FileError if
    neither the folder nor `brake` states which brake was tested, or if `out` exists and is not a
    dataset to be replaced with `overwrite`.
    """

def recompute(
    dataset: str | _Path,
    *,
    fingerprint: str | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _RecomputedResult:
    """Recompute a published dataset from its raw files, and list everything that differs.

    Numbers, tables, page, PDF, figures, calibrated brake and description are recomputed. Numbers
    count as the same up to a relative difference of 1e-6. A file that does not match its checksum,
    has no checksum or is missing is always reported. If different versions of the programs wrote
    the dataset, text and drawings may differ; then only their numbers are compared,
    `not_compared` lists the rest, and `equal` is None. Inputs such as raw files, licence and
    authors cannot be recomputed; give the cited `fingerprint` to detect changes in them. Nothing is
    written. Raises FileError for a folder that is not a dataset.
    """

def pull(
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    tare: bool = ...,
    start: float | str | _HasUnit | None = ...,
    end: float | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _Pulls:
    """Analyse measured pulls: slack, preload, onset, stiffness, peak, stick–slip, unloading.

    `files` are one or more paths or traces. The force before the load rise is subtracted only with
    `tare`. `start` and `end` select a part of each record by its time. The spacing of stick–slip
    grows with its amplitude; identical spacing with different amplitudes in several files indicates
    a ripple of the machine.
    """

def pump_down(
    file: str | _Path,
    with_volume: str | _Path | None = ...,
    *,
    volume: float | str | _HasUnit | None = ...,
    flow: float | str | _HasUnit | None = ...,
    added_volume: float | str | _HasUnit | None = ...,
    compliance: Literal["fit"] | float | str | _HasUnit | None = ...,
    zero: float | str | _HasUnit | None = ...,
    start: float | str | _HasUnit | None = ...,
    end: float | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    options: _LogOptions = ...,
) -> _PumpFoundResult:
    """Fit the volume and the pump flow to pump-down logs, as far as the logs determine them.

    One log determines only the ratio of flow to volume. `volume`, `flow`, or the log `with_volume`
    of the same line with `added_volume` determine both. `compliance` is the volume lost per unit of
    vacuum, or "fit".
    """

def records_add(
    files: _Sequence[str | _Path] | str | _Path,
    *,
    db: str | None = ...,
    serial: str | None = ...,
) -> _RecordsAdded:
    """Add files to the records, linked to their sources.

    Links follow from digests inside the files. A file that is already in the records, or of an
    unsupported kind, is rejected; the others are added in one transaction. Raises RecordsError for
    the database; nothing is added then.
    """

def records_list(
    *,
    db: str | None = ...,
) -> _RecordsListed:
    """List every record, oldest first.

    Raises RecordsError for the database.
    """

def records_show(
    ident: str,
    *,
    db: str | None = ...,
) -> _RecordShown:
    """Show one record, its sources and the records derived from it.

    Raises RecordsError if no record or several records have that name.
    """

def records_verify(
    folders: _Sequence[str | _Path] = ...,
    *,
    db: str | None = ...,
) -> _RecordsVerified:
    """Check whether every file is unchanged.

    Withdrawn files are not checked. The exit code is 1 if a file has changed or is missing. Raises
    RecordsError for the database.
    """

def records_withdraw(
    ident: str,
    *,
    why: str,
    db: str | None = ...,
) -> _RecordWithdrawn:
    """Withdraw a record; it is kept, with the reason.

    A file that was withdrawn cannot be added again. Raises RecordsError if there is no such record,
    or if it has already been withdrawn.
    """

def report(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    measurements: _Measurements = ...,
    test: _FrictionTest = ...,
    depth: Literal["exact", "curves"] = ...,
    vacuum: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    left_out: _LeftOut = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    issued: _Issued = ...,
    overwrite: bool = ...,
    command: str = ...,
    date: str | None = ...,
    names: _Mapping[str, str] | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _ReportResult:
    """Report the measurements of one brake as HTML and PDF: friction, calibration, validation.

    Writes report.html, report.pdf, figures, numbers.csv and results.json into the folder `out`.
    `friction` are friction tests, `pulls` calibrate the brake, and the calibrated brake is compared
    with the pulls in `validate`; each may be omitted. Without `validate`, some of the pulls can be
    reserved for validation: `calibrate_on` names those for calibration, or `holdout` reserves a
    vacuum ("46.1 kPa"), a speed ("19 mm/s") or a repeat ("repeat 3"). Otherwise the brake is
    compared with its calibration pulls, and the page says so. `vacuum` applies to files without a
    sidecar; the options of friction tests, `depth` and `exclude` are as in `friction` and
    `calibrate`. `command` is printed as the command that created the page; `date` (ISO) is today by
    default. `names` {file name: name in the report} is for files stored under other names.
    `report_number` and `customer` appear on the pages; sidecars may state them instead. With
    `live`, report.html computes the calibrated brake, as the page of `export html` does. If a check
    fails, nothing is written; `accept` accepts failed checks by name, {check: reason}. Raises
    FileError if a report exists and `overwrite` is not set.
    """

def write_report(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    measurements: _Measurements = ...,
    test: _FrictionTest = ...,
    depth: Literal["exact", "curves"] = ...,
    vacuum: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    left_out: _LeftOut = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    issued: _Issued = ...,
    overwrite: bool = ...,
    command: str = ...,
    date: str | None = ...,
    names: _Mapping[str, str] | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _ReportResult:
    """Report the measurements of one brake as HTML and PDF: friction, calibration, validation.

    Writes report.html, report.pdf, figures, numbers.csv and results.json into the folder `out`.
    `friction` are friction tests, `pulls` calibrate the brake, and the calibrated brake is compared
    with the pulls in `validate`; each may be omitted. Without `validate`, some of the pulls can be
    reserved for validation: `calibrate_on` names those for calibration, or `holdout` reserves a
    vacuum ("46.1 kPa"), a speed ("19 mm/s") or a repeat ("repeat 3"). Otherwise the brake is
    compared with its calibration pulls, and the page says so. `vacuum` applies to files without a
    sidecar; the options of friction tests, `depth` and `exclude` are as in `friction` and
    `calibrate`. `command` is printed as the command that created the page; `date` (ISO) is today by
    default. `names` {file name: name in the report} is for files stored under other names.
    `report_number` and `customer` appear on the pages; sidecars may state them instead. With
    `live`, report.html computes the calibrated brake, as the page of `export html` does. If a check
    fails, nothing is written; `accept` accepts failed checks by name, {check: reason}. Raises
    FileError if a report exists and `overwrite` is not set.
    """

def validate(
    brake: str | _Path | _BrakeFile | _Brake,
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    vacuum: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    left_out: _LeftOut = ...,
    tare: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _ModelErrorsResult:
    """Compare the brake's model with measured pulls.

    `files` are one or more paths or traces. See identify.validation.metrics for the window.
    `uncalibrated` contains the same errors for the brake with a scale factor of 1 and the sheets'
    own stiffness. A warning names files that were also used for the calibration. `exclude` leaves
    out files, each with its reason in `because` (in Python also {file: reason}). `tare` subtracts
    the force before the rise.
    """

def reproduce(
    out: str | _Path,
    *,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _Reproduction:
    """Recompute the paper and compare every claim with our result.

    Writes report.html, results.json and the figures. Raises FileError if the report exists and
    `overwrite` is not set, or if the folder cannot be created.
    """

def scenario(
    scenario: str | _Path | None = ...,
    *,
    out: str | _Path | None = ...,
    names: bool = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _MachineResultResult:
    """Check a machine of the paper's Fig. 13 against its limits.

    Machines are a seat belt, neck guard, ankle clutch and rehabilitation orthosis; a scenario
    contains loads and limits. With `out`, a page with figures is written to that folder (`page`).
    `feasible` states whether all `limits` are met, `reason` names the decisive one, and
    `conclusion` summarises the requirements. `brakes_needed` is None if no number of brakes is
    enough. `results` has the machine's own keys, `units` the unit of each. Raises FileError for an
    invalid file, QuantityError for values out of bounds.
    """

def array(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    parallel: int | str | _HasUnit = ...,
    series: int | str | _HasUnit = ...,
    vacuum: float | str | _HasUnit | None = ...,
    until: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
    interval: Literal["next", "mean"] = ...,
) -> _ArrayPullResult:
    """Simulate one slow pull of identical brakes in parallel and in series.

    The default vacuum is the site's full vacuum. The pull ends at the elongation `until`, or at the
    end of the travel. `outcome` is FINISHED, BOTTOMED_OUT, or SNAPS if the force of a slipping
    brake falls faster than the brakes in series with it relax. `travel` and `energy` include only
    slip. Parallel brakes are assumed to share the force evenly. Intervals are those of brakes that
    all deviate alike; if each deviates on its own, the array scatters less.
    """

def build(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    out: str | _Path,
    workshop: str | _Path | None = ...,
    cutter: str | None = ...,
    kerf: float | str | _HasUnit | None = ...,
    stock: str | _Collection[float] | None = ...,
    laser_bed: str | _Collection[float] | None = ...,
    print_bed: str | _Collection[float] | None = ...,
    parallel: int | str | _HasUnit = ...,
    series: int | str | _HasUnit = ...,
    coupons: bool = ...,
    no_step: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] = ...,
) -> _BuiltResult:
    """Write everything a workshop needs to build a brake: patterns, parts, mould, instructions.

    The folder is written completely or not at all, and the same brake produces the same bytes.
    `feasible` is False if the brake cannot be drawn (exit code 1), or if a part is loaded beyond
    its strength or a seal leaks (exit code 4); `reason` names the checks, and nothing is written.
    `accept` accepts failed checks by their code, {code: reason}; the folder then states them. We
    have not cut, printed or cast any of it. Raises FileError, QuantityError, MissingExtraError.
    """

def catalogue() -> _Catalogue:
    """List the brakes, films, lines, designs, pumps, valves and sensors that have a name.

    Each has its source. `layerjam show` prints the source of each number of a brake, and
    `layerjam parts NAME` those of a part.
    """

def compare(
    *brakes: _Sequence[str | _Path | _BrakeFile | _Brake],
    vacuum: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    interval: Literal["next", "mean"] = ...,
) -> _ComparisonResult:
    """Compare the force per mass of brakes with that of published devices.

    Every row names its source. If no brakes are given, those of the catalogue are compared (paper,
    III-F). The first brake is also shown at lower vacuums, in parallel with identical brakes, and
    with more sheets. `devices` is a list of rows; `computed` is True for our brakes. `sheet`
    compares the effect of one more sheet with the paper's statement. `none_found` maps a class
    without a sourced device to the sources searched.
    """

def design(
    spec: str | _Path | _Mapping[str, Any] | _DesignSpecification,
    *,
    out: str | _Path | None = ...,
    number: int | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    overwrite: bool = ...,
    confidence: float | str | _HasUnit | None = ...,
    interval: Literal["next", "mean"] = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _DesignResultResult:
    """Find the best brake for a set of requirements.

    Friction and mounting scatter, and handbook values may be far off. `chosen` is the best design
    of which the share `confidence` of brakes meets all constraints. If no design reaches it, a
    check warns, and `chosen` is the best one for the average brake; `robustness` has the
    probabilities and `surest` the number of the design with the highest one. With None instead of a
    confidence, the average brake alone decides.

    Also returns the front, the runner-up and why it lost, and the constraints that exclude better
    designs. If no design meets the constraints, `feasible` is False, with `reason`, `killed_by` and
    `reachable`; contradictions between bounds are found before the sweep. `chosen` is the best
    design on the grid, `refined` the best one between its steps. `out` receives the chosen design,
    or the one with a `number`, as a brake file that `build` accepts.
    """

def design_brake(
    spec: str | _Path | _Mapping[str, Any] | _DesignSpecification,
    *,
    out: str | _Path | None = ...,
    number: int | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    overwrite: bool = ...,
    confidence: float | str | _HasUnit | None = ...,
    interval: Literal["next", "mean"] = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _DesignResultResult:
    """Find the best brake for a set of requirements.

    Friction and mounting scatter, and handbook values may be far off. `chosen` is the best design
    of which the share `confidence` of brakes meets all constraints. If no design reaches it, a
    check warns, and `chosen` is the best one for the average brake; `robustness` has the
    probabilities and `surest` the number of the design with the highest one. With None instead of a
    confidence, the average brake alone decides.

    Also returns the front, the runner-up and why it lost, and the constraints that exclude better
    designs. If no design meets the constraints, `feasible` is False, with `reason`, `killed_by` and
    `reachable`; contradictions between bounds are found before the sweep. `chosen` is the best
    design on the grid, `refined` the best one between its steps. `out` receives the chosen design,
    or the one with a `number`, as a brake file that `build` accepts.
    """

def design_new(
    name: str,
    start: Literal["wrist", "stop"] = ...,
    *,
    out: str | _Path | None = ...,
    overwrite: bool = ...,
) -> _NewSpecification:
    """Write a commented specification to edit, starting from an example.

    Raises FileError if the file exists and `overwrite` is not set, and QuantityError for a name
    that is not allowed.
    """

def show(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    atmosphere: float | str | _HasUnit | None = ...,
    film: str | None = ...,
    interval: Literal["next", "mean"] = ...,
) -> _BrakeSummaryResult:
    """Show mass, forces, energy and strength of a brake, and the source of each number."""

def sweep(
    spec: str | _Path | _Mapping[str, Any] | _DesignSpecification,
    *,
    out: str | _Path,
    scheduler: str | None = ...,
    block: int | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    confidence: float | str | _HasUnit | None = ...,
    interval: Literal["next", "mean"] = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _DesignSweepResult:
    """Compute every design of a specification, in blocks on disk.

    The folder is new, empty or that of the same sweep. Such a sweep is resumed: `blocks_found` is
    the number of blocks that already exist. `block` is the number of designs in a block,
    `scheduler` the address of a Dask cluster. If interrupted, `complete` is False and the same call
    resumes. Raises FileError for a folder with other content, MissingExtraError if pyarrow or Dask
    is missing, and ClusterError.
    """
