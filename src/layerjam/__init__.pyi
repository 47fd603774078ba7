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
from layerjam.campaigns.campaign import Campaign as Campaign
from layerjam.campaigns.spec import Spec as _Spec
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
from layerjam.commands.bench_run import DropRigOptions as _DropRigOptions
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
from layerjam.commands.edit import edit as edit
from layerjam.commands.edit import edit_line as edit_line
from layerjam.commands.enclosure import SiliconeFit as _SiliconeFit
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
from layerjam.commands.stick_slip import StickSlip as _StickSlip
from layerjam.commands.sweep import DesignSweep as _DesignSweep
from layerjam.commands.tensile import Tensile as _Tensile
from layerjam.commands.tuning import TunedVacuum as _TunedVacuum
from layerjam.commands.vacuum_line import VacuumRise as _VacuumRise
from layerjam.commands.validation import ModelErrors as _ModelErrors
from layerjam.conversion import HasUnit as _HasUnit
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
from layerjam.laws import WetFilm as WetFilm
from layerjam.laws import aged_holding_force as aged_holding_force
from layerjam.laws import aged_static as aged_static
from layerjam.laws import amplification as amplification
from layerjam.laws import bending_stiffness_free as bending_stiffness_free
from layerjam.laws import bending_stiffness_jammed as bending_stiffness_jammed
from layerjam.laws import brake_cycle as brake_cycle
from layerjam.laws import brake_force as brake_force
from layerjam.laws import buckling_force as buckling_force
from layerjam.laws import buckling_moment as buckling_moment
from layerjam.laws import cantilever_deflection as cantilever_deflection
from layerjam.laws import cantilever_force as cantilever_force
from layerjam.laws import capstan_ratio as capstan_ratio
from layerjam.laws import clamp_stress as clamp_stress
from layerjam.laws import critical_speed as critical_speed
from layerjam.laws import enclosure_bending_stiffness as enclosure_bending_stiffness
from layerjam.laws import enclosure_cycle as enclosure_cycle
from layerjam.laws import enclosure_force as enclosure_force
from layerjam.laws import enclosure_mass as enclosure_mass
from layerjam.laws import enclosure_stretch as enclosure_stretch
from layerjam.laws import energy_capacity as energy_capacity
from layerjam.laws import force_at_elongation as force_at_elongation
from layerjam.laws import force_limits as force_limits
from layerjam.laws import holding_force as holding_force
from layerjam.laws import joint_friction as joint_friction
from layerjam.laws import joint_sheet_force as joint_sheet_force
from layerjam.laws import least_stiffness as least_stiffness
from layerjam.laws import local_rise as local_rise
from layerjam.laws import mass as mass
from layerjam.laws import mount_stiffness as mount_stiffness
from layerjam.laws import peak as peak
from layerjam.laws import peak_vacuum as peak_vacuum
from layerjam.laws import pull_work as pull_work
from layerjam.laws import saturation_slip as saturation_slip
from layerjam.laws import scale_factor_of_peak as scale_factor_of_peak
from layerjam.laws import self_closing_vacuum as self_closing_vacuum
from layerjam.laws import shear_at_first_slip as shear_at_first_slip
from layerjam.laws import shear_at_full_slip as shear_at_full_slip
from layerjam.laws import sheet_friction as sheet_friction
from layerjam.laws import sheet_mass as sheet_mass
from layerjam.laws import sheet_stress as sheet_stress
from layerjam.laws import sliding_force as sliding_force
from layerjam.laws import slip_at_elongation as slip_at_elongation
from layerjam.laws import slip_heat as slip_heat
from layerjam.laws import slip_moment as slip_moment
from layerjam.laws import slip_work as slip_work
from layerjam.laws import slow_saw as slow_saw
from layerjam.laws import speed_at_slip as speed_at_slip
from layerjam.laws import stable_speed as stable_speed
from layerjam.laws import stiffness_before_slip as stiffness_before_slip
from layerjam.laws import stiffness_sliding as stiffness_sliding
from layerjam.laws import stiffness_without_stick_slip as stiffness_without_stick_slip
from layerjam.laws import stop as stop
from layerjam.laws import stop_in_time as stop_in_time
from layerjam.laws import stops_per_minute as stops_per_minute
from layerjam.laws import stribeck_friction as stribeck_friction
from layerjam.laws import temperature_rise as temperature_rise
from layerjam.laws import temperature_rise_of_sheets as temperature_rise_of_sheets
from layerjam.laws import time_at_slip as time_at_slip
from layerjam.laws import travel_left as travel_left
from layerjam.laws import tuned_vacuum as tuned_vacuum
from layerjam.laws import turning_moment as turning_moment
from layerjam.laws import turning_stiffness_free as turning_stiffness_free
from layerjam.laws import turning_stiffness_jammed as turning_stiffness_jammed
from layerjam.laws import undamped_saw as undamped_saw
from layerjam.laws import vacuum_eq10 as vacuum_eq10
from layerjam.laws import vacuum_for_force as vacuum_for_force
from layerjam.laws import wet_force as wet_force
from layerjam.laws import wet_stress as wet_stress
from layerjam.measure.history import read_history as read_history
from layerjam.measure.log import read_log as read_log
from layerjam.measure.options import ReadingOptions as ReadingOptions
from layerjam.measure.readers.read import read_trace as read_trace
from layerjam.measure.readers.read import read_traces as read_traces
from layerjam.measure.trace import Trace as Trace
from layerjam.measure.trace import Trace as _Trace
from layerjam.mechanics.stick_slip.curve import Stribeck as Stribeck
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
from layerjam.toml_files.source import Source as Source

