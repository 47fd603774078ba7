"""layerjam: design, predict, test, calibrate and drive soft layer-jamming brakes.

The commands are functions such as `layerjam.force` and `layerjam.drop` that accept text with units
or SI numbers and return results that can be printed, plotted and saved; the equations are in
`layerjam.laws`. Each name is imported when it is first used, so that ``import layerjam`` is fast.
"""

import importlib
import importlib.util
import os.path
import sys
import types
import warnings
from importlib.machinery import ModuleSpec
from typing import TYPE_CHECKING, Any

from layerjam._version import __version__ as __version__

if TYPE_CHECKING:
    from importlib.abc import Loader
else:
    Loader = object  # the class itself imports ten modules, which take longer than this package

_FORMER = {
    "layerjam.workshop.commands.design": "brake_of",
    "layerjam.laboratory.commands.lab": "lab_example",
    "layerjam.laboratory.commands.enclosure": "sleeve:enclosure",
    "layerjam.brake.commands.stick_slip": "judder",
    "layerjam.workshop.design.antagonist": "neutral_stiffness pair",
    "layerjam.workshop.design.arrays": "Array Member grid in_parallel in_series single totals",
    "layerjam.brake.device.brake": "sleeve_mass:enclosure_mass validate_brake:validate",
    "layerjam.laboratory.identify.friction.stribeck": "fit_dry fit_wet speed_points",
    "layerjam.laboratory.identify.pull.summary": "PullSummary pull_summary",
    "layerjam.laboratory.identify.stick_slip": "SawTeeth find_saw_teeth",
    "layerjam.laboratory.identify.validation.metrics": "uncalibrated validate_curves",
    "layerjam.laboratory.identify.validation.several": "pool",
    "layerjam.laboratory.campaigns.campaign": "campaign",
    "layerjam.brake.mechanics.enclosure": "sleeve_stretch:enclosure_stretch",
    "layerjam.brake.mechanics.stick_slip.laws": (
        "stiffness_without_judder:stiffness_without_stick_slip"
    ),
    "layerjam.brake.simulate.accelerometer": "Reading seen:measure_acceleration",
    "layerjam.brake.simulate.drop_in_time": "drop_in_time",
    "layerjam.brake.simulate.stack": "tensile_stack",
    "layerjam.brake.simulate.stack_layout": "stack_of:make_stack",
    "layerjam.brake.simulate.stack_spread": "Spread peak_spread",
    "layerjam.brake.simulate.stick_slip": "JudderRecord:StickSlipRecord amplitude_map",
    "layerjam.studies.machines.apply": "apply:scenario machines",
}
"""Former names in the package, {module: names, `old:new` if renamed}; they still work."""
_MOVED = {
    "core": "errors verdict conversion units outputs system toml_files",
    "brake": "device mechanics fluid kernel simulate",
    "laboratory": "measure identify campaigns dataset records",
    "bench": "control rig",
    "workshop": "design fabricate",
}
"""Former subpackages and modules of the package, by the wing that they moved to."""
_NEW = {room: f"{wing}.{room}" for wing, rooms in _MOVED.items() for room in rooms.split()}
_RENAMED = {
    "brake.mechanics.stack": "batch:peaks pull:history",
    "brake.mechanics.stop": "curve:energy_curve timing:duration",
    "brake.mechanics.stick_slip": "curve:stribeck",
    "brake.fluid": "curve:pump_curve energy:vacuum_energy file:line_file",
    "brake.device": "file:brake_file",
    "laboratory.identify": "checks:fit_checks",
    "laboratory.identify.bayes": "checks:sampler_checks",
    "laboratory.identify.rubber": "checks:specimen_checks",
    "laboratory.identify.logs": "checks:log_checks",
    "laboratory.identify.friction": "record:outward",
    "laboratory.identify.calibration": "record:result",
    "laboratory.identify.validation": "table:several",
    "laboratory.dataset": "campaign:campaign_folder",
    "laboratory.records": "names:record_names",
    "laboratory.measure.readers": "names:column_names",
    "laboratory.campaigns": "records:virtual_records",
    "bench.rig": "plant:virtual_plant",
}
"""Modules that were also renamed, {folder: `old:new`}."""
_NEW_NAMES = {
    f"{folder}.{pair.split(':')[0]}": f"{folder}.{pair.split(':')[1]}"
    for folder, pairs in _RENAMED.items()
    for pair in pairs.split()
} | {
    "brake.mechanics.threads": "core.threads",
    "brake.commands.quantities": "brake.commands.arguments",
    "bench.figures.wiring": "bench.figures.wiring_diagram",
}


