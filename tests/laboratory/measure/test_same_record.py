"""A record that was exported twice is known by its noise; repeats of one brake are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from counts import cases
from laboratory.campaigns import bench as virtual
from laboratory.measure.layouts import REAL
from layerjam.brake.device.load import load
from layerjam.laboratory.commands.calibration import calibrate
from layerjam.laboratory.measure.same_record import is_same_record
from layerjam.laboratory.measure.trace import Trace

BRAKE = "choi2018-kapton"
STROKES = REAL / "pneumatic_friction_leak" / "friction_Circle_1bar.csv"
RATES = (100.0, 1000.0)


@cache
def pull(seed: int, rate: float, noise: float = 0.15, spread: float = 0.01) -> Trace:
    """A pull of the brake as a machine records it; brakes scatter by `spread`."""
    factor = 0.875 * (1 + spread * np.random.default_rng(seed).standard_normal())
    machine = virtual.Machine(sampling_rate=rate, load_cell_noise=noise, seed=seed)
    brake = replace(load(BRAKE).brake, scale_factor=factor)
    return virtual.pull(brake, 94.5e3, 0.013, 0.04, machine, repeat=seed, name=BRAKE)


def export(trace: Trace, force: object, elongation: object, time: object) -> Trace:
    arrays = (np.asarray(a, dtype=float) for a in (force, elongation, time))
    return Trace(*arrays, "copy.csv", "another export")


def every(count: int, first: int = 0) -> Callable[[Trace], Trace]:
    def made(one: Trace) -> Trace:
        assert one.time is not None
        part = slice(first, None, count)
        return export(one, one.force[part], one.elongation[part], one.time[part])

    return made


def means(count: int) -> Callable[[Trace], Trace]:
    def made(one: Trace) -> Trace:
        whole = len(one) // count * count
        parts = (one.force, one.elongation, one.time)
        return export(one, *(np.reshape(a[:whole], (-1, count)).mean(axis=1) for a in parts))

    return made


def interpolated(share: float) -> Callable[[Trace], Trace]:
    def made(one: Trace) -> Trace:
        assert one.time is not None
        time = np.linspace(one.time[0], one.time[-1], int(share * len(one)))
        return export(
            one, *(np.interp(time, one.time, a) for a in (one.force, one.elongation)), time
        )

    return made


def filtered(one: Trace) -> Trace:
    """Decimated behind a low-pass, as SciPy does it."""
    assert one.time is not None
    force = signal.decimate(one.force, 2, ftype="fir")
    return export(one, force, one.elongation[::2], one.time[::2])


def rounded(digits: int) -> Callable[[Trace], Trace]:
    def made(one: Trace) -> Trace:
        return export(one, np.round(one.force, digits), np.round(one.elongation, 6), one.time)

    return made


def moved(one: Trace) -> Trace:
    """Another zero of time and elongation, and every second sample."""
    half = every(2, 1)(one)
    assert half.time is not None
    return replace(half, time=half.time + 7.5, elongation=half.elongation - half.elongation[0])


def without_time(one: Trace) -> Trace:
    return replace(every(2)(one), time=None)


EXPORTS = {
    "the same": every(1),
    **{f"every {n}": every(n) for n in (2, 3, 4, 5)},
    **{f"every {n}, later": every(n, n - 1) for n in (2, 3, 5)},
    **{f"means of {n}": means(n) for n in (2, 3, 4)},
    **{
        f"interpolated to {share}": interpolated(share) for share in (0.37, 0.5, 0.9, 1.3, 2.0, 3.1)
    },
    "filtered": filtered,
    **{f"{n} digits": rounded(n) for n in (2, 3)},
    "moved": moved,
    "without time": without_time,
}


@pytest.mark.parametrize("how", EXPORTS)
def test_a_record_exported_twice_is_known(how: str) -> None:
    for rate in RATES:
        for seed in (1, 2):
            one = pull(seed, rate)
            copy = EXPORTS[how](one)
            assert is_same_record(one, copy) and is_same_record(copy, one), rate


@pytest.mark.parametrize("spread", [0.0, 0.01])
@pytest.mark.parametrize("rate", RATES)
def test_repeats_are_not_one_record(rate: float, spread: float) -> None:
    repeats = [pull(seed, rate, spread=spread) for seed in range(8)]
    copies = [every(2)(one) for one in repeats]
    for number, one in enumerate(repeats):
        for other in (*repeats[:number], *copies[:number]):
            assert not is_same_record(one, other)


def test_curves_without_noise_are_not_called_one_record() -> None:
    one = pull(1, 100.0, noise=0.0)
    assert not is_same_record(one, every(2)(one))


@pytest.mark.parametrize("seed", range(3))
def test_a_copy_is_known_although_every_second_sample_meets_a_pulse(seed: int) -> None:
    """The machine records at 2 kHz, with 50 pulses a second from a fifth of the record on; the
    copy, at 100 Hz, has means without the pulses."""
    clean = 20 + np.random.default_rng(seed).standard_normal(20 * 300 + 1)
    time = np.arange(len(clean)) / 2e3
    pulses = (np.arange(len(clean)) % 40 == 0) & (time > 0.2 * time[-1])
    window = np.r_[0.5, np.ones(19), 0.5] / 20
    copied = np.convolve(np.pad(clean, 10, mode="edge"), window, "valid")[::20]
    record = Trace(clean + 4 * pulses, 1e-3 * time, time, "pull.csv", "a machine's")
    copy = export(record, copied, 1e-3 * time[::20], time[::20])
    assert is_same_record(record, copy)


@pytest.mark.parametrize("seed", range(5))
def test_repeats_that_waver_alike_over_many_samples_are_not_one_record(seed: int) -> None:
    """A wave of 14 samples bends 16 times as much, squared, over two samples as over one: it is
    most of the second difference there, and less than the noise between neighbours."""
    random, number = np.random.default_rng(seed), np.arange(40)
    curve = 10 + 8 * np.sin(2 * np.pi * number / 14)
    one, other = (
        Trace(curve + random.standard_normal(40), 1e-4 * number, 0.1 * number, "pull.csv", "a")
        for _ in range(2)
    )
    assert not is_same_record(one, other)


@pytest.mark.slow
def test_false_alarms_among_thousands_of_pairs() -> None:
    """None among 3 x 780 pairs: at most 0.13 % at 95 % confidence (rule of three)."""
    count = cases(40, 24)
    for rate, noise, spread in ((50.0, 0.3, 0.0), (100.0, 0.05, 0.003), (1000.0, 0.15, 0.0)):
        repeats = [pull(seed, rate, noise, spread) for seed in range(count)]
        pairs = [(a, b) for n, a in enumerate(repeats) for b in repeats[:n]]
        assert len(pairs) == count * (count - 1) // 2
        assert sum(is_same_record(a, b) for a, b in pairs) == 0


@pytest.mark.skipif(not STROKES.is_file(), reason="real measurements are not part of the project")
def test_real_strokes_over_one_surface_are_not_one_record() -> None:
    """Strokes of a printed actuator: friction repeats with the place, as ridges of a print do."""
    data = np.genfromtxt(STROKES, delimiter="\t")
    clock, place, force = data[:, 0] * 1e-3, data[:, 4] * 1e-3, data[:, 6]
    above = place > (place.min() + place.max()) / 2
    turns = np.flatnonzero(np.diff(above.astype(int)))
    ends = [0, *((turns[1:] + turns[:-1]) // 2), len(place) - 1]
    strokes: dict[bool, list[Trace]] = {True: [], False: []}
    for start, end in pairwise(ends):
        if end - start > 60:
            away = place[end] > place[start]
            part, sign = slice(start, end), 1 if away else -1
            way = np.maximum.accumulate(sign * place[part])
            strokes[bool(away)].append(Trace(force[part], way, clock[part], "stroke", "real"))
    count = 0
    for same_way in strokes.values():
        for number, one in enumerate(same_way):
            assert is_same_record(one, every(2)(one))
            for other in same_way[:number]:
                assert not is_same_record(one, other)
                count += 1
    assert count > 90


def test_a_pull_exported_twice_counts_once(tmp_path: Path) -> None:
    pulls = [pull(seed, 100.0) for seed in range(3)]
    files = []
    for number, one in enumerate(pulls):
        files.append(virtual.write_bluehill(one, tmp_path / f"pull-{number}.csv"))
    alone = calibrate(BRAKE, files)
    for how in ("every 2", "2 digits"):
        copy = EXPORTS[how](pulls[1])
        assert copy.time is not None
        table = np.column_stack([copy.time, copy.elongation * 1e3, copy.force / 1e3])
        path = tmp_path / f"{how}.txt"
        head = "Time (s);Extension (mm);Load (kN)"
        np.savetxt(path, table, "%.9g", ";", header=head, comments="")
        found = calibrate(BRAKE, [*files, path], vacuum="94.5 kPa")
        assert list(found.refused) == [str(path)] and found.exit_code == 3
        assert f"same record as {files[1]}" in found.refused[str(path)]
        assert found.scale_factor == alone.scale_factor