class _AgeingResult(_Ageing):
    def require(self) -> _AgeingKnown: ...

class _AgeingKnown(_AgeingResult):
    file: str

class _ArrayPullResult(_ArrayPull):
    def require(self) -> _ArrayPullKnown: ...

class _ArrayPullKnown(_ArrayPullResult):
    until: float

class _BenchClearedResult(_BenchCleared):
    def require(self) -> _BenchClearedKnown: ...

class _BenchClearedKnown(_BenchClearedResult):
    fault: str
    vacuum: float

class _BenchStateResult(_BenchState):
    def require(self) -> _BenchStateKnown: ...

class _BenchStateKnown(_BenchStateResult):
    fault: str
    vacuum: float
    safe_state: str
    vent_rest: str
    zero_age: float

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

class _BoardFlashedResult(_BoardFlashed):
    def require(self) -> _BoardFlashedKnown: ...

class _BoardFlashedKnown(_BoardFlashedResult):
    image_sha256: str
    identity: str

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

class _BoardWiringResult(_BoardWiring):
    def require(self) -> _BoardWiringKnown: ...

class _BoardWiringKnown(_BoardWiringResult):
    out: str

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
    robustness: _Mapping[str, _Mapping[str, Any]]

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

class _ExportedMujocoResult(_ExportedMujoco):
    def require(self) -> _ExportedMujocoKnown: ...

class _ExportedMujocoKnown(_ExportedMujocoResult):
    reason: str
    library: str
    mujoco_version: str

class _FollowedForceResult(_FollowedForce):
    def require(self) -> _FollowedForceKnown: ...

class _FollowedForceKnown(_FollowedForceResult):
    bandwidth: float
    bode: list[dict[str, float]]

class _FrictionResult(_Friction):
    def require(self) -> _FrictionKnown: ...

class _FrictionKnown(_FrictionResult):
    kinetic: float
    static_sd: float
    kinetic_sd: float
    stick_slip: _Mapping[str, Any]
    file: str

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

class _BrakeForceArray(_BrakeForce):
    sheet_friction: Any
    enclosure_force: Any
    force: Any

class _BrakeSummaryResult(_BrakeSummary):
    def require(self) -> _BrakeSummaryKnown: ...

