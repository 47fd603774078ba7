"""The machines by name, and the scenarios that come with them."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from importlib.resources import files
from pathlib import Path

from layerjam.design.machines import ankle_clutch, neck_guard, rehabilitation, seat_belt
from layerjam.design.machines.scenario import Kind, Scenario, read_scenario
from layerjam.design.machines.verdict import Result
from layerjam.device.toml import read_text
from layerjam.errors import UnknownNameError

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


@cache
def _texts() -> dict[str, str]:
    place = files("layerjam.design") / "scenarios"
    return {
        f.name.removesuffix(".toml"): f.read_text(encoding="utf-8")
        for f in sorted(place.iterdir(), key=lambda f: f.name)
        if f.name.endswith(".toml")
    }


def scenarios() -> list[str]:
    """Names of the scenarios that come with the program."""
    return list(_texts())


def load_scenario(scenario: str | Path) -> Scenario:
    """A scenario by name, or from the path of its TOML file.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    name, texts = str(scenario), _texts()
    if name in texts:
        return read_scenario(texts[name], name, KINDS)
    looks_like_path = name.endswith(".toml") or os.sep in name
    if not looks_like_path and not Path(name[:200]).is_file():
        raise UnknownNameError("scenario", name, texts)
    path = Path(name)
    return read_scenario(read_text(path), name, KINDS, path.parent)


def analyse(scenario: Scenario) -> Result:
    """The machine's answer."""
    return _ANALYSE[scenario.machine](scenario)
