"""layerjam: design, predict, test, calibrate and drive soft layer-jamming brakes.

Everything public can be had from here and is imported when first used, so that
``import layerjam`` costs nothing. Laws need JAX in double precision:
``jax.config.update("jax_enable_x64", True)``.
"""

from __future__ import annotations

import importlib
import sys
import types
from typing import Any

from layerjam._version import __version__

_PUBLIC = {
    "layerjam.device.brake": "Brake mass sheet_mass sleeve_mass validate_brake:validate",
    "layerjam.device.enclosure": "Enclosure",
    "layerjam.device.file": "BrakeFile",
    "layerjam.device.load": "catalogue load",
    "layerjam.device.mount": "Mount Rope Site",
    "layerjam.device.sheets": "Film Sheets",
    "layerjam.device.source": "Source",
    "layerjam.errors": "LayerjamError",
    "layerjam.identify.readers.read": "read_trace read_traces",
    "layerjam.identify.trace": "Trace",
    "layerjam.mechanics.enclosure": "enclosure_force saturation_slip sleeve_stretch",
    "layerjam.mechanics.energy": "energy_capacity pull_work slip_heat slip_work",
    "layerjam.mechanics.friction": "holding_force sheet_friction",
    "layerjam.mechanics.hysteresis": "brake_cycle",
    "layerjam.mechanics.limits": "buckling_force clamp_stress self_closing_vacuum sheet_stress "
    "travel_left",
    "layerjam.mechanics.memory": "enclosure_cycle",
    "layerjam.mechanics.pull": "brake_force force_at_elongation force_limits least_stiffness peak "
    "peak_vacuum scale_factor_of_peak slip_at_elongation vacuum_for_force",
    "layerjam.mechanics.stiffness": "mount_stiffness stiffness_before_slip stiffness_sliding",
    "layerjam.report.reproduce": "reproduce",
    "layerjam.simulate.procedure": "Procedure parse_procedure",
    "layerjam.simulate.record": "DropRecord Outcome TensileRecord",
    "layerjam.verbs.answer": "Answer",
    "layerjam.identify.logs.history": "read_history",
    "layerjam.identify.friction.stribeck": "fit_dry fit_wet speed_points",
    "layerjam.mechanics.stickslip": "Stribeck critical_speed slow_saw sliding_force stable_speed "
    "stiffness_without_judder stribeck_friction undamped_saw",
    "layerjam.mechanics.wet": "WetFilm wet_force wet_stress",
    "layerjam.simulate.batch": "batch",
    "layerjam.simulate.judder": "JudderRecord amplitude_map",
    "layerjam.simulate.stack": "tensile_stack",
    "layerjam.simulate.stack_layout": "Housing Interfaces stack_of",
    "layerjam.simulate.stack_spread": "Spread peak_spread",
    "layerjam.verbs.judder": "judder",
    "layerjam.mechanics.heat": "local_rise stops_per_minute temperature_rise "
    "temperature_rise_of_sheets",
    "layerjam.mechanics.motion": "stop_in_time",
    "layerjam.simulate.accelerometer": "Accelerometer Reading seen",
    "layerjam.simulate.drop_in_time": "History drop_in_time",
    "layerjam.mechanics.stop": "speed_at_slip stop time_at_slip",
    "layerjam.mechanics.tune": "tuned_vacuum vacuum_eq10",
    "layerjam.verbs.impact": "drop",
    "layerjam.verbs.sensor": "heating observed reading",
    "layerjam.verbs.tuning": "tune",
    "layerjam.verbs.vacuum_line": "rise",
    "layerjam.verbs.parts": "parts",
    "layerjam.verbs.edit": "edit",
    "layerjam.verbs.edit_line": "edit_line",
    "layerjam.verbs.regulate": "regulate",
    "layerjam.verbs.follow": "follow",
    "layerjam.verbs.plan": "plan",
    "layerjam.verbs.compare": "compare",
    "layerjam.verbs.apply": "apply machines",
    "layerjam.verbs.design": "brake_of design",
    "layerjam.verbs.array": "array",
    "layerjam.verbs.sweep": "sweep",
    "layerjam.design.spec": "load_spec",
    "layerjam.design.arrays": "Array Member grid in_parallel in_series single totals",
    "layerjam.design.antagonist": "neutral_stiffness pair",
    "layerjam.verbs.calibration": "calibrate",
    "layerjam.verbs.friction": "friction",
    "layerjam.verbs.validation": "validate",
    "layerjam.identify.virtual.campaign": "Campaign campaign",
    "layerjam.identify.validation.metrics": "uncalibrated validate_curves",
    "layerjam.identify.validation.table": "pool",
    "layerjam.identify.friction.standards": "Standard",
    "layerjam.identify.judder_in_record": "SawTeeth find_saw_teeth",
    "layerjam.identify.pull.summary": "PullSummary pull_summary",
    "layerjam.verbs.pull": "pull",
    "layerjam.identify.logs.table": "read_log",
    "layerjam.verbs.sleeve": "sleeve",
    "layerjam.verbs.pressure_log": "leak pump_down",
    "layerjam.verbs.measurements": "crash",
    "layerjam.verbs.lab": "lab lab_example",
    "layerjam.verbs.report": "report",
    "layerjam.verbs.predict": "force new show tensile vacuum",
}
_WHERE = {
    name.split(":")[0]: (module, name.split(":")[-1])
    for module, names in _PUBLIC.items()
    for name in names.split()
}

__all__ = ["__version__", *sorted(_WHERE)]  # noqa: PLE0604


class _Root(types.ModuleType):
    """Importing a folder does not hide the verb of its name: `layerjam.design`, `layerjam.report`.

    Leaves are imported with `from`: `from layerjam.design.merit import MERITS`.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _WHERE and isinstance(value, types.ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Root


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module 'layerjam' has no attribute '{name}'")
    module, inside = _WHERE[name]
    value = getattr(importlib.import_module(module), inside)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
