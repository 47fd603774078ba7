"""The machines by name, and the scenarios supplied with them."""

from pathlib import Path

from layerjam.core.toml_files.shipped import load_text, shipped_files
from layerjam.studies.machines.ankle_clutch import AnkleClutch
from layerjam.studies.machines.neck_guard import NeckGuard
from layerjam.studies.machines.rehabilitation import Rehabilitation
from layerjam.studies.machines.scenario import read_scenario
from layerjam.studies.machines.seat_belt import SeatBelt
from layerjam.studies.machines.verdict import Machine

MACHINES: dict[str, type[Machine]] = {
    "seat-belt": SeatBelt,
    "neck-guard": NeckGuard,
    "ankle-clutch": AnkleClutch,
    "rehabilitation": Rehabilitation,
}


def _read_scenario_texts() -> dict[str, str]:
    return shipped_files("layerjam.studies.machines", "scenarios")


def scenarios() -> list[str]:
    """Return the names of the scenarios supplied with the program."""
    return list(_read_scenario_texts())


def load_scenario(scenario: str | Path) -> Machine:
    """Return a scenario by name or path; raises FileError, or UnknownNameError with near names."""
    text, name = load_text("scenario", scenario, _read_scenario_texts())
    folder = None if name in _read_scenario_texts() else Path(name).parent
    return read_scenario(text, name, MACHINES, folder)