class _BrakeSummaryKnown(_BrakeSummaryResult):
    drawn_mass: float
    stiffness_measured: float
    stiffness_mount: float
    film_strength: float

class _VacuumForForceResult(_VacuumForForce):
    def require(self) -> _VacuumForForceKnown: ...

class _VacuumForForceKnown(_VacuumForForceResult):
    vacuum: float
    reason: str

class _VacuumForForceArray(_VacuumForForce):
    vacuum: Any
    feasible: Any
    least_force: Any
    greatest_force: Any

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
    robustness: _Mapping[str, _Mapping[str, Any]]

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

class _TunedVacuumResult(_TunedVacuum):
    def require(self) -> _TunedVacuumKnown: ...

class _TunedVacuumKnown(_TunedVacuumResult):
    vacuum: float
    vacuum_eq10: float
    reason: str
    floor_g: float
    least_speed: float
    greatest_speed: float
    travel_needed: float
    sheets_needed: int
    brakes_needed: int

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
    hold: float | str | _HasUnit | None = ...,
    brake: str | _Path | _BrakeFile | _Brake | None = ...,
    out: str | _Path | None = ...,
    partial: bool = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
    overwrite: bool = ...,
) -> _AgeingResult:
    """How static friction grows while the films rest under load, from pulls after holds.

    Each file is a friction test whose sidecar states its `hold`; static friction is read as
    `friction` reads it. With `brake` and `out` static friction at `hold` (the geometric mean of all
    holds unless given) and its growth are written into a copy of the brake's file.
    """

