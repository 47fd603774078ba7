"""Friction tests by the standards: first maximum, travel of the mean, inertia, stick-slip."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import t as student

from laboratory.campaigns import bench as virtual
from laboratory.identify.saw import GRAVITY, sled
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.evidence import Evidence
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, FitError, UnknownNameError
from layerjam.laboratory.identify.friction.breakaway import find_breakaway, inertia_effect
from layerjam.laboratory.identify.friction.reduction import (
    add_friction,
    reduce_friction,
    reduce_repeat,
)
from layerjam.laboratory.identify.friction.standards import (
    D1894,
    ISO8295,
    PAPER,
    STANDARDS,
    find_standard,
)
from layerjam.laboratory.identify.material_evidence import make_friction_evidence
from layerjam.laboratory.identify.statistics import summarise_repeats
from layerjam.laboratory.measure.trace import Trace

NORMAL = 2.45
seeds = st.integers(0, 2**32 - 1)


def by_hand(static: float = 0.8, kinetic: float = 0.5, far: float = 0.15) -> Trace:
    """Peak at 2 mm, sliding from 2.1 mm on, a second and higher maximum at 100 mm; times 2 N."""
    u = np.arange(0, round(far * 1e4) + 1) * 1e-4
    force = np.where(u < 0.002, 2 * static * u / 0.002, 2 * kinetic)
    force[20] = 2 * static
    if far >= 0.1:
        bump = np.maximum(1 - np.abs(np.arange(len(u)) - 1000) / 30, 0)
        force += (4 * static - 2 * kinetic) * bump  # rises no faster than the string stretches
    return Trace(force, u, u / 2.5e-3, "hand.csv", "made")


def test_each_standard_reads_its_own_maximum_and_travel() -> None:
    trace = by_hand()
    paper = reduce_repeat(trace, 2.0)
    assert (paper.static, paper.window) == (1.6, (0.040, 0.100))
    for standard, run in ((D1894, 0.130), (ISO8295, 0.060)):
        found = reduce_repeat(trace, 2.0, None, standard)
        assert found.static == 0.8 and found.static_at == pytest.approx(0.002)
        assert found.window[0] == pytest.approx(0.0021)
        assert found.window[1] - found.window[0] == pytest.approx(run)
        assert found.distinct and found.teeth is None
    assert reduce_repeat(trace, 2.0, None, ISO8295).kinetic == pytest.approx(0.5, rel=1e-12)
    # the second maximum at 100 mm lies in the travel of the other two
    assert reduce_repeat(trace, 2.0, None, D1894).kinetic == pytest.approx(0.5 + 33 / 1301)


def test_a_record_shorter_than_the_standard_asks() -> None:
    some = reduce_repeat(by_hand(far=0.105), 2.0, None, D1894)
    assert some.window == (pytest.approx(0.0021), pytest.approx(0.105))
    assert any("102.9 mm of sliding; ASTM D1894 requires 130 mm" in w for w in some.warnings)
    with pytest.raises(FileError, match=r"slide over only 57\.9 mm; ASTM D1894 .*--from and --to"):
        reduce_repeat(by_hand(far=0.06), 2.0, None, D1894)
    whole = reduce_repeat(by_hand(far=0.130), 2.0, None, D1894)
    assert not any("sliding" in w for w in whole.warnings)
    asked = reduce_repeat(by_hand(far=0.06), 2.0, (0.02, 0.05), D1894)
    assert asked.window == (0.02, 0.05) and asked.kinetic == pytest.approx(0.5)


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_the_first_maximum_in_noise(seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinetic = rng.uniform(0.05, 0.5)
    static = kinetic * rng.uniform(1.15, 2.0)
    noise = 10 ** rng.uniform(-4, -2) * kinetic * NORMAL
    machine = virtual.Machine(
        sampling_rate=200.0, load_cell_noise=noise, load_cell_range=10.0, seed=seed % 10**6
    )
    trace = virtual.friction(
        static, kinetic, NORMAL, machine=machine, string_stiffness=200.0, texture=0.01, travel=0.15
    )
    for standard in (D1894, ISO8295):
        found = reduce_repeat(trace, NORMAL, None, standard)
        lost = 200.0 * 2.5e-3 / 200.0  # what the string gains between two samples
        assert found.distinct
        assert found.static * NORMAL == pytest.approx(static * NORMAL, abs=lost + 5 * noise)
        # the texture is 1 % over about 1 mm, so that 60 of its patches count
        assert found.kinetic == pytest.approx(kinetic, rel=0.01 * 4.5 / 60**0.5)
        assert found.static_at == pytest.approx(static * NORMAL / 200.0, abs=1e-4 + noise / 40)


def test_no_static_peak_is_said() -> None:
    """A force that bends into sliding without a drop."""
    u = np.linspace(0, 0.15, 15001)
    force = 0.6 * (1 - np.exp(-u / 5e-4)) + 1e-3 * np.random.default_rng(1).standard_normal(15001)
    found = reduce_repeat(Trace(force, u, u / 2.5e-3, "x", ""), 2.0, None, ISO8295)
    assert not found.distinct and found.static == pytest.approx(0.3, rel=5e-3)
    assert any("no clear first maximum" in w for w in found.warnings)


def test_slack_and_dwell_come_first() -> None:
    trace = sled(0.32, 0.24, damping=0.7, dwell=15.0, speed=100e-3 / 60, rate=100.0, travel=0.08)
    found = reduce_repeat(trace, NORMAL, None, ISO8295)
    assert found.static == pytest.approx(0.32, abs=0.01)
    assert not any("rest" in w or "mm/min" in w for w in found.warnings)
    short = sled(0.32, 0.24, damping=0.7, dwell=5.0, rate=100.0, travel=0.08)
    said = reduce_repeat(short, NORMAL, None, ISO8295).warnings
    assert any("15 s at rest" in w for w in said)
    assert any("150 mm/min; ISO 8295 requires 100 mm/min" in w for w in said)


@pytest.mark.parametrize("spring", [50.0, 300.0, 3000.0])
def test_what_inertia_adds_is_bounded_by_the_closed_form(spring: float) -> None:
    """A sled without stiction overshoots its friction by V sqrt(k m), no more."""
    speed = 20e-3
    trace = sled(0.2, 0.2, spring=spring, speed=speed, travel=0.05, rate=2000.0, noise=0.0)
    most = speed * np.sqrt(spring * NORMAL / GRAVITY)
    assert trace.force.max() - 0.2 * NORMAL == pytest.approx(most, rel=0.02)
    found = find_breakaway(trace.travel, trace.force)
    told = inertia_effect(trace.travel, trace.force, trace.time, found, NORMAL / GRAVITY, speed)
    assert told is not None
    assert told.stiffness == pytest.approx(spring, rel=0.05)
    assert told.bound == pytest.approx(most, rel=0.025)
    sticky = sled(0.3, 0.2, spring=spring, speed=speed, travel=0.05, rate=2000.0, noise=0.0)
    assert 0.3 * NORMAL <= sticky.force.max() <= 0.3 * NORMAL + most


def test_the_acceleration_at_breakaway_is_the_sleds() -> None:
    """With stiction the sled starts at (F_s - F_k)/m, and F falls by m a over its gain."""
    trace = sled(0.32, 0.2, spring=100.0, rate=1000.0, noise=0.0, travel=0.03)
    found = find_breakaway(trace.travel, trace.force)
    mass = NORMAL / GRAVITY
    told = inertia_effect(trace.travel, trace.force, trace.time, found, mass, 2.5e-3)
    assert told is not None and told.acceleration is not None
    start = 0.12 * NORMAL / mass
    # the mean over a quarter of a swing is 2/pi of what it starts with
    assert told.acceleration == pytest.approx(start * 2 / np.pi, rel=0.1)


@pytest.mark.parametrize("top", [0.4, 2.0, 30.0])
def test_the_pull_is_as_stiff_as_the_straight_part_of_its_rise(top: float) -> None:
    """300 N/m between slack, up to a tenth of the maximum [N], and a softer end, from 0.9 of it."""
    force = top * np.array([0.0, 0.1, 0.9, 1.0, 0.7, 0.7])
    corners = np.cumsum(np.diff(force, prepend=0.0)[:4] / [1.0, 50.0, 300.0, 100.0])
    corners = np.append(corners, [1.01 * corners[-1], 10 * corners[-1]])
    # the corners are samples too, so that every step has one slope
    travel = np.union1d(corners, np.linspace(0, corners[-1], 10_000))
    record = np.interp(travel, corners, force)
    breakaway = find_breakaway(travel, record)
    assert breakaway.force == top
    inertia = inertia_effect(travel, record, None, breakaway, 0.2, 2.5e-3)
    assert inertia is not None
    assert inertia.stiffness == pytest.approx(300.0, rel=1e-9)
    assert inertia.bound == pytest.approx(2.5e-3 * (300.0 * 0.2) ** 0.5, rel=1e-9)


def test_the_speed_of_a_standard_is_stated_in_mm_per_min() -> None:
    """1 m/s is 60,000 mm/min; a whole number is stated with all digits."""
    fast = dataclasses.replace(D1894, speed=1.0)
    warnings = reduce_repeat(by_hand(), 2.0, None, fast).warnings
    assert "pulled at 150 mm/min; ASTM D1894 requires 60000 mm/min" in warnings


def test_stick_slip_is_reported_and_not_averaged() -> None:
    """A jump law without damping saws between F_s and 2 F_k - F_s: the middle is F_k."""
    traces = [sled(0.32, 0.24, seed=s, uneven=0.04) for s in (1, 2)]
    result = reduce_friction(traces, NORMAL)
    assert result.kinetic is result.kinetic_sd is result.over["kinetic"] is None
    assert len(result.stick_slip.files) == 2
    for repeat in result.repeats:
        assert repeat.kinetic is None and repeat.teeth is not None
        assert repeat.teeth.upper / NORMAL == pytest.approx(0.32, rel=0.02)
        assert repeat.teeth.lower / NORMAL == pytest.approx(0.16, rel=0.04)
        # slow saw: 2 (F_s - F_k)/(k V) and half a swing of the sled
        swing = np.pi * np.sqrt(NORMAL / GRAVITY / 300.0)
        period = 2 * 0.08 * NORMAL / (300.0 * 2.5e-3) + swing
        assert repeat.teeth.period == pytest.approx(period, rel=0.04)
    taken = reduce_friction(traces, NORMAL, accept_stick_slip=True)
    assert taken.kinetic == pytest.approx(0.24, rel=0.01) and taken.stick_slip.accepted


def test_one_repeat_that_judders_leaves_the_kinetic_open() -> None:
    smooth = sled(0.32, 0.24, damping=0.7)
    assert reduce_repeat(smooth, NORMAL).kinetic == pytest.approx(0.24, rel=5e-3)
    mixed = reduce_friction([smooth, sled(0.32, 0.24)], NORMAL)
    assert mixed.kinetic is None and len(mixed.stick_slip.files) == 1
    file = load("choi2018-kapton")
    with pytest.raises(FitError, match=r"stick and slip.*--accept-stick-slip"):
        add_friction(file, mixed, "mine")
    accepted = reduce_friction([smooth, sled(0.32, 0.24)], NORMAL, accept_stick_slip=True)
    made = BrakeFile.read(add_friction(file, accepted, "mine")[0], "mine.toml")
    assert "midpoint of the stick–slip" in made.sources["film.kinetic"].text
    assert "1 of 2" in made.notes["stick_slip"]


def test_the_way_back_does_not_count() -> None:
    there = by_hand()
    both = Trace(
        np.concatenate([there.force, np.full(200, -1.0)]),
        np.concatenate([there.elongation, np.linspace(0.15, 0.0, 200)]),
        None, "both.csv", "made",
    )  # fmt: skip
    for standard in STANDARDS.values():
        alone, with_back = (reduce_repeat(t, 2.0, None, standard) for t in (there, both))
        assert with_back.kinetic == alone.kinetic and with_back.static == alone.static


def test_the_interval_is_students() -> None:
    values = [0.23, 0.24, 0.28]
    found = summarise_repeats(values)
    error = np.std(values, ddof=1) / 3**0.5
    low, high = student.interval(0.95, 2, loc=0.25, scale=error)
    signed = summarise_repeats(values, positive=False)
    assert (signed.low, signed.high) == (pytest.approx(low), pytest.approx(high))
    # of the logarithm, whose error is the relative one to first order (scipy's log-normal ends)
    reach = student.interval(0.95, 2, loc=np.log(0.25), scale=error / 0.25)
    assert (found.low, found.high) == pytest.approx(np.exp(reach))
    assert found.standard_error == pytest.approx(error) and found.mean == pytest.approx(0.25)
    one = summarise_repeats([0.3])
    assert one.sd is one.low is one.high is one.standard_error is None and one.mean == 0.3


@pytest.mark.parametrize("values", [[0.24, 2.4e-4, 0.25], [0.1, 0.9], [1e-9, 1.0, 2.0, 3.0]])
def test_the_interval_of_a_positive_quantity_stays_above_zero(values: list[float]) -> None:
    """One file of another unit: Student's interval about the mean would reach below zero."""
    found, signed = summarise_repeats(values), summarise_repeats(values, positive=False)
    assert signed.low is not None and signed.low < 0
    assert found.low is not None and found.high is not None
    assert 0 < found.low < found.mean < found.high
    assert found.low * found.high == pytest.approx(found.mean**2)


