"""Fig. 11, and possible causes of its difference from the model: filter and rope."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.stop.exact import STOPPED, stop
from layerjam.brake.mechanics.stop.tune import tuned_vacuum
from layerjam.brake.simulate.accelerometer import (
    ADXL193,
    CLASSES,
    cfc_filter,
    filter_memory,
    measure_acceleration,
)
from layerjam.brake.simulate.accelerometer import specific_force as specific_force_of
from layerjam.brake.simulate.drop import drop, series_spring
from layerjam.brake.simulate.record import DropRecord
from layerjam.core.threads import cache_threadsafe
from layerjam.core.units import show
from layerjam.studies.choi2018.claims import Claim, claim

MASS, SPEED, FASTEST, SLIP, FULL, G = 1.0, 2.5, 3.7, 0.040, 94.5e3, 9.80665
PAPER_TUNED, PAPER_FULL, PAPER_BARE = 2.0, 10.0, 50.0
"""Peaks [g] that the paper states for Fig. 11."""


def load_brake_and_rope() -> tuple[Brake, float]:
    """Return the paper's Kapton brake, and the rope stiffness [N/m] that its bare drop implies."""
    brake = load("choi2018-kapton").brake
    return brake, float(brake.rope.stiffness) if brake.rope is not None else np.inf


@cache_threadsafe
def simulate_stops() -> tuple[DropRecord, DropRecord]:
    """Return the paper's stops of 1 kg at 2.5 m/s: at full vacuum, and tuned to slip 40 mm."""
    brake, rope = load_brake_and_rope()
    vacuum = float(tuned_vacuum(MASS, SPEED, SLIP, series_spring(brake, rope), G, brake))
    file = load("choi2018-kapton")
    runs = [
        drop(file, mass=MASS, speed=SPEED, vacuum=p, rope_stiffness=rope)[1] for p in (FULL, vacuum)
    ]
    return runs[0], runs[1]


def bare_peak(rope: Any, speed: float) -> Any:
    """Return the unfiltered peak [g] of the mass on an undamped rope [N/m] alone."""
    return 1 + np.sqrt(1 + rope * speed**2 / (MASS * G**2))


def simulate_rope(rope: float, speed: float = FASTEST) -> tuple[np.ndarray, np.ndarray]:
    """Return time [s] and specific force [m/s^2] of the mass on the rope alone, while taut."""
    omega = np.sqrt(rope / MASS)
    swing = (bare_peak(rope, speed) - 1) * G
    angle = np.linspace(-1, 1, 2001) * np.arccos(-G / swing)
    return angle / omega, np.maximum(G + swing * np.cos(angle), 0.0)


def filtered_peak(signal: tuple[np.ndarray, np.ndarray], cutoff: float) -> float:
    """Return the peak [g] after a filter of the SAE J211-1 type with -3 dB at `cutoff` [Hz]."""
    time, value = signal
    # the pulses last tens of milliseconds, and the rate must also suit cutoffs below 25 Hz
    rate, margin = max(400 * cutoff, 20e3), filter_memory(0.6 * cutoff)
    count = int((time[-1] - time[0] + 2 * margin) * rate) + 1
    times = time[0] - margin + np.arange(count) / rate
    return float(cfc_filter(np.interp(times, time, value), rate, 0.6 * cutoff).max()) / G


@cache_threadsafe
def find_cutoffs() -> tuple[float, float]:
    """Return the cutoffs [Hz] at which the two stops peak at the paper's 10 g and 2 g."""
    full_force, tuned_force = (specific_force_of(run) for run in simulate_stops())
    return _find_cutoff(full_force, PAPER_FULL), _find_cutoff(tuned_force, PAPER_TUNED)


def _find_cutoff(signal: tuple[np.ndarray, np.ndarray], peak: float) -> float:
    """Return the cutoff [Hz] that gives a filtered peak of `peak` [g], which rises with it."""
    from scipy.optimize import brentq

    root = brentq(lambda x: filtered_peak(signal, float(np.exp(x))) - peak, *np.log([1, 300]))
    return float(np.exp(root))