def array(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    parallel: int | str | _HasUnit = ...,
    series: int | str | _HasUnit = ...,
    vacuum: float | str | _HasUnit | None = ...,
    until: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _ArrayPullResult:
    """Pull equal brakes side by side and in series, slowly.

    At the site's full vacuum unless another is given, to the elongation `until` or to the end of
    the travel. `outcome` is how the pull ends: FINISHED, BOTTOMED_OUT, or SNAPS where a slipping
    brake softens faster than those in series with it relax. `travel` and `energy` are by slip
    alone. An even share is assumed.
    """

def bench_clear(
    address: str,
) -> _BenchClearedResult:
    """Clear the latched fault of a bench, its error queue and its registers; starts nothing.

    The bench is in SAFE afterwards. Find the cause first: `bench check` looks after the wiring.
    Raises FileError, LineError and QuantityError for a bench that cannot be reached.
    """

def bench_serve(
    address: str,
    *,
    port: int | str | _HasUnit = ...,
    host: str = ...,
    token_file: str | _Path | None = ...,
    pty: str | _Path | None = ...,
) -> _BenchServed:
    """Let many clients talk to one bench, over TCP and as a serial port.

    The first line that is printed is JSON: `listening`, `pid`, `address`. It stays until SIGTERM or
    Ctrl-C, then switches the outputs off. Raises FileError if the port cannot be opened.
    """

def bench_status(
    address: str,
) -> _BenchStateResult:
    """Print the state of a bench.

    Sends queries only. On the board's own line it is the only client; if a gateway runs, use its
    `tcp:` address. Raises FileError, LineError and QuantityError if the bench cannot be reached.
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

    Pump and vent are driven for ten seconds; nothing may hang on the brake. The values of `line`
    are those that `bench run` tunes the regulator to. `tune` writes that line with the measured
    values. Raises QuantityError if the valve's rest is not known or a value for `tune` is missing,
    LockedError if another client commands, InstrumentError for a bench that is not in SAFE.
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
    runs: int | str | _HasUnit = ...,
    seed: int | str | _HasUnit = ...,
    mismatch: bool = ...,
    progress: _Callable[[str, float], None] = ...,
) -> _FaultCampaign:
    """Break a virtual board in every way, many times over, and time how it becomes safe.

    Each run draws a line around that of the address, a regulator, a target and a moment from the
    seed. With `mismatch` pump, vent, zero, lag and noise of the real line differ from the model,
    leak and vent are orifices, the pump's flow ripples and the supply dips; ten runs in which
    nothing breaks go with each round of faults. The firmware is the board's own; its clock runs as
    fast as samples are computed. Raises
    UnknownNameError for an unknown fault, QuantityError for an address that is not a virtual board.
    """

def bench_soak(
    *,
    line: str = ...,
    hours: float | str | _HasUnit = ...,
    kind: Literal["bang-bang", "pi", "scheduled"] = ...,
    seed: int | str | _HasUnit = ...,
    progress: _Callable[[str, float], None] = ...,
) -> _SoakResult:
    """Let a virtual board regulate for hours of its own time, in which nothing may happen.

    Targets, releases and holds are drawn from the seed. A day takes minutes. Raises QuantityError
    for an address that is not a virtual board.
    """

def bench_flash(
    port: str,
    *,
    board: str = ...,
    image: str | _Path | None = ...,
    settings: str | _Path | None = ...,
) -> _BoardFlashedResult:
    """Put firmware and wiring onto a board.

    With an image the board's boot loader takes it; a board with plain MicroPython gets the
    firmware's files otherwise. Raises FileError, ImageError, LineError, QuantityError and
    UnknownNameError.
    """

def bench_export(
    run: str | _Path,
    *,
    out: str | _Path,
    start: float | str | _HasUnit | None = ...,
    end: float | str | _HasUnit | None = ...,
    overwrite: bool = ...,
) -> _RunExportedResult:
    """Write a run for other programs: CSV with its sidecar, Parquet, or NetCDF.

    Friction, calibrate, leak, pump-down and regulate read the CSV as it is. Each drop in the run is
    a file of its own in the same folder, FILE-shot1.csv, which crash reads; NetCDF contains it. A
    run that nobody closed is `interrupted`; its file is read in place, together with its `-wal`
    file.
    """

def bench_log(
    address: str,
    *,
    out: str | _Path,
    duration: float | str | _HasUnit | None = ...,
    resume: bool = ...,
    overwrite: bool = ...,
) -> _RunLoggedResult:
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
) -> _RunRecordedResult:
    """Carry out a procedure on a bench and record every sample.

    The regulator is made for the line, at the highest vacuum of the procedure, and given to the
    board. With `shot` the accelerometer of a falling mass waits from the first hold on, and every
    drop is kept in the file. Whatever happens, the last act is safe outputs and a closed file;
    Ctrl-C ends it with OPERATOR_STOPPED. Raises QuantityError for what the bench cannot do,
    InstrumentError if it refuses, FileError for the file. Nothing moves if a check of the
    regulator fails; the file stores the failed checks that `accept` accepts.
    """

def bench_wiring(
    board: str | _Path,
    *,
    out: str | _Path | None = ...,
) -> _BoardWiringResult:
    """List a board's wires and parts, calculate their worst case, and draw the circuit.

    Raises FileError for a file that does not describe a board, or that exists; UnknownNameError for
    an unknown board.
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
) -> _BendResult:
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
    vacuum: float | str | _HasUnit | None = ...,
    out: str | _Path | None = ...,
    partial: bool = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    left_out: _LeftOut = ...,
    within: float | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    sampling: _Sampling = ...,
    progress: _Callable[[str, float], None] | None = ...,
    overwrite: bool = ...,
) -> _BrakeCalibrationResult:
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
    vacuum: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
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
    sampling: float | str | _HasUnit | None = ...,
    before: float | str | _HasUnit | None = ...,
    sensor_range: float | str | None = ...,
    falling: bool = ...,
    hic: float | str | _HasUnit | None = ...,
    shot: int | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _TableOptions = ...,
) -> _CrashFoundResult:
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
) -> _DesignResultResult:
    """Find the best brake for a set of requirements.

    Beside it: the front, the runner-up and why it lost, what forbids better ones. `feasible` is
    False with `reason`, `killed_by` and `reachable` where nothing meets the constraints;
    contradictions that follow from bounds are found before anything is swept. `chosen` is the best
    design of the grid, `refined` the best between its steps.
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
    hyperelastic: bool = ...,
    partial: bool = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _TableOptions = ...,
    overwrite: bool = ...,
) -> _SiliconeFitResult:
    """Modulus and hyperelastic fit of the enclosure's silicone from ASTM D412 curves.

    `start` and `end` bound the strain of the initial slope, `fit_to` is the greatest strain that is
    fitted. Each file is one specimen; specimens of one material are pooled. `material` names the
    silicone of the catalogue to compare with, where the files do not. With `brake` and `out` the
    mean 100 % modulus is written into a copy of the brake, with `hyperelastic` the model too.
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
    rope_stiffness: float | str | _HasUnit | None = ...,
    strict: bool = ...,
    overwrite: bool = ...,
) -> _ExportedFmuResult:
    """Write the brake as a functional mock-up unit for Simulink, Dymola, OpenModelica and others.

    FMI 3.0 or 2.0, co-simulation and model exchange, compiled C: no Python at the target. Inputs
    are elongation, velocity and vacuum, outputs force, slip and energies; parameters carry the
    brake file's own names, units and bounds. Raises FileError if the file exists unless
    `overwrite`, QuantityError for sheets that fan out, a speed law or a hyperelastic enclosure, or
    an unknown platform; CompilerError if no compiler is found.
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
    slip_noise: float | str | _HasUnit = ...,
    model_error: float | str | _HasUnit = ...,
    seed: int | str | _HasUnit = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _FollowedForceResult:
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
) -> _FrictionResult:
    """Static and kinetic friction from friction tests: as the paper, ASTM D1894 or ISO 8295 has it.

    `files` are paths or traces, several or one. `normal_force` may come from the files' sidecars,
    or from the 200 g of the two standards; `start` and `end` bound the displacement of the kinetic
    mean, counted from the record's first sample; `area` is that under the sled, for the pressure of
    the test. If a record sticks and slips, kinetic is None; `accept_stick_slip` takes the middle
    of the stick–slip. With `brake` and `out` the result is written into a copy of the brake's file.
    If a check fails, nothing is written; `accept` accepts failed checks by name, {check: reason}.
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
    progress: _Callable[[str, float], None] | None = ...,
) -> _StopResult:
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

