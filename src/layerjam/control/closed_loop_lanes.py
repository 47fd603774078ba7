"""The compiled closed loop: LANES runs step side by side, so that one instruction serves several.

Each loop over lanes is short, calls nothing and has no branch that LLVM cannot turn into a choice
between two numbers: it then becomes vector instructions, the control law included, which is
compiled from its own text. A lane's numbers lie LANES apart in one flat array, since a stride
known beforehand is what lets the compiler see that lanes do not touch each other. Nothing is
reordered and nothing contracted, so that a run has the same numbers in every lane. The vectors pay
where eight numbers fit (AVX-512): for four LLVM holds the law's many choices to be no gain, and
takes the lanes one after the other.
"""

from __future__ import annotations

import hashlib
import math
import types
from pathlib import Path
from typing import Any

import numba
import numpy as np

from layerjam.control import law
from layerjam.control.noise import LANES, key_of, normals

_INNER: dict[str, Any] = {"error_model": "numpy", "forceinline": True, "_nrt": False}
_PUMP, _VENT, _PUMP_SWITCHES, _VENT_SWITCHES, _FAULT = (LANES * k for k in (1, 2, 5, 6, 20))
(
    _VACUUM, _BEFORE, _SHOWN, _READING, _NOISE, _MISSED, _ON, _WHEN, _TOTAL, _LEAST, _MOST, _LOW,
    _HIGH, _OVER, _END,
) = range(21 * LANES, 36 * LANES, LANES)  # fmt: skip
"""Where a lane's numbers begin: after the law's state of 21 what the plant and the answer need."""
READS, STANDS, SHOWS = 0, 1, 2
"""What the sensor does: it reads, stands still, or shows a number of its own."""


def _law() -> Any:
    """`law.step` compiled, with the functions it calls; no rounding is changed."""
    names = {k: v for k, v in vars(law).items() if isinstance(v, int | float)}
    for name in ("moved", "switched", "safe", "command", "detect", "step"):
        code = getattr(law, name).__code__
        plain = types.FunctionType(code, names, name)
        names[name] = numba.njit(**_INNER)(plain)
    return names["step"]


