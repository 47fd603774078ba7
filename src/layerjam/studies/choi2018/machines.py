"""Fig. 13 of the paper: its four proposed machines, each computed from an assumed scenario."""

from layerjam.mechanics.threads import cache_threadsafe
from layerjam.report import style
from layerjam.studies.choi2018.claims import Claim, claim
from layerjam.studies.machines import page
from layerjam.studies.machines.registry import load_scenario
from layerjam.studies.machines.verdict import Result

PICTURES = {
    "seat-belt": page.belt_over_displacement,
    "neck-guard": page.neck_in_time,
    "ankle-clutch": page.ankle_stride,
    "rehabilitation": page.exercise_in_time,
}


@cache_threadsafe
def _result(name: str) -> Result:
    return load_scenario(name).analyse()


def claims() -> list[Claim]:
    """Return the paper's proposals with our verdicts."""
    results = {name: _result(name) for name in PICTURES}
    words = {True: "feasible", False: "not as built"}
    return [claim(name, words[r.feasible], reason=r.reason) for name, r in results.items()]


def picture(name: str) -> style.Figure:
    """Return the figure of a machine for the paper's page."""
    return PICTURES[name](_result(name))