def lab(
    spec: str | _Path | _Spec | None = ...,
    *,
    out: str | _Path | None = ...,
    example: bool = ...,
    seed: int | str | _HasUnit | None = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _PracticeFilesResult:
    """Practice files of a virtual laboratory: the truth is known, the machine has its faults.

    The files of a campaign and the truth are written into the folder `out`. `spec` is
    the path of a TOML file, a Spec, or "practice", which is built in; `seed` counts instead of its
    own. Every file says that it is synthetic. Stopped by the keyboard, the files written are whole
    and the result says so. Raises FileError if `out` is not empty and `overwrite` is not set.
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
    """Practice files of a virtual laboratory: the truth is known, the machine has its faults.

    The files of a campaign and the truth are written into the folder `out`. `spec` is
    the path of a TOML file, a Spec, or "practice", which is built in; `seed` counts instead of its
    own. Every file says that it is synthetic. Stopped by the keyboard, the files written are whole
    and the result says so. Raises FileError if `out` is not empty and `overwrite` is not set.
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
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _CollisionPlanResult:
    """Whether the vacuum is there when a collision comes, and what to build if not.

    The estimate is the mean of mass and speed. The reservoir begins as low as pump and leak come
    to unless `stored` says otherwise. `vacuum_share` of what the gauge reads presses the sheets.
    `leak_time` is a laminar leak of the chamber, which goes on during the stop.
    """

@overload
def force(  # type: ignore[overload-overlap]
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str,
    vacuum: float | str,
    sliding_speed: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _BrakeForce: ...
@overload
def force(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str | _ArrayLike | _HasUnit,
    vacuum: float | str | _ArrayLike | _HasUnit,
    sliding_speed: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _BrakeForceArray:
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

    Raises FileError if `out` exists and `overwrite` is not set, or the name will not do.
    """

def show(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _BrakeSummaryResult:
    """Mass, forces, energy and strength of a brake, and the source of each of its numbers."""

@overload
def vacuum(  # type: ignore[overload-overlap]
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str,
    force: float | str,
    sliding_speed: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _VacuumForForceResult: ...
@overload
def vacuum(
    brake: str | _Path | _BrakeFile | _Brake,
    *,
    slip: float | str | _ArrayLike | _HasUnit,
    force: float | str | _ArrayLike | _HasUnit,
    sliding_speed: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _VacuumForForceArray:
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
    """Write one campaign as a dataset that stands alone, so that others can recompute its numbers.

    The raw files are copied unchanged, with their sidecars and all other files in the folder
    `campaign`. The dataset adds brake and line, report, results, recipe, checksums, and a
    description that repositories read (RO-Crate 1.1). A measurement that states a normal force is a
    friction test, any other a pull; a calibrated brake in the folder says which pulls it was
    calibrated on, and `measurements` say it otherwise, as in `report`. If a check fails, nothing is
    written; `accept` accepts failed checks by name, {check: reason}, and the dataset states them.
    Raises FileError if neither
    the folder nor `brake` states which brake was tested, or if `out` exists and is not a dataset
    to be replaced with `overwrite`.
    """

def recompute(
    dataset: str | _Path,
    *,
    progress: _Callable[[str, float], None] | None = ...,
) -> _RecomputedResult:
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
    start: float | str | _HasUnit | None = ...,
    end: float | str | _HasUnit | None = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _Pulls:
    """Features of measured pulls: slack, preload, onset, stiffness, peak, stick–slip, unloading.

    `files` are paths or traces, several or one. Nothing is subtracted from a force unless `tare`
    asks for the force before the load rises. `start` and `end` choose a part of each record by its
    time. Stick–slip grows with its spacing; teeth of one spacing in several files whose swings
    differ are a ripple of the machine.
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
    """One record, its sources and the records derived from it.

    Raises RecordsError if none or several have that name.
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

    A file that was withdrawn cannot be added again. Raises RecordsError if there is no such
    record, or it was withdrawn before.
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
    """Bring a line to a vacuum and hold it there, in closed loop with a noisy sensor.

    With a recorded `step` gains, detectors and the line simulated are those that the log shows
    (`identified`), and its scatter is the noise unless that is given. `detection` is the longest
    time [s] until each fault is reported at this vacuum (None: never). `fault` breaks the line or
    the sensor from `fault_at` on; `said_after` is None if it reported nothing, or reported before
    that time.
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
    """Measurements of one brake as a page: friction, calibration, validation, HTML and PDF.

    Writes report.html, report.pdf, figures, numbers.csv and results.json into the folder `out`.
    `friction` tests give the friction, `pulls` the calibration, `validate` are the pulls to compare
    the calibrated brake with; each may be omitted. Without `validate` some pulls can be held back:
    `calibrate_on` names those to calibrate on, or `holdout` holds back a vacuum ("46.1 kPa"), a
    speed ("19 mm/s") or a repeat ("repeat 3"). Without any of these the brake is compared with the
    pulls it was calibrated on, and the page says so. `vacuum` serves files without a sidecar; the
    options of friction tests, `depth` and `exclude` are as in `friction` and `calibrate`. `command`
    is shown as the command that made the page, `date` (ISO) is today unless given; `names` {file
    name: name in the report} serves files that are stored under other names than their own.
    `report_number` and `customer` appear on the pages; sidecars may state them instead. If a check
    fails, nothing is written; `accept` accepts failed checks by name, {check: reason}. Raises
    FileError if a report exists and `overwrite` is not set.
    """

def schema(
    name: str | None = ...,
) -> _Schemas:
    """JSON Schema of what a command prints with --json.

    Draft 2020-12; each key has type, meaning and SI `unit`. The output is itself a
    schema: `anyOf` refers to the definitions of `$defs`, one for each command.
    """

class Sensing(_Sensing):
    """Measuring chain of a stop: accelerometer, low-pass, rate, and a filter after it."""

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
    travel: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
) -> _StickSlipResult:
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
) -> _DesignSweepResult:
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
    vacuum: float | str | _HasUnit | None = ...,
    speed: float | str | _HasUnit | None = ...,
    travel: float | str | _HasUnit | None = ...,
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
) -> _TensileResult:
    """Pull a brake in a simulated test machine.

    Either vacuum, speed and travel (elongation of the crosshead), or a procedure. Only for the
    model "stack": `static` friction before an interface slides, and `one_by_one`: interfaces that a
    break overloads let go one after the other, the most overloaded first, and not together;
    `interfaces` that differ, a `housing` that rubs, and `scatter`, the relative SD of the
    interfaces' friction: then `samples` (1000) stacks, drawn from `seed` (1), give mean and SD of
    peak, stiffness and onset; interrupted from the keyboard, of those that are done. `vacuum_share`
    of the gauge's reading presses the sheets. With `leak_time` the line is shut off after every
    evacuation and the vacuum leaks away from then on; not in the stack, which keeps the vacuum it
    starts with. Raises ProcedureError or QuantityError for contradictions.
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
    atmosphere: float | str | _HasUnit | None = ...,
) -> _TunedVacuumResult:
    """Vacuum that stops a mass within a travel (slip of the brake), exactly and by eq. 10.

    The mass arrives with `speed` or falls from `height`. Where there is no such vacuum, `reason`
    says why and what would do: the speeds that can be stopped so, another travel, another number
    of sheets, more brakes side by side, each by itself. Each was tuned before it is named.
    """

def rise(
    line: str | _Path | _LineFile | _Line,
    *,
    target: float | str | _HasUnit,
    fluid: Literal["air", "water"] = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _VacuumRiseResult:
    """Time in which a line reaches a vacuum, and time in which it releases it.

    The pump runs full on until the target is reached. If it is never reached, `rise_time`
    is None, `feasible` False and `reason` states the vacuum that can be reached. In air the line is
    integrated; `closed_form` holds for a rigid volume without an effect of tube or orifice.
    `fall_time` is by the vent valve from when it is open, or the pumps run backwards (`fall_by`),
    with `closed_form_fall` likewise; None if the line has neither. `tube_delay` and `tube_lag`
    are None in water and for a line that has no tube. A tube in many cells takes a while.
    """

def validate(
    brake: str | _Path | _BrakeFile | _Brake,
    files: _Sequence[str | _Path | _Trace | _DataFrame] | str | _Path | _Trace | _DataFrame,
    *,
    vacuum: float | str | _HasUnit | None = ...,
    atmosphere: float | str | _HasUnit | None = ...,
    left_out: _LeftOut = ...,
    accept: _Sequence[str] | _Mapping[str, str] | None = ...,
    options: _FileOptions = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _ModelErrorsResult:
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

def scenario(
    scenario: str | _Path | None = ...,
    *,
    out: str | _Path | None = ...,
    names: bool = ...,
    overwrite: bool = ...,
    progress: _Callable[[str, float], None] | None = ...,
) -> _MachineResultResult:
    """Check a machine of the paper's Fig. 13 against its limits.

    It is a seat belt, neck guard, ankle clutch or rehabilitation orthosis with its loads and
    limits. With `out` a page with pictures is written there (`page`). `feasible` is whether every
    one of `limits` is met, `reason` the one that decides, and `conclusion` a summary with the
    requirements. `brakes_needed` is None if no number of brakes is enough. `results` has the
    machine's own keys; `units` the unit of each. Raises FileError for an invalid file,
    QuantityError for values out of bounds.
    """

(design := design_brake)  # noqa: PLW0131
(report := write_report)  # noqa: PLW0131
