"""Outcomes of pulls as sentences; the pages' modules describe drops and controllers."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from layerjam.core.units import show


def describe_pull(result: Any) -> str:
    """Return the outcome of a pull, from a result with a record of elongation and force."""
    words = PULLS.get(result.outcome)
    if words is None:
        return f"The pull ended with {result.outcome}."
    return words(show(float(np.max(result.record.elongation)), "m"))


PULLS: Mapping[str, Callable[[str], str]] = {
    "FINISHED": lambda end: f"Pulled to {end}; the brake held together.",
    "SEPARATED": lambda end: f"The sheets came apart at {end}: the overlap was used up.",
    "SNAPS": lambda end: (
        f"The brake snaps at {end}: its force falls with slip faster than the "
        "pulling spring relaxes."
    ),
    "CLOSED_BY_SLEEVE": lambda _: (
        "During unloading, the enclosure pulled the brake back: friction no longer held it."
    ),
    "BOTTOMED_OUT": lambda end: f"Pulled to the end of the travel, {end}.",
}
"""{outcome: function that returns its sentence, given the travel}."""


def describe_stick_slip(slid: Any) -> str:
    """Return the outcome of a pull simulated over time, which may show stick–slip."""
    pace = show(slid.record.speed, "m/s")
    if slid.outcome == "JUDDERS":
        times = "once" if slid.events == 1 else f"{slid.events} times"
        return f"At {pace} the brake sticks and slips, {times} in this run."
    if slid.outcome == "STEADY_SLIDING":
        return f"At {pace} the brake slides steadily; no stick–slip remains."
    if slid.outcome == "STUCK":
        return "The sheets never slid: the pull ended before static friction was overcome."
    return f"At {pace} the pull ended before stick–slip or steady sliding was established."
