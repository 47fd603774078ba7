"""Accelerometer and CFC filter: responses in closed form, ends, range, what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal as reference

from layerjam.brake.device.load import load
from layerjam.brake.simulate.accelerometer import (
    ADXL193,
    CLASSES,
    FINE,
    IDEAL,
    Accelerometer,
    cfc_coefficients,
    cfc_filter,
    filter_memory,
    find_accelerometer,
    low_pass,
    lowpass_poles,
    measure_acceleration,
    specific_force,
)
from layerjam.brake.simulate.drop import drop
from layerjam.brake.simulate.record import DropRecord, Outcome
from layerjam.core.errors import QuantityError, UnknownNameError

G = 9.80665
KAPTON = load("choi2018-kapton")
seeds = st.integers(0, 2**32 - 1)


def stop(**how: float) -> DropRecord:
    case = {"mass": 1.0, "speed": 2.5, "vacuum": 94.5e3, "rope_stiffness": 16.8e3} | how
    return drop(KAPTON, **case)[1]


def gain(cfc: float, rate: float, frequency: float) -> complex:
    """Complex gain of `cfc_filter` at a frequency, from a long sine; its middle is settled."""
    room = int(rate * (filter_memory(cfc) + 5 / frequency)) + 1
    time = (np.arange(2 * room) - room) / rate
    shown = cfc_filter(np.exp(2j * np.pi * frequency * time).real, rate, cfc)
    quadrature = cfc_filter(np.exp(2j * np.pi * frequency * time).imag, rate, cfc)
    return complex(shown[room], quadrature[room])


# --- the filter of SAE J211-1


@pytest.mark.parametrize("cfc", CLASSES)
@pytest.mark.parametrize("factor", [10, 37.3, 500])
def test_its_coefficients_are_those_of_a_prewarped_butterworth(cfc: int, factor: float) -> None:
    a, b = cfc_coefficients(cfc, factor * cfc)
    num, den = reference.butter(2, 2.0775 * cfc, fs=factor * cfc)
    np.testing.assert_allclose(a, num, rtol=1e-12)
    np.testing.assert_allclose(np.append(1, -b), den, rtol=1e-11)


@pytest.mark.parametrize("cfc", CLASSES)
@pytest.mark.parametrize("factor", [10, 100])
def test_gain_is_the_closed_form_and_the_phase_is_zero(cfc: int, factor: float) -> None:
    rate = factor * cfc
    for part in (0.05, 0.3, 1.0, 1 / 0.6, 3.0):
        warped = np.tan(np.pi * part / factor) / np.tan(np.pi * 2.0775 / factor)
        found = gain(cfc, rate, part * cfc)
        assert found.real == pytest.approx(1 / (1 + warped**4), abs=1e-9)
        assert found.imag == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("cfc", CLASSES)
@pytest.mark.parametrize("factor", [10, 100])
def test_corridor_of_the_standard(cfc: int, factor: float) -> None:
    """Within +0.5 and -1 dB up to the class, +0.5 and -4 dB at class/0.6, then down."""

    def decibel(part: float) -> float:
        return float(20 * np.log10(abs(gain(cfc, factor * cfc, part * cfc))))

    assert all(abs(decibel(part)) < 1e-3 for part in (0.02, 0.1, 0.2))
    assert -1 <= decibel(1.0) <= 0.5
    assert -4 <= decibel(1 / 0.6) <= 0.5
    assert decibel(4 / 0.6) < -40 if factor > 20 else True
    if factor == 100:
        assert decibel(1 / 0.6) == pytest.approx(-3.01, abs=0.02)


def test_the_factor_of_the_standard_puts_minus_3_db_at_the_class_over_0_6() -> None:
    assert (5 / 3) / (np.sqrt(2) - 1) ** 0.25 == pytest.approx(2.0775, abs=5e-5)


def test_step_response_in_closed_form() -> None:
    """1 - exp(-at) cos(at)/2 after the step, a = cutoff/sqrt(2), and its mirror image before."""
    errors = []
    for rate in (50e3, 200e3):
        count = int(0.1 * rate)
        time = (np.arange(-count, count) + 0.5) / rate
        shown = cfc_filter((time > 0).astype(float), rate, 180)
        a = 2 * np.pi * 2.0775 * 180 / np.sqrt(2)
        after = 1 - np.exp(-a * abs(time)) * np.cos(a * time) / 2
        errors.append(abs(shown - np.where(time > 0, after, 1 - after)).max())
    assert errors[1] < 1e-4
    assert np.log(errors[0] / errors[1]) / np.log(4) == pytest.approx(2, abs=0.1)


@given(seeds, st.sampled_from(CLASSES), st.floats(10, 300))
def test_reversed_in_time_it_is_the_same_filter(seed: int, cfc: int, factor: float) -> None:
    value = np.random.default_rng(seed).normal(size=400)
    value[:100] = value[300:] = 0
    room = np.zeros(int(factor * cfc * filter_memory(cfc)) + 1)
    value = np.concatenate([room, value, room])
    once = cfc_filter(value, factor * cfc, cfc)
    back = cfc_filter(value[::-1], factor * cfc, cfc)[::-1]
    np.testing.assert_allclose(back, once, atol=1e-10)
    # linear, and the area stays
    np.testing.assert_allclose(cfc_filter(-3 * value, factor * cfc, cfc), -3 * once, atol=1e-12)
    assert once.sum() == pytest.approx(value.sum(), abs=1e-8)


@pytest.mark.parametrize("cfc", CLASSES)
def test_ends_count_as_held_for_ever(cfc: int) -> None:
    """As scipy's filtfilt with the ends held long enough; a constant stays to the last digit."""
    rate = 20.0 * cfc
    value = np.cumsum(np.random.default_rng(3).normal(size=300)) + 5
    num, den = reference.butter(2, 2.0775 * cfc, fs=rate)
    room = int(rate * filter_memory(cfc)) + 1
    held = np.pad(value, room, "edge")
    expected = reference.filtfilt(num, den, held, padtype=None)[room:-room]
    np.testing.assert_allclose(cfc_filter(value, rate, cfc), expected, atol=1e-9)
    np.testing.assert_allclose(cfc_filter(np.full(50, 7.5), rate, cfc), 7.5, rtol=1e-11)


