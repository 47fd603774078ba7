"""The machines by name, and the scenarios that come with them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from layerjam.records.shipped import shipped, text_of
from layerjam.studies.machines import ankle_clutch, neck_guard, rehabilitation, seat_belt
from layerjam.studies.machines.scenario import Kind, Scenario, read_scenario
from layerjam.studies.machines.verdict import Result

KINDS: dict[str, Kind] = {
    "seat-belt": seat_belt.KIND,
    "neck-guard": neck_guard.KIND,
    "ankle-clutch": ankle_clutch.KIND,
    "rehabilitation": rehabilitation.KIND,
}
_ANALYSE: dict[str, Callable[[Scenario], Result]] = {
    "seat-belt": seat_belt.analyse,
    "neck-guard": neck_guard.analyse,
    "ankle-clutch": ankle_clutch.analyse,
    "rehabilitation": rehabilitation.analyse,
}


def _texts() -> dict[str, str]:
    return shipped("layerjam.studies.machines", "scenarios")


def scenarios() -> list[str]:
    """Names of the scenarios that come with the program."""
    return list(_texts())


def load_scenario(scenario: str | Path) -> Scenario:
    """A scenario by name, or from the path of its TOML file.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    text, name = text_of("scenario", scenario, _texts())
    folder = None if name in _texts() else Path(name).parent
    return read_scenario(text, name, KINDS, folder)


def analyse(scenario: Scenario) -> Result:
    """The machine's answer."""
    return _ANALYSE[scenario.machine](scenario)
