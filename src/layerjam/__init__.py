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
    "layerjam.device.brake": "Brake enclosure_mass mass sheet_mass "
    "sleeve_mass:enclosure_mass validate_brake:validate",
    "layerjam.device.enclosure": "Enclosure",
    "layerjam.device.file": "BrakeFile",
    "layerjam.device.load": "catalogue load",
    "layerjam.device.mount": "Mount Rope Site",
    "layerjam.device.sheets": "Film Sheets",
    "layerjam.records.source": "Source",
    "layerjam.errors": "LayerjamError",
    "layerjam.measure.readers.read": "read_trace read_traces",
    "layerjam.measure.trace": "Trace",
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
    "layerjam.studies.choi2018.reproduce": "reproduce",
    "layerjam.simulate.procedure": "Procedure parse_procedure",
    "layerjam.simulate.record": "DropRecord Outcome TensileRecord",
    "layerjam.commands.answer": "Answer",
    "layerjam.measure.history": "read_history",
    "layerjam.identify.friction.stribeck": "fit_dry fit_wet speed_points",
    "layerjam.mechanics.stick_slip.laws": "Stribeck critical_speed slow_saw sliding_force "
    "stable_speed stiffness_without_judder stribeck_friction undamped_saw",
    "layerjam.mechanics.stick_slip.wet": "WetFilm wet_force wet_stress",
    "layerjam.simulate.batch": "batch",
    "layerjam.simulate.stick_slip": "JudderRecord amplitude_map",
    "layerjam.simulate.stack": "tensile_stack",
    "layerjam.simulate.stack_layout": "Housing Interfaces stack_of",
    "layerjam.simulate.stack_spread": "Spread peak_spread",
    "layerjam.commands.stick_slip": "judder",
    "layerjam.mechanics.heat": "local_rise stops_per_minute temperature_rise "
    "temperature_rise_of_sheets",
    "layerjam.mechanics.stop.motion": "stop_in_time",
    "layerjam.simulate.accelerometer": "Accelerometer Reading seen",
    "layerjam.simulate.drop_in_time": "History drop_in_time",
    "layerjam.mechanics.stop.exact": "speed_at_slip stop time_at_slip",
    "layerjam.mechanics.stop.tune": "tuned_vacuum vacuum_eq10",
    "layerjam.commands.impact": "drop observed",
    "layerjam.commands.sensor": "heating reading",
    "layerjam.commands.tuning": "tune",
    "layerjam.commands.vacuum_line": "rise",
    "layerjam.commands.parts": "parts",
    "layerjam.commands.edit": "edit",
    "layerjam.commands.edit_line": "edit_line",
    "layerjam.commands.regulate": "regulate",
    "layerjam.commands.follow": "follow",
    "layerjam.commands.plan": "plan",
    "layerjam.commands.compare": "compare",
    "layerjam.studies.machines.apply": "apply machines",
    "layerjam.commands.design": "brake_of design",
    "layerjam.commands.array": "array",
    "layerjam.commands.sweep": "sweep",
    "layerjam.design.spec": "load_spec",
    "layerjam.design.arrays": "Array Member grid in_parallel in_series single totals",
    "layerjam.design.antagonist": "neutral_stiffness pair",
    "layerjam.commands.calibration": "calibrate",
    "layerjam.commands.friction": "friction",
    "layerjam.commands.validation": "validate",
    "layerjam.lab.campaign": "Campaign campaign",
    "layerjam.identify.validation.metrics": "uncalibrated validate_curves",
    "layerjam.identify.validation.table": "pool",
    "layerjam.identify.friction.standards": "Standard",
    "layerjam.identify.stick_slip": "SawTeeth find_saw_teeth",
    "layerjam.identify.pull.summary": "PullSummary pull_summary",
    "layerjam.commands.pull": "pull",
    "layerjam.measure.log": "read_log",
    "layerjam.commands.sleeve": "sleeve",
    "layerjam.commands.pressure_log": "leak pump_down",
    "layerjam.commands.measurements": "crash",
    "layerjam.commands.lab": "lab lab_example",
    "layerjam.commands.report": "report",
    "layerjam.commands.predict": "force new show vacuum",
    "layerjam.commands.tensile": "tensile",
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