# --- the analogue low-pass


@pytest.mark.parametrize("kind", ["bessel", "butterworth"])
@pytest.mark.parametrize("order", [1, 2, 4, 8])
def test_low_pass_is_minus_3_db_at_its_bandwidth(kind: str, order: int) -> None:
    poles = lowpass_poles(kind, order, 400.0)
    response = np.prod(-poles) / np.prod(2j * np.pi * 400 - poles)
    assert abs(response) == pytest.approx(np.sqrt(0.5), rel=1e-9)
    assert (poles.real < 0).all() and len(poles) == order


def test_one_pole_follows_a_ramp_and_a_step_in_closed_form() -> None:
    poles, tau = lowpass_poles("bessel", 1, 100.0), 1 / (2 * np.pi * 100)
    ramp = low_pass(np.array([0.0, 1.0]), np.array([0.0, 1.0]), poles, -0.01, 1e4, 400)
    time = -0.01 + np.arange(400) / 1e4
    after = np.maximum(time, 0)
    expected = np.where(time > 0, after - tau * (1 - np.exp(-after / tau)), 0.0)
    np.testing.assert_allclose(ramp, expected, atol=1e-14)
    step = low_pass(np.array([-1e-13, 0.0]), np.array([0.0, 1.0]), poles, -0.01, 1e4, 400)
    np.testing.assert_allclose(step, np.where(time > 0, 1 - np.exp(-after / tau), 0.0), atol=1e-9)


def test_a_constant_stays_what_it_is_from_the_first_sample_on() -> None:
    time, value = np.array([0.0, 0.01]), np.array([9.8, 9.8])
    for order in (1, 2, 5):
        sensor = Accelerometer(bandwidth=30.0, order=order, sampling=5e3)
        np.testing.assert_allclose(
            measure_acceleration((time, value), sensor, 60).acceleration, 9.8, rtol=1e-10
        )


@pytest.mark.parametrize("kind", ["bessel", "butterworth"])
@pytest.mark.parametrize("order", [1, 2, 3, 6])
def test_low_pass_against_scipy(kind: str, order: int) -> None:
    """lsim takes straight lines between the samples of its grid, which holds all breakpoints."""
    rng = np.random.default_rng(5)
    grid = np.arange(4001) / 1e5
    corners = np.unique(np.append(rng.choice(4000, 60), [0, 4000]))
    value = np.cumsum(rng.normal(size=len(corners)))
    value[0] = 0
    poles = lowpass_poles(kind, order, 700.0)
    system = reference.ZerosPolesGain([], poles, np.prod(-poles).real)
    _, expected, _ = reference.lsim(system, np.interp(grid, grid[corners], value), grid)
    shown = low_pass(grid[corners], value, poles, 0.0, 1e4, 401)
    np.testing.assert_allclose(shown, expected[::10], atol=1e-8 * abs(value).max())


