"""Records that stick and slip, from a truth: drawn teeth, and a sled on a spring in motion."""

from __future__ import annotations

import numpy as np

from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Trace

GRAVITY = 9.80665


def teeth(
    *, rows: int = 3000, spacing: float = 2e-3, swing: float = 0.2, middle: float = 0.6,
    noise: float = 0.0, uneven: float = 0.1, fall: float = 0.05, far: float = 0.06, seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """(position, force) of teeth that all rise at one slope and end at one level."""
    rng = np.random.default_rng(seed)
    slope = swing / (spacing * (1 - fall))
    at, x, y = -rng.uniform(0, spacing), [], []
    while at < far + spacing:
        tall = max(swing * (1 + uneven * rng.standard_normal()), 0.2 * swing)
        x += [at, at + tall / slope]
        y += [middle + swing / 2 - tall, middle + swing / 2]
        at += tall / slope + fall * spacing
    u = np.linspace(0, far, rows)
    return u, np.interp(u, x, y) + noise * rng.standard_normal(rows)


def sled(
    static: float, kinetic: float, *, normal: float = 2.45, spring: float = 300.0,
    speed: float = 2.5e-3, travel: float = 0.1, rate: float = 200.0, noise: float = 0.002,
    damping: float = 0.0, uneven: float = 0.0, dwell: float = 0.0, seed: int = 0,
) -> Trace:  # fmt: skip
    """A sled pulled over a film by a spring, its equation of motion integrated; a jump law."""
    rng = np.random.default_rng(seed)
    mass, step = normal / GRAVITY, 1e-4
    drag = 2 * damping * np.sqrt(spring * mass)
    count = int(travel / speed / step)
    shown = np.empty(count)
    x = v = 0.0
    stuck, holds = True, static * normal * (1 + uneven * rng.standard_normal())
    for i in range(count):
        pull = spring * (speed * i * step - x) + drag * (speed - v)
        shown[i] = pull
        if stuck and pull <= holds:
            continue
        stuck = False
        v += (pull - kinetic * normal) / mass * step
        if v <= 0:
            v, stuck = 0.0, True
            holds = static * normal * (1 + uneven * rng.standard_normal())
        x += v * step
    every = round(1 / rate / step)
    force = shown[::every]
    time = np.arange(len(force)) / rate
    rest = np.arange(round(dwell * rate)) / rate
    force = np.concatenate([np.zeros(len(rest)), force])
    elongation = np.concatenate([np.zeros(len(rest)), speed * time])
    clock = np.arange(len(force)) / rate
    force = force + noise * rng.standard_normal(len(force))
    facts = Facts(normal_force=normal, synthetic=True, seed=seed)
    return Trace(force, elongation, clock, "sled.csv", "made", facts=facts)
