"""`apply`: a machine with brakes, from a scenario file, and whether it can work."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from layerjam.commands.answer import Answer
from layerjam.studies.machines.registry import analyse, load_scenario, scenarios


def apply(
    scenario: str | Path,
    *,
    out: str | Path | None = None,
    force: bool = False,
    say: Callable[[str], None] | None = None,
) -> Answer:
    """One of the four machines of the paper's Fig. 13: its loads, its limits, the honest verdict.

    `scenario` is a name of `machines()` or the path of a TOML file. With `out` a page with pictures
    is written there (`page`). `feasible` tells whether every one of `limits` is met, `reason` names
    the one that decides, `verdict` says it in a sentence or two, with what would be needed;
    `brakes_needed` is None where no number of brakes does. `results` holds the machine's own keys;
    `units` names the unit of each. `record` is the Result. Raises FileError for a file that is
    none, QuantityError for values out of bounds.
    """
    say = say or (lambda _: None)
    given = load_scenario(scenario)
    if out is not None:
        from layerjam.studies.machines.page import check_folder

        check_folder(Path(out), force)
    say(f"{given.machine}: {given.title or given.name}")
    result = analyse(given)
    values: dict[str, Any] = {
        "machine": given.machine,
        "scenario": given.name,
        "feasible": result.feasible,
        "reason": result.reason,
        "verdict": result.verdict,
        "brakes_needed": result.brakes_needed,
        "mass": result.mass,
        "limits": [limit.row() for limit in result.limits],
        "page": None,
        "results": dict(result.own),
    }
    units = {"mass": "kg", **result.units}
    warnings = list(dict.fromkeys([*result.warnings, *given.warnings()]))
    if out is not None:
        from layerjam.studies.machines.page import write

        whole = {**values, "units": units, "warnings": warnings}
        values["page"] = str(write(result, whole, Path(out), force, say))
    return Answer(values=values, units=units, warnings=warnings, record=result)


def machines() -> list[str]:
    """Names of the scenarios that come with the program."""
    return scenarios()