@given(seeds, st.integers(1, 8), st.sampled_from(["bessel", "butterworth"]))
def test_samples_are_those_of_the_exact_response_at_any_rate(
    seed: int, order: int, kind: str
) -> None:
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.exponential(1e-4, 80))
    value = rng.normal(size=80)
    poles = lowpass_poles(kind, order, float(np.exp(rng.uniform(np.log(5), np.log(2e4)))))
    coarse = low_pass(time, value, poles, 0.0, 3e3, 30)
    fine = low_pass(time, value, poles, 0.0, 36e3, 30 * 12)
    np.testing.assert_allclose(fine[::12], coarse, atol=1e-8)
    # points on the straight lines change nothing
    more = np.union1d(time, rng.uniform(time[0], time[-1], 50))
    again = low_pass(more, np.interp(more, time, value), poles, 0.0, 3e3, 30)
    np.testing.assert_allclose(again, coarse, atol=1e-8)


def test_brute_force_oversampling_converges_to_it_with_second_order() -> None:
    """Samples held straight on an ever finer grid that misses the kinks of a drop."""
    time, value = specific_force(stop())
    poles = lowpass_poles("bessel", 2, 400.0)
    exact = low_pass(time, value, poles, -0.01, 20e3, 1000)
    errors = []
    for rate in (20e3, 80e3, 320e3):
        grid = np.arange(-0.01 + 0.3 / rate, 0.045, 1 / rate)
        shown = low_pass(grid, np.interp(grid, time, value), poles, -0.01, 20e3, 1000)
        errors.append(abs(shown - exact).max())
    assert errors[-1] < 2e-4 * value.max()
    assert np.log(errors[0] / errors[2]) / np.log(16) == pytest.approx(2, abs=0.35)


# --- what is seen of a drop


def test_an_ideal_accelerometer_reads_the_peak_force_over_the_mass() -> None:
    record = stop()
    reading = measure_acceleration(record)
    assert reading.peak == record.force.max() == pytest.approx(175.925038, abs=5e-7)
    assert reading.peak / G == pytest.approx(17.94, abs=5e-3)
    assert reading.loss == 0 and not reading.saturated and reading.warnings == ()
    assert reading.time_of_peak == record.time[np.argmax(record.force)]
    assert reading.acceleration[0] == 0, "free fall"
    heavy = stop(mass=3.0, speed=1.0)
    assert measure_acceleration(heavy).peak == heavy.force.max() / 3.0


@pytest.mark.parametrize("gravity", [0.0, G])
@pytest.mark.parametrize("speed", [0.3, 1.0, 2.5])
def test_the_rebound_gives_back_what_spring_and_gravity_say(gravity: float, speed: float) -> None:
    """The area of the reading is the change of speed, down and up, and gravity's part of it."""
    record = stop(speed=speed, gravity=gravity)
    time, value = specific_force(record)
    force, spring = float(record.force[-1]), 1 / (1 / 131e3 + 1 / 16.8e3)
    leaves = np.sqrt(force**2 / spring - 2 * gravity * force / spring)
    area = np.trapezoid(value, time)
    assert value[-1] == pytest.approx(0, abs=1e-9)
    assert area == pytest.approx(speed + leaves + gravity * time[-1], rel=1e-4)
    if record.outcome is Outcome.NEVER_SLID:
        assert leaves == pytest.approx(speed, rel=1e-12)


def test_without_enough_to_fly_the_mass_swings_back_to_its_least_force() -> None:
    """A heavy mass, stopped just above its weight, hangs on after half a swing."""
    record = stop(mass=12.0, speed=0.2)
    time, value = specific_force(record)
    swing = record.force[-1] / 12 - G
    assert 0 < swing < G
    assert value[-1] == pytest.approx(G - swing, rel=1e-12)
    period = 2 * np.pi * np.sqrt(12 * (1 / 131e3 + 1 / 16.8e3))
    assert time[-1] - record.time[-1] == pytest.approx(period / 2, rel=1e-12)


def test_a_mass_still_moving_at_the_end_of_travel_is_not_continued() -> None:
    record = stop(speed=3.7)
    assert record.outcome is Outcome.BOTTOMED_OUT
    time, value = specific_force(record)
    assert time[-1] == record.time[-1] and value[-1] == record.force[-1]
    assert any("BOTTOMED_OUT" in w for w in measure_acceleration(record, ADXL193).warnings)


