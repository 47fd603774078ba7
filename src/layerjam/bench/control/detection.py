"""Longest detection times of faults, from noise-free trials of the law's detectors.

The pump runs at full command, and the fault begins at a given vacuum. The trials combine both ends
of the tolerances of the pump, the zero and the lag; the longest time is used. To allow for noise,
the limits are raised beforehand.
"""

import functools
import itertools
import math
from functools import partial

import numpy as np

from layerjam.bench.control import law
from layerjam.bench.control.engine import run_trial
from layerjam.bench.control.exact import Rates
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import LawSettings, Regulator
from layerjam.core.evolve import evolve

IN_NOISE = 5.0
"""Number of standard deviations by which noise may mislead a detector."""
WINDOW = 200
"""Trial steps in which a healthy pump rises by a decision step; fewer if samples are longer."""
SURE = 0.02
"""Relative margin on the limit that detects a blockage, and on the times of other faults."""
FINE = 0.01
"""Duration of a trial step, relative to the blocked line's time constant, if that exceeds a sample.
"""
BLOCKS = (1.0, 0.01)
"""Volumes left after a blockage, relative to the largest to detect: a tube can hide small ones."""
STARTS = 5
"""Number of vacuums, from zero to the requested one, at which a fault is tested."""
LONGEST = 20_000
"""Number of steps after which an unreported fault counts as undetected."""


def detection_times(regulator: Regulator, vacuum: float) -> dict[str, float]:
    """Return {fault: longest time [s] until it is reported} up to a vacuum [Pa].

    The times apply to every bench within the controller's tolerances; inf means that the fault is
    not detected at this vacuum. Those of NO_VACUUM, WEAK_PUMP (half of `weak_ratio` of the flow or
    less) and LINE_BLOCKED (at most 1/(2 blocked_ratio) of the chamber's volume) count from the
    onset of the fault. They require uninterrupted pumping at full command, even if the vent has
    just closed. A blockage is detected only if the vacuum rises further, so its time is inf near
    the pump's limit. The time of SENSOR_OFFSET, for at least twice the limit, counts from the
    opening of the vent, or from the fault if the vent is already open. The time of VACUUM_LOST
    counts from when the vacuum leaves the band below a target that it had reached. The time of
    SENSOR_STUCK applies to a noise-free sensor only while pumping at full command.
    """
    dt, lag = regulator.sample_time, regulator.longest_lag
    trials = _Trials(regulator)
    healthy_time = trials.longest_time(vacuum, FaultInjection(pump=0.0))
    stuck = max(regulator.samples(regulator.stuck_time), 50) * dt
    return {
        "NOT_A_NUMBER": dt,
        "SENSOR_OUT_OF_RANGE": (regulator.confirm + 1) * dt,
        "SENSOR_STUCK": stuck + dt if regulator.is_noisy else healthy_time,
        "SENSOR_OFFSET": regulator.settling_time + (regulator.confirm + 2) * dt + 8 * lag,
        "NO_VACUUM": healthy_time,
        "WEAK_PUMP": trials.longest_time(vacuum, FaultInjection(pump=regulator.weak_ratio / 2)),
        "LINE_BLOCKED": max(
            trials.longest_time(
                vacuum, FaultInjection(volume=share * 0.5 / regulator.blocked_ratio)
            )
            for share in BLOCKS
        ),
        "VACUUM_LOST": regulator.samples(regulator.loss_time) * dt
        + 2 * dt
        + 8 * regulator.total_lag,
    }


class _Trials:
    """Trials of one controller; its settings are packed once, and once for each longer step."""

    def __init__(self, regulator: Regulator) -> None:
        self.regulator = regulator
        self.watch = regulator.pack()[1]
        self.strict = functools.cache(partial(_tighten_limits, regulator))

    def longest_time(self, vacuum: float, fault: FaultInjection) -> float:
        """Return the longest detection time [s] of a fault at any reading up to a vacuum."""
        regulator = self.regulator
        starts = np.linspace(0.0, vacuum, STARTS).tolist()
        pump, zero = regulator.tolerances.pump, regulator.zero_error
        times = []
        for error in dict.fromkeys((-pump, pump)):
            plant = evolve(regulator.plant, rate=regulator.plant.rate * (1 + error))
            broken = fault, plant, fault.break_plant(plant)
            shifts = itertools.product((-zero, zero), (0.0, regulator.longest_lag))
            times += [
                self.detection_time(v, broken, ran, shift)
                for shift in dict.fromkeys(shifts)
                for v in starts
                for ran in (True, False)
            ]
        return max(times) + regulator.samples(regulator.vent_fade_time) * regulator.sample_time

    def detection_time(
        self,
        shows: float,
        broken: tuple[FaultInjection, Plant, Rates],
        ran: bool,
        shift: tuple[float, float],
    ) -> float:
        """Return the detection time [s] of a fault that starts at a reading [Pa].

        `broken` contains the fault, and the plant without and with it. `ran` states whether the
        pump was already running; `shift` contains the sensor's zero [Pa] and lag [s].
        """
        regulator, watch = self.regulator, self.watch
        dt, zero_error, (zero, lag) = regulator.sample_time, regulator.zero_error, shift
        fault, plant, rates = broken
        is_blocked, vacuum = fault.volume < 1, min(max(shows - zero, 0.0), plant.top)
        healthy_rise = (
            law.healthy_rise(1.0, shows + zero_error, watch[0], *watch[1:3], *watch[18:21]) / dt
        )
        loss = plant.leak * max(shows, 0.5 * plant.top)
        net = healthy_rise - loss
        if not net > loss:
            return math.inf
        slow_time = (
            FINE * fault.volume / plant.rate
            if is_blocked
            else regulator.detection_threshold / net / WINDOW
        )
        step = max(dt, slow_time)
        watch = self.strict(step)
        pump_pressure = vacuum
        if ran and plant.passage is not None:
            tube = plant.passage
            p, lowest = tube.atmosphere - vacuum, tube.atmosphere - plant.top
            pump_pressure = tube.atmosphere - float(tube.pump_pressure(p, plant.rate, lowest))
        memory, gauge = list(law.fresh()[1]), vacuum
        if ran:
            gauge -= lag * float(plant.rise(vacuum))
            memory[4] = law.healthy_rise(
                1.0, shows - zero_error, watch[0], *watch[1:3], *watch[18:21]
            )
        memory[0] = gauge + shows - vacuum
        vacuums, course = (vacuum, pump_pressure, gauge), (step, lag, LONGEST)
        count, code = run_trial(rates, watch, tuple(memory), vacuums, course, shows - vacuum)
        if not count or (code == law.BLOCKED) != is_blocked:
            return math.inf
        took = count * step + (step if step > dt else 0.0)
        return float((1.0 if is_blocked else 1 + SURE) * took + 2 * dt)


def _tighten_limits(regulator: Regulator, step: float) -> tuple[float, ...]:
    """Return the detectors' settings for samples of `step` [s], with noise added to the limits."""
    settings: LawSettings = evolve(regulator, sample_time=step).pack()
    watch = list(settings[1])
    noise = IN_NOISE * regulator.greatest_noise + regulator.sensor.resolution
    watch[5], watch[6], watch[14] = -math.inf, math.inf, math.inf
    watch[8] += noise / regulator.weak_ratio
    watch[22] = (1 + SURE) * watch[22] + noise
    return tuple(watch)
