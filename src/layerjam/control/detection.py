"""How long a fault may go unsaid: the law's own detectors, tried on the broken plant without noise.

The pump runs at full command, the fault begins at a vacuum, and the detector has just begun to
count, or is about to judge what it counted before: of these phases the latest is taken. The
noise's share is put on the limits beforehand.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numba
import numpy as np

from layerjam.control import law
from layerjam.control.closed_loop_run import compiled_detect, factors
from layerjam.control.faults import FaultInjection
from layerjam.control.settings import Packed, Regulator
from layerjam.control.through_tube import advanced
from layerjam.mechanics.compiled import stamp_of
from layerjam.mechanics.threads import once

IN_NOISE = 5.0
"""Standard deviations of a reading by which noise may put off a detector."""
WINDOW = 200
"""Steps of a trial, at least, in which a healthy pump owes one decision step."""
SURE = 0.02
"""Share by which a block's limit is raised in its trial, and the time of another fault."""
FINE = 0.01
"""Share of the blocked line's time constant that a step of its trial lasts, if that is more than a
sample."""
STARTS = 5
"""Vacuums, from none to the one asked for, at which a fault is tried."""
PHASES = 8
"""Of the decision that a fault of the pump begins in."""
LONGEST = 20_000
"""Steps after which a fault that has not been said counts as not seen."""


def detection_times(regulator: Regulator, vacuum: float) -> dict[str, float]:
    """{fault: worst time [s] until the regulator answers it} at a vacuum [Pa] or below.

    For NO_VACUUM, WEAK_PUMP (half of `weak_ratio` of the flow or less) and LINE_BLOCKED (a volume
    of 1/(2 blocked_ratio) of the chamber's or less): of uninterrupted pumping at full command from
    the fault on. A block needs room to rise: inf where the pump's vacuum is too near.
    SENSOR_OFFSET, for twice the limit or more: with the vent open, from its opening or from the
    fault. VACUUM_LOST: from where the vacuum leaves the band below a target once reached.
    SENSOR_STUCK: of a noisy sensor always; of one without noise, of full pumping. inf: not seen at
    this vacuum.
    """
    dt, lag = regulator.sample_time, regulator.sensor.lag
    none = _worst(regulator, vacuum, FaultInjection(pump=0.0))
    stuck = max(regulator.samples(regulator.stuck_time), 50) * dt
    return {
        "NOT_A_NUMBER": dt,
        "SENSOR_OUT_OF_RANGE": (regulator.confirm + 1) * dt,
        "SENSOR_STUCK": stuck + dt if regulator.noisy else none,
        "SENSOR_OFFSET": regulator.settles_in + (regulator.confirm + 2) * dt + 8 * lag,
        "NO_VACUUM": none,
        "WEAK_PUMP": _worst(regulator, vacuum, FaultInjection(pump=regulator.weak_ratio / 2)),
        "LINE_BLOCKED": _worst(
            regulator, vacuum, FaultInjection(volume=0.5 / regulator.blocked_ratio)
        ),
        "VACUUM_LOST": regulator.samples(regulator.lost_for) * dt + 2 * dt + 8 * regulator.lag,
    }


def _worst(regulator: Regulator, vacuum: float, injected: FaultInjection) -> float:
    """Longest time [s] until a fault is said that begins at any vacuum up to one [Pa]."""
    starts = np.linspace(0.0, vacuum, STARTS).tolist()
    return max(_said(regulator, v, injected, begun) for v in starts for begun in (True, False))


def _said(regulator: Regulator, vacuum: float, injected: FaultInjection, begun: bool) -> float:
    """Time [s] until a fault is said that begins at a vacuum [Pa]; `begun`: the pump ran."""
    plant, dt, owed = regulator.plant, regulator.sample_time, regulator.owed
    blocked, gives = injected.volume < 1, float(owed.at(vacuum))
    net = gives - plant.leak * vacuum
    if not net > plant.leak * vacuum:
        return math.inf
    long = FINE * injected.volume / plant.rate if blocked else regulator.decision / net / WINDOW
    step = max(dt, long)
    watch = _strict(regulator, step)
    side = vacuum
    if begun and plant.passage is not None:
        tube = plant.passage
        p, lowest = tube.atmosphere - vacuum, tube.atmosphere - plant.top
        side = tube.atmosphere - float(tube.side(p, plant.rate, lowest))
    shown = vacuum - (regulator.sensor.lag * net if begun else 0.0)
    seen, worst = list(law.fresh()[1]), 0
    seen[0] = shown
    for phase in range(PHASES if begun and not blocked else 1):
        if begun:  # what has risen lets the decision pass that the fault begins in
            seen[4], seen[6] = gives * step, regulator.decision
            seen[5] = regulator.decision * phase / PHASES
        count, code = _trial()(
            injected.on(plant),
            watch,
            tuple(seen),
            law.fresh()[0],
            (vacuum, side, shown),
            (step, regulator.sensor.lag, LONGEST),
        )
        if not count or (code == law.BLOCKED) != blocked:
            return math.inf
        worst = max(worst, count)
    took = worst * step + (step if step > dt else 0.0)
    return float((1.0 if blocked else 1 + SURE) * took + 2 * dt)


def _strict(regulator: Regulator, step: float) -> tuple[float, ...]:
    """The detectors' settings at a sample of length `step` [s], their limits off by the noise."""
    packed: Packed = replace(regulator, sample_time=step).packed()
    sensor, watch = regulator.sensor, list(packed[1])
    noise = IN_NOISE * sensor.noise + sensor.resolution
    watch[5], watch[6], watch[14] = -math.inf, math.inf, math.inf
    watch[9] -= noise / regulator.decision
    watch[10] -= noise / regulator.decision
    watch[22] = (1 + SURE) * watch[22] + noise
    return tuple(watch)


@once
def _trial() -> Any:
    """The compiled trial: full pump on the broken plant, the number of steps until a fault."""
    here = Path(__file__).parent
    names = ("law.py", "detection.py", "exact.py", "closed_loop_run.py", "through_tube.py")
    stamp = stamp_of(here / name for name in names)

    @numba.njit(cache=True, error_model="numpy")
    def run(plant, watch, seen, drive, begin, course):  # type: ignore[no-untyped-def]  # pragma: no cover
        len(stamp)
        vacuum, side, shown = begin
        dt, lag, steps = course
        drive = (drive[0], 1.0, 0.0, drive[3], drive[4], drive[5], drive[6], drive[7])
        left = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
        a, b, gain, sensed = factors(plant, 1.0, 0.0, dt, lag, left)
        if plant.side > 0.0:
            b -= plant.leak
        for n in range(steps):
            if plant.side > 0.0:
                vacuum, side, shown = advanced(vacuum, side, shown, a, b, plant, dt, lag)
            else:
                slope = a - b * vacuum
                after = vacuum + slope * gain
                if after > plant.top:
                    after, slope = plant.top, (plant.top - vacuum) / gain
                shown = shown + left * (vacuum - shown) + slope * sensed if lag > 0.0 else after
                vacuum = after
            fault, _, seen = compiled_detect(watch, seen, drive, shown, 0.0)
            if fault != 0.0:
                return n + 1, fault
        return 0, 0.0

    return run