def test_a_rope_that_damps_or_a_vacuum_that_changes_is_not_continued_either() -> None:
    record = stop()
    rising = np.linspace(94.5e3, 95e3, len(record.time))
    for other in (replace(record, rope_damping=5.0), replace(record, vacuum_in_time=rising)):
        assert specific_force(other)[0][-1] == record.time[-1]
        says = f"ends under load (STOPPED, {record.force[-1]:.4g} N)"
        assert any(says in w for w in measure_acceleration(other).warnings)
    hanging = replace(record, rope_damping=5.0, force=np.append(record.force[:-1], G))
    assert measure_acceleration(hanging).warnings == ()


def test_a_pull_that_begins_at_once_begins_from_free_fall() -> None:
    """A damped rope pulls with damping times speed from the first instant."""
    record = stop()
    jumps = replace(record, rope_damping=5.0, force=record.force + 12.5)
    time, value = specific_force(jumps)
    assert time[0] < 0 == value[0] and value[1] == 12.5
    assert measure_acceleration(jumps, ADXL193).acceleration[0] == 0
    assert measure_acceleration(jumps, IDEAL, 60).acceleration[0] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("cfc", [None, *CLASSES])
@pytest.mark.parametrize("frequency", [20.0, 90.0])
def test_a_sine_of_known_amplitude(cfc: int | None, frequency: float) -> None:
    time = np.linspace(-1, 1, 100_001)
    wave = 3.0 * np.cos(2 * np.pi * frequency * time) * np.where(abs(time) < 0.9, 1.0, 0.0)
    sensor = Accelerometer(bandwidth=400.0, order=2, kind="butterworth", sampling=20e3)
    reading = measure_acceleration((time, wave), sensor, cfc)
    inside = abs(reading.time) < 0.6
    shown = abs(reading.acceleration[inside]).max()
    expected = 3.0 / np.sqrt(1 + (frequency / 400) ** 4)
    if cfc is not None:
        expected /= 1 + (frequency / (2.0775 * cfc)) ** 4
    assert shown == pytest.approx(expected, rel=3e-3)


def test_a_sensor_without_a_rate_is_looked_at_often_enough() -> None:
    record = stop()
    for sensor, cfc in ((Accelerometer(bandwidth=50.0), None), (IDEAL, 60), (IDEAL, 600)):
        usual = measure_acceleration(record, sensor, cfc)
        assert usual.rate >= FINE * 50
        often = measure_acceleration(record, replace(sensor, sampling=10 * usual.rate), cfc)
        assert usual.peak == pytest.approx(often.peak, rel=2e-4)


def test_a_lower_low_pass_takes_off_more_and_shows_it_later() -> None:
    record = stop()
    readings = [
        measure_acceleration(record, Accelerometer(bandwidth=f)) for f in (5e3, 400, 60, 10)
    ]
    assert np.all(np.diff([r.peak for r in readings]) < 0)
    assert np.all(np.diff([r.time_of_peak for r in readings]) > 0)
    assert [r.loss for r in readings] == [1 - r.peak / record.force.max() for r in readings]


