"""A regulator's plant from one recorded step: the pump at full command from rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from layerjam.commands.answer import Quantity
from layerjam.commands.pressure_log import read_pressure, window
from layerjam.control.plant import Plant
from layerjam.control.settings import Regulator
from layerjam.control.tuning import Identified, identify_air, identify_water
from layerjam.errors import FitError
from layerjam.units import show

FAR_OFF = 1.2
"""Ratio of rates found and expected beyond which the difference is said."""


@dataclass(frozen=True)
class Recorded:
    """Where a step stands and what of it counts; quantities as the command line has them."""

    file: str | Path
    reading: str | None = None
    start: Quantity | None = None
    end: Quantity | None = None


def tuned_by(
    regulator: Regulator, step: Recorded, *, atmosphere: float, keep_noise: bool
) -> tuple[Regulator, Identified, list[str]]:
    """The regulator with the plant that a step shows; leak and vent stay the line's.

    The scatter of the readings about the fit becomes the sensor's noise unless `keep_noise`. Raises
    FileError for a log that cannot be read, FitError where it holds no step.
    """
    log, absolute, _, _, said = read_pressure(step.file, step.reading, atmosphere)
    first, last = window(step.start, step.end)
    time = log["time"]
    inside = np.ones(len(time), bool)
    if first is not None:
        inside &= time >= first
    if last is not None:
        inside &= time <= last
    if inside.sum() < 20:
        raise FitError(f"{log.name}: {int(inside.sum())} samples between --from and --to")
    time, vacuum = time[inside], atmosphere - absolute[inside]
    old: Plant = regulator.plant
    try:
        found = (
            identify_water(time, vacuum, vent=old.vent, top=old.top, leak=old.leak)
            if old.water
            else identify_air(time, vacuum, vent=old.vent, leak=old.leak, atmosphere=atmosphere)
        )
    except FitError as err:
        raise FitError(
            f"{log.name}: {err}; a step is the pump at full command from rest (--from, --to), its "
            "pressure read as --reading says"
        ) from None
    said += list(found.warnings)
    plant = replace(found.plant, backwards=old.backwards)
    ratio = plant.rate / old.rate
    if not 1 / FAR_OFF < ratio < FAR_OFF:
        said.append(
            f"the step's rate of {show(plant.rate, '1/s')} is {ratio:.3g} times that of the line's "
            f"file, {show(old.rate, '1/s')}; the step counts"
        )
    said.append(f"tuned to the step in {log.name}; leak and vent are those of the line's file")
    sensor = regulator.sensor if keep_noise else replace(regulator.sensor, noise=found.noise)
    return replace(regulator, plant=plant, sensor=sensor), found, said
