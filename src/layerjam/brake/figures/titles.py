"""Titles of figures: outcomes of stops and pulls in words."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from layerjam.brake.simulate.record import DropRecord, Outcome, TensileRecord
from layerjam.brake.simulate.stick_slip import StickSlipRecord
from layerjam.core.units import show

DROPS: Mapping[Outcome, str] = MappingProxyType(
    {
        Outcome.STOPPED: "stopped after {}",
        Outcome.NEVER_SLID: "stopped without slip",
        Outcome.BOTTOMED_OUT: "still moving at the end of the travel, {}",
        Outcome.SNAPS: "the brake snaps at a slip of {}",
        Outcome.CLOSED_BY_SLEEVE: "the enclosure pulls the brake back",
        Outcome.FINISHED: "still moving after {}",
    }
)
"""{outcome: words for it, given the slip}."""
PULLS: Mapping[Outcome, str] = MappingProxyType(
    {
        Outcome.FINISHED: "pulled to {}",
        Outcome.BOTTOMED_OUT: "travel used up at {}",
        Outcome.SEPARATED: "the sheets come apart at {}",
        Outcome.SNAPS: "the brake snaps at {}",
        Outcome.CLOSED_BY_SLEEVE: "the enclosure pulls the brake back",
        Outcome.STUCK: "the sheets never slide",
        Outcome.STEADY_SLIDING: "the sheets slide steadily",
        Outcome.JUDDERS: "the sheets stick and slip",
    }
)
"""{outcome: words for it, given the largest elongation}."""


def drop_title(record: DropRecord) -> str:
    """Return the title of a stop: ``Stop of 1 kg from 2.5 m/s: stopped after 40 mm``."""
    slip = show(float(np.max(record.slip)), "m", 3)
    start = f"Stop of {show(record.mass, 'kg')} from {show(record.speed, 'm/s')}"
    return f"{start}: {DROPS[record.outcome].format(slip)}"


def pull_title(name: str, outcome: Outcome, elongation: float) -> str:
    """Return the title of a pull of a brake `name` to an elongation [m]."""
    return f"{name}: {PULLS[outcome].format(show(elongation, 'm', 3))}"


def record_title(record: TensileRecord | StickSlipRecord) -> str:
    """Return the title of a simulated pull."""
    return pull_title(record.brake.name, record.outcome, float(np.max(record.elongation)))