@given(seeds, st.floats(-1e3, 1e3))
def test_readings_scale_with_the_signal_and_keep_its_sign(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    time, value = np.cumsum(rng.exponential(1e-3, 50)), rng.normal(size=50)
    sensor = Accelerometer(bandwidth=300.0, sampling=1e4)
    one, other = (
        measure_acceleration((time, value), sensor, 180),
        measure_acceleration((time, scale * value), sensor, 180),
    )
    np.testing.assert_allclose(other.acceleration, scale * one.acceleration, atol=1e-9)
    assert other.peak == pytest.approx(scale * one.peak, abs=1e-9)


# --- range, steps, noise


def test_saturation_is_said() -> None:
    record = stop()
    reading = measure_acceleration(record, replace(ADXL193, range=10 * G))
    assert reading.saturated and reading.peak == pytest.approx(10 * G)
    assert any("saturated" in w and "98.07 m/s^2" in w for w in reading.warnings)
    assert reading.acceleration.max() == pytest.approx(10 * G)
    filtered = measure_acceleration(record, replace(ADXL193, range=10 * G), 60)
    assert filtered.saturated and filtered.warnings
    assert not measure_acceleration(record, replace(ADXL193, range=18 * G)).saturated
    below = measure_acceleration(
        (np.array([0.0, 0.1]), np.array([0.0, -50.0])), Accelerometer(range=20.0)
    )
    assert below.saturated and below.peak == -20


def test_steps_and_noise_can_be_had_again() -> None:
    record = stop()
    stepped = measure_acceleration(record, replace(ADXL193, resolution=0.6 * G))
    steps = stepped.acceleration / (0.6 * G)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    clean = measure_acceleration(record, ADXL193)
    noisy = [measure_acceleration(record, replace(ADXL193, noise=2.0, seed=s)) for s in (1, 1, 2)]
    assert np.array_equal(noisy[0].acceleration, noisy[1].acceleration)
    assert not np.array_equal(noisy[0].acceleration, noisy[2].acceleration)
    assert np.std(noisy[2].acceleration - clean.acceleration) == pytest.approx(2.0, rel=0.1)
    assert np.array_equal(clean.acceleration, measure_acceleration(record, ADXL193).acceleration), (
        "none by default"
    )


def test_the_phase_of_the_clock_moves_the_samples() -> None:
    record = stop()
    half = measure_acceleration(record, replace(ADXL193, phase=0.5))
    step = 1 / ADXL193.sampling
    whole = (half.time / step) % 1
    np.testing.assert_allclose(whole, 0.5, atol=1e-6)


# --- refusals


@pytest.mark.parametrize("cfc", CLASSES)
def test_too_slow_a_rate_for_the_class_is_refused(cfc: int) -> None:
    record = stop()
    measure_acceleration(record, replace(IDEAL, sampling=10.0 * cfc), cfc)
    with pytest.raises(QuantityError, match=rf"too slow for CFC {cfc}.*{10 * cfc} Hz"):
        measure_acceleration(record, replace(IDEAL, sampling=9.99 * cfc), cfc)


def test_folding_is_said() -> None:
    reading = measure_acceleration(stop(), replace(ADXL193, sampling=500.0))
    assert any("alias" in w for w in reading.warnings)


@pytest.mark.parametrize("cfc", [0, -60, 100, 61, float("nan")])
def test_classes_that_the_standard_does_not_have(cfc: float) -> None:
    with pytest.raises(QuantityError, match="not an SAE J211-1 class"):
        measure_acceleration(stop(), IDEAL, cfc)


@pytest.mark.parametrize(
    ("how", "names"),
    [
        ({"range": 0.0}, "range"),
        ({"range": float("nan")}, "range"),
        ({"bandwidth": -1.0}, "bandwidth"),
        ({"order": 0}, "order"),
        ({"order": 9}, "order"),
        ({"order": 1.5}, "order"),
        ({"sampling": 0.0}, "sampling"),
        ({"phase": 1.5}, "phase"),
        ({"resolution": 0.0}, "resolution"),
        ({"resolution": 30.0, "range": 20.0}, "exceeds the range of"),
        ({"noise": -1.0}, "noise"),
        ({"noise": 1.0, "sampling": 1e4}, "seed"),
        ({"noise": 1.0, "seed": 1}, "sampling"),
        ({"noise": 1.0, "seed": -1, "sampling": 1e4}, "seed: -1"),
    ],
)
def test_sensors_that_cannot_be(how: dict[str, float], names: str) -> None:
    with pytest.raises(QuantityError, match=names):
        Accelerometer(**how)  # type: ignore[arg-type]


def test_names() -> None:
    assert find_accelerometer("ADXL193") is ADXL193 and find_accelerometer("ideal") is IDEAL
    with pytest.raises(UnknownNameError, match="adxl193"):
        find_accelerometer("adxl913")
    with pytest.raises(UnknownNameError, match="bessel"):
        Accelerometer(kind="besel")


@pytest.mark.parametrize(
    ("time", "value", "says"),
    [
        ([0.0, 1.0], [1.0], "same length"),
        ([0.0], [1.0], "at least two"),
        ([[0.0, 1.0]], [[1.0, 1.0]], "same length"),
        ([0.0, 0.0], [1.0, 2.0], "must increase"),
        ([1.0, 0.0], [1.0, 2.0], "must increase"),
        ([0.0, np.nan], [1.0, 2.0], "finite"),
        ([0.0, 1.0], [1.0, np.inf], "finite"),
    ],
)
def test_signals_that_are_none(time: list[float], value: list[float], says: str) -> None:
    with pytest.raises(QuantityError, match=says):
        measure_acceleration((time, value))


def test_a_rate_that_would_fill_the_memory_is_refused() -> None:
    with pytest.raises(QuantityError, match="use a lower rate"):
        measure_acceleration(
            (np.array([0.0, 100.0]), np.array([0.0, 1.0])), replace(IDEAL, sampling=1e6)
        )
    with pytest.raises(QuantityError, match="use a lower rate"):
        measure_acceleration((np.array([0.0, 1e300]), np.array([0.0, 1.0])), ADXL193)
