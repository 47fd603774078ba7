"""layerjam: design, predict, test, calibrate and drive soft layer-jamming brakes.

The commands are functions such as `layerjam.force` and `layerjam.drop` that accept text with units
or SI numbers and return results that can be printed, plotted and saved; the equations are in
`layerjam.laws`. Each name is imported when it is first used, so that ``import layerjam`` is fast.
"""

import ast
import importlib
import sys
import types
from pathlib import Path
from typing import Any

from layerjam._version import __version__ as __version__

_FORMER = {
    "layerjam.commands.design": "brake_of",
    "layerjam.commands.lab": "lab_example",
    "layerjam.commands.enclosure": "sleeve:enclosure",
    "layerjam.commands.stick_slip": "judder",
    "layerjam.design.antagonist": "neutral_stiffness pair",
    "layerjam.design.arrays": "Array Member grid in_parallel in_series single totals",
    "layerjam.device.brake": "sleeve_mass:enclosure_mass validate_brake:validate",
    "layerjam.identify.friction.stribeck": "fit_dry fit_wet speed_points",
    "layerjam.identify.pull.summary": "PullSummary pull_summary",
    "layerjam.identify.stick_slip": "SawTeeth find_saw_teeth",
    "layerjam.identify.validation.metrics": "uncalibrated validate_curves",
    "layerjam.identify.validation.table": "pool",
    "layerjam.campaigns.campaign": "campaign",
    "layerjam.mechanics.enclosure": "sleeve_stretch:enclosure_stretch",
    "layerjam.mechanics.stick_slip.laws": "stiffness_without_judder:stiffness_without_stick_slip",
    "layerjam.simulate.accelerometer": "Reading seen:measure_acceleration",
    "layerjam.simulate.drop_in_time": "drop_in_time",
    "layerjam.simulate.stack": "tensile_stack",
    "layerjam.simulate.stack_layout": "stack_of:make_stack",
    "layerjam.simulate.stack_spread": "Spread peak_spread",
    "layerjam.simulate.stick_slip": "JudderRecord:StickSlipRecord amplitude_map",
    "layerjam.studies.machines.apply": "apply:scenario machines",
}
"""Former names in the package, {module: names, `old:new` if renamed}; they still work."""
_FOLDERS = {"design": "design_brake", "report": "write_report"}
"""Subpackages that share the name of a command; calling such a module runs the command."""


def _read_names(file: str) -> dict[str, tuple[str, str]]:
    """Return {name: (module, name there)} of the names that a file of imports defines."""
    tree = ast.parse(Path(__file__).with_name(file).read_text(encoding="utf-8"))
    return {
        alias.asname or alias.name: (str(node.module), alias.name)
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


_EXPORTS = _read_names("_names.pyi")
_OLD = {
    entry.split(":")[0]: (module, entry.split(":")[-1])
    for module, entries in _FORMER.items()
    for entry in entries.split()
}
__all__ = sorted(_EXPORTS)  # noqa: PLE0605


class _Command(types.ModuleType):
    """A subpackage that can be called like the command of the same name."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return getattr(sys.modules["layerjam"], _FOLDERS[self.__name__.rpartition(".")[2]])(
            *args, **kwargs
        )


class _Root(types.ModuleType):
    def __setattr__(self, name: str, value: Any) -> None:
        if name in _FOLDERS and isinstance(value, types.ModuleType):
            value.__class__ = _Command
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Root


def __getattr__(name: str) -> Any:
    if name in _FOLDERS or name == "laws":
        return importlib.import_module(f"layerjam.{name}")
    if name.startswith("__"):
        raise AttributeError(f"module 'layerjam' has no attribute '{name}'")
    module, inside = {**_OLD, **_EXPORTS}.get(name, ("layerjam.laws", name))
    value = getattr(importlib.import_module(module), inside, None)
    if value is None:
        raise AttributeError(f"module 'layerjam' has no attribute '{name}'")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, *_FOLDERS, *_read_names("laws.py")})
