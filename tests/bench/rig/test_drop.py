"""The drop rig on the virtual board: a known pulse comes back as it was, and goes to `crash`."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import layerjam.bench.rig
from layerjam.bench.control.settings import Regulator
from layerjam.bench.rig.driver import Bench
from layerjam.bench.rig.drop import CaptureError, arm, capture, collect, fall, prepare
from layerjam.bench.rig.virtual_plant import ACCELERATION_RANGE, GAIN, NOISE, ZERO
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError
from layerjam.laboratory.identify.logs.crash import reduce_crash
from layerjam.laboratory.measure.shots import Shot

G, PEAK, LONG, FLIGHT = 9.80665, 300.0, 0.03, 0.3


@pytest.fixture
def bench() -> Iterator[Bench]:
    with layerjam.bench.rig.open("sim:choi2018?speed=10&seed=3") as made:
        yield made


def pulse(bench: Bench, delay: float) -> None:
    """A free fall of 0.3 s, a half sine of 30 ms, rest."""
    plant = bench.plant
    assert plant is not None
    sine = np.linspace(0.0, LONG, 400)
    time = np.concatenate([[0.0, 1e-6, FLIGHT - 1e-6], FLIGHT + sine, [FLIGHT + LONG + 1e-6]])
    force = np.concatenate([[G, 0.0, 0.0], PEAK * np.sin(math.pi * sine / LONG), [G]])
    plant.accelerometer.set_force(plant.time + delay, time, force)


def test_a_known_pulse_comes_back(bench: Bench) -> None:
    """Peak, velocity change and duration against the half sine's own, within the noise."""
    shot = capture(bench, level=5.0, patience=20, ready=lambda: pulse(bench, 1.5))
    assert shot.synthetic and shot.rate == 8000 and len(shot.counts) == 4800
    assert (shot.zero, shot.gain, shot.range) == (ZERO, GAIN, ACCELERATION_RANGE)
    level = math.asin(5 * G / PEAK) * LONG / math.pi
    wanted = np.where(
        (shot.time > -level) & (shot.time < LONG - level),
        PEAK * np.sin(math.pi * np.clip(shot.time + level, 0, LONG) / LONG),
        np.where(shot.time < 0, 0.0, G),
    )
    off = shot.acceleration - wanted
    spread = GAIN * math.hypot(NOISE, math.sqrt(1 / 12))
    assert abs(np.std(off[:700]) / spread - 1) < 0.15
    assert abs(np.mean(off)) < 0.2 and np.max(np.abs(off)) < 6 * spread + PEAK * 2e-4 / LONG * 3
    found = reduce_crash(shot.time, shot.acceleration, cfc=180, limit=shot.range, falling=True)
    change = PEAK * LONG * 2 / math.pi - G * LONG
    assert found.velocity_change == pytest.approx(change, rel=0.02)
    assert np.abs(shot.acceleration).max() < shot.range
    again = Shot.from_rows(shot.row(), shot.parts()[::-1], synthetic=True)
    assert np.array_equal(again.counts, shot.counts)
    assert (again.row(), again.parts()) == (shot.row(), shot.parts())


def test_the_file_says_what_crash_says(
    bench: Bench, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pulse_at = 1.0
    shot = capture(bench, rate="4 kHz", after="0.3 s", ready=lambda: pulse(bench, pulse_at))
    file = shot.write(tmp_path / "drop.csv")
    assert main(["crash", str(file), "--falling", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    found = reduce_crash(shot.time, shot.acceleration, cfc=180, falling=True)
    assert said["peak"] == pytest.approx(found.peak, rel=1e-6)
    assert said["velocity_change"] == pytest.approx(found.velocity_change, rel=1e-4)
    assert said["sampling"] == pytest.approx(4000, rel=1e-6)


def test_beyond_its_range_the_sensor_is_at_its_end(bench: Bench) -> None:
    plant = bench.plant
    assert plant is not None
    prepare(bench, source="immediate", after=0.1)
    plant.accelerometer.set_force(plant.time, np.array([0.0, 1.0]), np.array([4000.0, 4000.0]))
    arm(bench)
    shot = collect(bench, 10)
    top = math.floor((ACCELERATION_RANGE / GAIN + ZERO) + 6 * NOISE)
    assert shot.counts.max() <= min(top, 4095)
    assert abs(np.mean(shot.acceleration) - ACCELERATION_RANGE) < 3 * GAIN * NOISE / math.sqrt(
        len(shot.counts)
    )


def test_nothing_comes_where_nothing_falls(bench: Bench) -> None:
    with pytest.raises(CaptureError, match="arm it"):
        collect(bench, 1)
    with pytest.raises(CaptureError, match="was not triggered"):
        capture(bench, patience=0.1)
    assert bench.ask("FETC:ACC:STAT?").startswith("IDLE")
    for wrong in ({"source": "luck"}, {"rate": 100}, {"before": "2 s"}, {"level": 0.1}):
        with pytest.raises(QuantityError):
            prepare(bench, **wrong)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_mass_falls_on_the_brake(bench: Bench) -> None:
    """1 kg at 2.5 m/s, at the vacuum that the board holds: what `drop` and `seen` say of it.

    The velocity that the record loses is that of the fall and of the weight meanwhile: from free
    fall to the standstill the impulse is M (v + g t), whatever the brake's law.
    """
    from layerjam.brake.device.load import load

    plant = bench.plant
    assert plant is not None
    file = load("choi2018-kapton")
    bench.safe_state, bench.vent_rest = "release", "open"
    made = plant.behind
    bench.regulator = Regulator(plant=made.plant, sensor=made.sensor, safe_state="release")
    bench.lease = 60.0
    prepare(bench, fall="50 ms")
    bench.target, bench.output = "80 kPa", True
    bench.wait(10, until=79.5e3)
    arm(bench)
    stop = fall(bench, file, mass=1.0, speed=2.5)
    shot = collect(bench, 30)
    assert bench.state == "RUN"
    assert stop.outcome.name == "STOPPED" and stop.peak_force == pytest.approx(149.0, rel=0.02)
    found = reduce_crash(shot.time, shot.acceleration, cfc=1000 if shot.rate >= 10e3 else 600)
    # the first peak is the taut brake; the sensor's low-pass and noise move it by a few percent
    assert found.peak == pytest.approx(stop.peak_force / 1.0, rel=0.08)
    still = shot.time[0] + (stop.time + (shot.before / shot.rate))
    rise = -found.velocity()[int(np.searchsorted(shot.time, 0.0)) - 8]
    impulse = found.velocity()[int(np.searchsorted(shot.time, stop.time))] + rise
    assert still > 0 and impulse == pytest.approx(2.5 + G * stop.time, rel=0.05)