compiled_step = _law()
"""The law's `step` for numba."""


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _taken(s, i):  # type: ignore[no-untyped-def]  # pragma: no cover
    """The law's state in lane i."""
    k = LANES
    return (
        (
            s[i], s[k + i], s[2 * k + i], s[3 * k + i], s[4 * k + i], s[5 * k + i], s[6 * k + i],
            s[7 * k + i],
        ),
        (
            s[8 * k + i], s[9 * k + i], s[10 * k + i], s[11 * k + i], s[12 * k + i],
            s[13 * k + i], s[14 * k + i], s[15 * k + i], s[16 * k + i], s[17 * k + i],
            s[18 * k + i], s[19 * k + i], s[20 * k + i],
        ),
    )  # fmt: skip


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _put(s, i, state):  # type: ignore[no-untyped-def]  # pragma: no cover
    """The law's state into lane i."""
    k = LANES
    (
        s[i], s[k + i], s[2 * k + i], s[3 * k + i], s[4 * k + i], s[5 * k + i], s[6 * k + i],
        s[7 * k + i],
    ) = state[0]  # fmt: skip
    (
        s[8 * k + i], s[9 * k + i], s[10 * k + i], s[11 * k + i], s[12 * k + i], s[13 * k + i],
        s[14 * k + i], s[15 * k + i], s[16 * k + i], s[17 * k + i], s[18 * k + i], s[19 * k + i],
        s[20 * k + i],
    ) = state[1]  # fmt: skip


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _decay(x):  # type: ignore[no-untyped-def]  # pragma: no cover
    """exp(-x) for x >= 0, to 3e-16, without a call: 2^-n exp(-r), |r| <= ln(2)/2."""
    n = np.rint(min(x, 700.0) * 1.4426950408889634)
    r = (n * 0.6931471803691238 - min(x, 700.0)) + n * 1.9082149292705877e-10
    square = r * r  # in pairs, which do not wait for one another
    fourth = square * square
    low = (1.0 + r) + square * (1.0 / 2.0 + r * (1.0 / 6.0))
    mid = (1.0 / 24.0 + r * (1.0 / 120.0)) + square * (1.0 / 720.0 + r * (1.0 / 5040.0))
    high = (1.0 / 40320.0 + r * (1.0 / 362880.0)) + square * (
        1.0 / 3628800.0 + r * (1.0 / 39916800.0) + square * (1.0 / 479001600.0)
    )
    power = np.int64((1023 - np.int64(n)) << 52).view(np.float64)
    return power * (low + fourth * (mid + fourth * high))


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _factors(plant, pump, vent, dt, lag, left):  # type: ignore[no-untyped-def]  # pragma: no cover
    """(slope's constant a, decay b, effect of a sample's first slope on v, on the sensor).

    The slope is a - b v; `left` is 1 - exp(-dt/lag).
    """
    rate, top, weight, leak, venting, back = plant
    a = rate * pump * top if pump > 0.0 else back * pump
    b = leak + rate * weight * max(pump, 0.0) + venting * vent
    x = b * dt
    square = x * x
    # (1 - exp(-x))/x; below 0.01, where a pump's sample lies, a series to the last digit
    series = (1.0 - 0.5 * x) + square * (
        (1.0 / 6.0 - x * (1.0 / 24.0)) + square * (1.0 / 120.0 - x * (1.0 / 720.0))
    )
    gain = dt * ((1.0 - _decay(x)) / x if x > 0.01 else series)
    ratio = dt / lag
    d = ratio - x
    near = abs(d) <= 1e-3
    phi = (1.0 - left) * ratio * (1.0 + d * (0.5 + d * (1.0 / 6.0 + d * (1.0 / 24.0))))
    flat = dt - lag * left
    close = (left - phi) / b if b > 0.0 else flat
    apart = (ratio * gain - dt * left) / d
    return a, b, gain, close if near else apart


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _read(s, sensor):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Readings of all lanes: offset, noise, range and steps."""
    highest, lowest, noise, step, steps, offset = sensor
    for i in range(LANES):
        y = s[_SHOWN + i] + offset + noise * s[_NOISE + i]
        if step > 0.0:
            y = np.rint(y * steps) * step
        s[_READING + i] = min(max(y, lowest), highest)


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _regulate(s, settings, target):  # type: ignore[no-untyped-def]  # pragma: no cover
    """One step of the law in all lanes."""
    for i in range(LANES):
        state, _pump, _vent, _code = compiled_step(settings, _taken(s, i), s[_READING + i], target)
        _put(s, i, state)


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _move(s, plant, most, dt, lag, left, now):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Plant and sensor of all lanes to the end of the sample that begins at `now`."""
    for i in range(LANES):
        pump, vent, v, shown = s[_PUMP + i], s[_VENT + i], s[_VACUUM + i], s[_SHOWN + i]
        a, b, gain, sensed = _factors(plant, pump, vent, dt, lag, left)
        slope = a - b * v
        after = min(v + slope * gain, most)
        s[_SHOWN + i] = shown + left * (v - shown) + slope * sensed if lag > 0.0 else after
        s[_VACUUM + i] = after
        s[_BEFORE + i] = v
        s[_ON + i] += abs(pump)
        when = s[_WHEN + i]
        s[_WHEN + i] = now if s[_FAULT + i] != 0.0 and when != when else when


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _gather(s, target):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Sums and extremes of the steady part."""
    for i in range(LANES):
        v = s[_VACUUM + i]
        s[_TOTAL + i] += v - target
        s[_LEAST + i] = min(s[_LEAST + i], v)
        s[_MOST + i] = max(s[_MOST + i], v)


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _rise(s, target, n):  # type: ignore[no-untyped-def]  # pragma: no cover
    """When 10 and 90 % of the first target are passed, in samples, and the overshoot."""
    for i in range(LANES):
        v, before, low, high = s[_VACUUM + i], s[_BEFORE + i], s[_LOW + i], s[_HIGH + i]
        s[_LOW + i] = (
            n + (0.1 * target - before) / (v - before) if low < 0.0 and v >= 0.1 * target else low
        )
        s[_HIGH + i] = (
            n + (0.9 * target - before) / (v - before) if high < 0.0 and v >= 0.9 * target else high
        )
        s[_OVER + i] = max(s[_OVER + i], v - target)


def _compiled(stamp: str) -> Any:
    """The loop of runs `first` to `first + LANES`; its cache is valid for this stamp only."""

    @numba.njit(cache=True, nogil=True, error_model="numpy")
    def many(  # type: ignore[no-untyped-def]
        first, seed, settings, fresh, plants, sensor, lag, dt, steps, ends, levels, onset,
        fails, wrong, steady, out, history,
    ):  # pragma: no cover  # fmt: skip
        len(stamp)
        period = ends[-1]
        left = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
        s, keys = np.zeros(_END), np.zeros(LANES, np.uint64)
        for i in range(LANES):
            keys[i] = key_of(seed, first + i)
            _put(s, i, fresh)
            s[_LOW + i] = s[_HIGH + i] = -1.0
            s[_LEAST + i], s[_MOST + i], s[_OVER + i] = math.inf, -math.inf, -math.inf
            s[_WHEN + i] = math.nan
        phase, stage, target = 0, 0, levels[0]
        for n in range(steps):
            broken = n >= onset
            does = fails if broken else READS
            if does == READS:
                if sensor[0][2] > 0.0:
                    normals(keys, n, s, _NOISE, _MISSED)
                _read(s, sensor[1] if broken else sensor[0])
            elif does == SHOWS:
                for i in range(LANES):
                    s[_READING + i] = wrong
            _regulate(s, settings, target)
            if len(history) > 0:
                history[n, 0], history[n, 1] = s[_VACUUM], s[_READING]
                history[n, 2], history[n, 3] = target, s[_PUMP]
                history[n, 4], history[n, 5] = s[_VENT], s[_FAULT]
            if n >= steady:
                _gather(s, target)
            _move(s, plants[1] if broken else plants[0], plants[0][1], dt, lag, left, n * dt)
            if n < ends[0]:
                _rise(s, target, n)
            phase += 1
            if phase >= ends[stage]:
                stage += 1
                if phase >= period:
                    phase, stage = 0, 0
                target = levels[stage]
        count = max(steps - steady, 1)
        for i in range(min(LANES, len(out) - first)):
            row = out[first + i]
            high, low = s[_HIGH + i], s[_LOW + i]
            row[0] = (high - low) * dt if high >= 0.0 else math.nan
            row[1], row[2] = s[_OVER + i], s[_TOTAL + i] / count
            row[3], row[4] = s[_MOST + i] - s[_LEAST + i], s[_ON + i] * dt
            row[5], row[6] = s[_PUMP_SWITCHES + i], s[_VENT_SWITCHES + i]
            row[7], row[8] = s[_FAULT + i], s[_WHEN + i]

    return many


_many: list[Any] = []


def loop() -> Any:
    """The compiled loop: some seconds when its files or the law have changed, else from cache."""
    if not _many:
        here = Path(__file__).parent
        files = (here / "law.py", here / "noise.py", here / "closed_loop_lanes.py")
        stamp = hashlib.sha256(b"".join(f.read_bytes() for f in files)).hexdigest()
        _many.append(_compiled(stamp))
    return _many[0]