def test_the_interval_covers_the_truth_as_often_as_it_says() -> None:
    """2,000 campaigns of three repeats; 95 % within 93.5 and 96.5."""
    rng = np.random.default_rng(5)
    inside = 0
    for _ in range(2000):
        found = summarise_repeats(rng.normal(0.24, 0.01, 3).tolist())
        assert found.low is not None and found.high is not None
        inside += found.low <= 0.24 <= found.high
    assert 0.935 <= inside / 2000 <= 0.965


def test_a_brake_names_files_digests_standard_and_interval(tmp_path) -> None:
    machine = virtual.Machine(sampling_rate=50.0, load_cell_noise=0.002, load_cell_range=10.0)
    traces = []
    for repeat in (1, 2, 3):
        made = virtual.friction(0.32, 0.24, NORMAL, machine=machine, repeat=repeat,
                                kinetic_sd=0.01, string_stiffness=300.0)  # fmt: skip
        path = virtual.write_own(made, tmp_path / f"{repeat}.csv")
        traces.append(dataclasses.replace(made, path=str(path)))
    result = reduce_friction(traces, NORMAL, None, ISO8295)
    text, _ = add_friction(load("choi2018-kapton"), result, "mine")
    brake = BrakeFile.read(text, "mine.toml")
    source = brake.sources["film.kinetic"].text
    assert "ISO 8295" in source and "1.csv (SHA-256 " in source and "95 % interval" in source
    assert [len(f["sha256"]) for f in brake.notes["files"]] == [64] * 3
    assert brake.notes["standard"] == "ISO 8295" and "mm of travel" in brake.notes["window"]


@pytest.mark.parametrize("readings", [[0.24, 0.24, 0.24], [0.24]])
def test_repeats_with_the_same_reading_have_the_scatter_of_the_paper(readings) -> None:
    file = load("choi2018-kapton")
    means = {"kinetic": summarise_repeats(readings)}
    evidence = make_friction_evidence(file, means, [], {})
    assert Evidence.read(evidence.to_toml()) == evidence
    sds = {part.of: part.covariance[0][0] ** 0.5 for part in evidence.parts}
    # table I of Choi 2018: repeats scatter by 3 %, and their mean by that over the root of n
    assert sds["test"] == pytest.approx(0.03, rel=1e-3)
    assert sds["mean"] == pytest.approx(0.03 / len(readings) ** 0.5, rel=1e-3)


def test_names_of_standards() -> None:
    assert find_standard("paper") is PAPER and set(STANDARDS) == {"paper", "d1894", "iso8295"}
    with pytest.raises(UnknownNameError, match="d1894"):
        find_standard("d1984")