def max_bare_reading(cutoff: float) -> float:
    """Return the highest filtered reading [g] of the mass that any rope stops from 3.7 m/s.

    An infinitely stiff rope reverses the mass instantly. The reading is then 2 v times the maximum
    of the filter's impulse response, which is pi fc/(sqrt(2) (sqrt(2) - 1)^(1/4)). With softer
    ropes, gravity also acts during the reversal.
    """
    stiff = 2 * FASTEST * np.pi * cutoff / (np.sqrt(2) * (np.sqrt(2) - 1) ** 0.25) / G
    ropes = np.geomspace(1e3, 1e6, 13)
    return max(stiff, *(filtered_peak(simulate_rope(float(k)), cutoff) for k in ropes))


@dataclass(frozen=True, kw_only=True)
class RopeStudy:
    """Peaks [g] of the stop versus rope stiffness [N/m], shape (N,); NaN without such a stop.

    `tuned` is at the vacuum for 40 mm of slip, if the brake slips at all, `full` is at 94.5 kPa,
    and `bare` is without a brake. The speed is 2.5 m/s.
    """

    rope: np.ndarray
    tuned: np.ndarray
    full: np.ndarray
    bare: np.ndarray


@cache_threadsafe
def study_ropes(points: int = 400) -> RopeStudy:
    """Compute the unfiltered peaks for ropes from 10 N/m to 1 MN/m."""
    brake, _ = load_brake_and_rope()
    rope = np.geomspace(10, 1e6, points)
    brake_spring = series_spring(brake, None)
    spring = 1 / (1 / brake_spring + 1 / rope)
    vacuum = np.asarray(tuned_vacuum(MASS, SPEED, SLIP, spring, G, brake))
    pressure = np.where(np.isfinite(vacuum), vacuum, 0.0)
    stops = stop(MASS, SPEED, pressure, spring, G, brake)
    slips = np.isfinite(vacuum) & (np.asarray(stops.outcome) == STOPPED)
    # an array, so that `stop` is compiled once for both
    hard = stop(MASS, SPEED, np.full_like(pressure, FULL), spring, G, brake)
    return RopeStudy(
        rope=rope,
        tuned=np.where(slips, np.asarray(stops.peak_force), np.nan) / (MASS * G),
        full=np.asarray(hard.peak_force) / (MASS * G),
        bare=bare_peak(rope, SPEED),
    )


def claims() -> list[Claim]:
    """Return the claims about the peaks in Fig. 11, and the filter or rope that they require."""
    from scipy.optimize import brentq

    (full_stop, tuned_stop), study = simulate_stops(), study_ropes()
    peaks = [measure_acceleration(run, ADXL193).peak / G for run in (full_stop, tuned_stop)]
    signals = [specific_force_of(run) for run in (full_stop, tuned_stop)]
    largest_loss = max(
        measure_acceleration(run, ADXL193, c).loss
        for run in (full_stop, tuned_stop)
        for c in CLASSES
    )
    ten, two = find_cutoffs()
    # the rope for which `bare_peak` is 10 g at 2.5 m/s
    soft = ((PAPER_FULL - 1) ** 2 - 1) * MASS * G**2 / SPEED**2
    bare_texts = {"soft": show(soft, "N/m", 2), "bare": bare_peak(soft, FASTEST)}
    best = int(np.nanargmin(study.tuned))
    rope = {"best": study.tuned[best], "rope": show(float(study.rope[best]), "N/m", 2)}
    stop_length = SPEED**2 / (2 * G * (PAPER_TUNED - 1)) * 1e3
    # test whether one filter could have shown all three peaks
    max_reading = max_bare_reading(ten)
    min_cutoff = float(brentq(lambda x: max_bare_reading(x) - PAPER_BARE, 10, 60, rtol=1e-3))
    filtered_peaks = [filtered_peak(signal, min_cutoff) for signal in signals]
    is_one_filter = max_reading >= PAPER_BARE and abs(ten / two - 1) < 0.1
    return [
        claim("adxl-full", peaks[0], most=largest_loss, ten=ten, **bare_texts),
        claim("adxl-tuned", peaks[1], less=peaks[1] - 1, two=two, way=stop_length, **rope),
        claim(
            "one-chain",
            holds=is_one_filter,
            least=min_cutoff,
            ten=ten,
            most=max_reading,
            left=filtered_peaks,
        ),
    ]