def _read_names(file: str) -> dict[str, tuple[str, str]]:
    """Return {name: (module, name there)} of a file with a line for each import."""
    with open(os.path.join(os.path.dirname(__file__), file), encoding="utf-8") as lines:
        imports = [line.split() for line in lines if line.startswith("from ")]
    # from MODULE import NAME as NAME
    return {words[-1]: (words[1], words[3]) for words in imports}


_EXPORTS = _read_names("_names.pyi")
_OLD = {
    entry.split(":")[0]: (module, entry.split(":")[-1])
    for module, entries in _FORMER.items()
    for entry in entries.split()
}
__all__ = sorted(_EXPORTS)  # noqa: PLE0605


class _FormerPaths(Loader):
    """Imports modules by the paths that they had before the wings, with a DeprecationWarning."""

    def find_spec(self, name: str, path: Any, target: Any = None) -> ModuleSpec | None:
        root, _, inner = name.partition(".")
        known = root == "layerjam" and inner.partition(".")[0] in (*_NEW, "commands", "report")
        return ModuleSpec(name, self, is_package=True) if known else None

    def create_module(self, spec: ModuleSpec) -> None:
        """Leave the module to Python."""

    def exec_module(self, module: types.ModuleType) -> None:
        name = self._find_module(module.__name__.removeprefix("layerjam."))
        warnings.warn(f"{module.__name__} is now {name}", DeprecationWarning, stacklevel=2)
        sys.modules[module.__name__] = importlib.import_module(name)

    def _find_module(self, former: str) -> str:
        package, _, inner = former.partition(".")
        if package in _NEW:
            path = f"{_NEW[package]}{inner and '.'}{inner}"
            return f"layerjam.{_NEW_NAMES.get(path, path)}"
        folders = [
            f"{wing}.{'commands' if package == 'commands' else 'figures'}" for wing in _MOVED
        ]
        folders = ["core.command" if package == "commands" else "core.drawing", *folders[1:]]
        if not inner:
            return f"layerjam.{folders[0]}"
        inner = {"predict": "force", "impact": "drop"}.get(inner, inner)
        for folder in (*folders, "interop.commands"):
            if importlib.util.find_spec(f"layerjam.{folder}.{inner}") is not None:
                return f"layerjam.{folder}.{inner}"
        raise ModuleNotFoundError(f"No module named 'layerjam.{former}'")


sys.meta_path.insert(0, _FormerPaths())


class _Root(types.ModuleType):
    def __setattr__(self, name: str, value: Any) -> None:
        # a module under its former path must not hide the command of the same name
        if not (isinstance(value, types.ModuleType) and value.__name__ != f"{__name__}.{name}"):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Root


def __getattr__(name: str) -> Any:
    if name == "laws" or (name in _NEW and name not in _EXPORTS):
        return importlib.import_module(f"layerjam.{name}")
    if name.startswith("__"):
        raise AttributeError(f"module 'layerjam' has no attribute '{name}'")
    module, inside = {**_OLD, **_EXPORTS}.get(name, ("layerjam.laws", name))
    value = getattr(importlib.import_module(module), inside, None) or _find_command(name)
    if value is None:
        raise AttributeError(f"module 'layerjam' has no attribute '{name}'")
    if hasattr(value, "declaration"):
        importlib.import_module("layerjam.core.command.documentation").document(value)
    globals()[name] = value
    return value


def _find_command(name: str) -> Any:
    """Return the function of a command that another package declares, or None."""
    entry = importlib.import_module("layerjam.core.command.index").find_entry(name)
    return entry and getattr(importlib.import_module(entry.module), entry.python_name)


def __dir__() -> list[str]:
    # the laws are listed in `layerjam.laws`; their former names here still work
    return sorted({*__all__, "laws"})
