"""The pulled brake: outcomes, energies and the forces of the law it is made of."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.energy import pull_work, slip_heat
from layerjam.brake.mechanics.pull import force_at_elongation, least_stiffness, peak
from layerjam.brake.simulate.procedure import Procedure, Pull, Return, parse_procedure, simple_pull
from layerjam.brake.simulate.record import Outcome, TensileRecord
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.errors import LayerjamError, ProcedureError
from strategies import change, one, random_brakes, seeds

KAPTON = load("choi2018-kapton")
PTFE = load("choi2018-ptfe")


def with_brake(file: BrakeFile, **values: object) -> BrakeFile:
    return dataclasses.replace(file, brake=change(file.brake, **values))


def run(text: str, file: BrakeFile = KAPTON) -> TensileRecord:
    return tensile(file, parse_procedure(text))


def balanced(record: TensileRecord) -> None:
    """Energy comes from work alone, is never given back as heat, and the arrays fit together."""
    sizes = {len(values) for _, values, _ in record.columns()}
    assert len(sizes) == 1
    for name, values, _ in record.columns():
        assert np.isfinite(values).all(), name
    work, heat, stored = record.work, record.dissipated_energy, record.stored_energy
    np.testing.assert_allclose(work, heat + stored, rtol=1e-9, atol=1e-12 * work.max())
    assert np.diff(heat).min() >= -1e-12
    assert stored.min() >= -1e-15 and record.force.min() >= 0
    assert np.diff(record.time).min() >= 0
    area = np.concatenate(
        [[0], np.cumsum((record.force[1:] + record.force[:-1]) / 2 * np.diff(record.elongation))]
    )
    assert np.abs(area - work).max() < 2e-3 * work.max()


@pytest.mark.parametrize("file", [KAPTON, PTFE], ids=lambda f: f.name)
@pytest.mark.parametrize("vacuum", [0.0, 18.6e3, 94.5e3])
def test_a_pull_is_the_law(file: BrakeFile, vacuum: float) -> None:
    record = tensile(file, simple_pull(vacuum, 13e-3, 40e-3))
    assert record.outcome is Outcome.FINISHED and record.warnings == ()
    balanced(record)
    law = np.asarray(force_at_elongation(record.elongation, vacuum, file.brake))
    np.testing.assert_allclose(record.force, law, rtol=1e-10, atol=1e-9)
    assert record.work[-1] == pytest.approx(float(pull_work(0.04, vacuum, file.brake)), rel=1e-10)
    heat = float(slip_heat(record.slip[-1], vacuum, file.brake))
    assert record.dissipated_energy[-1] == pytest.approx(heat, rel=1e-10)
    assert record.elongation[-1] == 0.04
    assert record.time[-1] == pytest.approx(0.04 / 13e-3, rel=1e-14)


def test_the_peak_is_a_sample() -> None:
    record = tensile(KAPTON, simple_pull(94.5e3, 13e-3, 40e-3))
    top = peak(94.5e3, 0.06, KAPTON.brake)
    assert record.force.max() == pytest.approx(float(top.force), rel=1e-14)
    assert record.elongation[record.force.argmax()] == float(top.elongation)


def test_speed_changes_time_alone() -> None:
    slow = tensile(KAPTON, simple_pull(94.5e3, 1e-3, 40e-3))
    fast = tensile(KAPTON, simple_pull(94.5e3, 25e-3, 40e-3))
    np.testing.assert_array_equal(slow.force, fast.force)
    np.testing.assert_allclose(slow.time, 25 * fast.time, rtol=1e-12)


@settings(max_examples=25)
@given(seeds)
def test_cycles_of_random_brakes_never_give_energy_back(seed: int) -> None:
    brake = one(random_brakes(seed, 1), 0)
    file = dataclasses.replace(KAPTON, brake=brake)
    rng = np.random.default_rng(seed)
    steps: list[object] = [*simple_pull(brake.site.atmosphere * rng.uniform(), 1e-2, 1e-3).steps]
    place = 1e-3
    for _ in range(6):
        new = float(rng.uniform(0, 0.9 * brake.sheets.overlap))
        if new > place:
            steps.append(Pull(speed=1e-2, until=new))
        elif new < place:
            steps.append(Return(speed=1e-2, to=new))
        place = new
    record = tensile(file, Procedure(tuple(steps)))  # type: ignore[arg-type]
    assert record.outcome in (Outcome.FINISHED, Outcome.CLOSED_BY_SLEEVE)
    work, heat, stored = record.work, record.dissipated_energy, record.stored_energy
    scale = max(work.max(), 1e-12)
    np.testing.assert_allclose(work, heat + stored, rtol=1e-9, atol=1e-10 * scale)
    assert np.diff(heat).min() >= -1e-11 * scale and stored.min() >= -1e-11 * scale
    assert record.force.min() >= 0


@pytest.mark.parametrize("vacuum", ["94.5 kPa", "0.3 kPa"])
def test_a_closed_cycle_dissipates_and_settles(vacuum: str) -> None:
    """At high vacuum the slack brake stays open; at a low one the sleeve closes it every time."""
    record = run(
        f"evacuate to {vacuum}; pull at 13 mm/s until 5 mm; cycle 4 times between 5 mm and 20.5 mm "
        "at 13 mm/s"
    )
    balanced(record)
    ends = [np.flatnonzero(record.elongation == 0.005)[i] for i in range(5)]
    lost = np.diff(record.dissipated_energy[ends])
    assert lost[0] > 0 and lost[2] == pytest.approx(lost[3], rel=1e-9)
    if vacuum == "0.3 kPa":
        assert record.outcome is Outcome.CLOSED_BY_SLEEVE and lost[3] > 0.1 * lost[0]
    else:
        assert record.outcome is Outcome.FINISHED and lost[3] == 0
        assert record.slip[ends[1] :] == pytest.approx(record.slip[ends[1]], rel=1e-14)


def test_vacuum_changes_at_rest_do_no_work() -> None:
    record = run(
        "evacuate to 80 kPa; pull at 13 mm/s until 20 mm; evacuate to 40 kPa; evacuate to 90 kPa "
        "and hold 3 s; hold 1 s; vent"
    )
    balanced(record)
    rest = np.flatnonzero(record.elongation == record.elongation[-1])
    assert len(rest) >= 6
    np.testing.assert_allclose(record.work[rest], record.work[rest[0]], rtol=1e-14)
    assert list(record.vacuum[rest[1:]]) == [40e3, 90e3, 90e3, 90e3, 0.0]
    assert record.force[-1] < record.force[rest[0]]


def test_separated() -> None:
    record = tensile(KAPTON, simple_pull(94.5e3, 13e-3, 0.1))
    assert record.outcome is Outcome.SEPARATED
    assert record.slip[-1] == pytest.approx(0.068, rel=1e-9)
    assert record.elongation[-1] < 0.1
    assert (record.slip[:-1] < 0.068).all()
    balanced(record)


def test_beyond_the_usable_travel_is_said() -> None:
    record = tensile(KAPTON, simple_pull(94.5e3, 13e-3, 0.064))
    assert record.outcome is Outcome.FINISHED
    assert len(record.warnings) == 1 and "usable travel of 60 mm" in record.warnings[0]


@pytest.mark.slow
def test_snaps_on_a_soft_rig() -> None:
    least = float(least_stiffness(94.5e3, KAPTON.brake))
    for k, outcome in ((0.99 * least, Outcome.SNAPS), (1.01 * least, Outcome.FINISHED)):
        file = with_brake(KAPTON, stiffness_measured=k)
        record = tensile(file, simple_pull(94.5e3, 13e-3, 0.12))
        if outcome is Outcome.SNAPS:
            assert record.outcome is outcome
            assert "2.58 kN/m" in record.warnings[-1] and "snaps" in record.warnings[-1]
            assert (record.slip == 0).all()
            np.testing.assert_allclose(record.force, k * record.elongation, rtol=1e-12)
            balanced(record)
        else:
            assert record.outcome is not Outcome.SNAPS
            assert np.isfinite(record.force).all()


@pytest.mark.parametrize(
    ("file", "closes_below"), [(KAPTON, 3.70e3), (PTFE, 12.2e3)], ids=["kapton", "ptfe"]
)
def test_closed_by_sleeve(file: BrakeFile, closes_below: float) -> None:
    k = file.brake.stiffness_measured
    for vacuum, closes in ((0.97 * closes_below, True), (1.03 * closes_below, False)):
        force = float(force_at_elongation(0.04, vacuum, file.brake))
        record = run(
            f"evacuate to {vacuum} Pa; pull at 13 mm/s until {0.04 + force / k} m; "
            "return at 13 mm/s to 10 mm",
            file,
        )
        assert (record.outcome is Outcome.CLOSED_BY_SLEEVE) is closes
        assert bool(record.slip[-1] < record.slip.max() - 1e-6) is closes
        balanced(record)


@pytest.mark.slow
def test_too_many_nested_turns_are_refused() -> None:
    steps, low, high = ["evacuate to 20 kPa"], 25.0, 40.0
    for _ in range(40):
        steps.append(f"pull at 13 mm/s until {high:.6f} mm")
        low += 0.18
        steps.append(f"return at 13 mm/s to {low:.6f} mm")
        high -= 0.18
    soft = with_brake(KAPTON, scale_factor=0.001)
    with pytest.raises(ProcedureError, match="nested reversals"):
        run("; ".join(steps), soft)


def test_vacuum_above_the_site_is_refused() -> None:
    high = with_brake(KAPTON, site__atmosphere=80e3)
    with pytest.raises(LayerjamError, match=r"vacuum: 94\.5 kPa exceeds atmospheric pressure"):
        tensile(high, simple_pull(94.5e3, 13e-3, 0.04))
    assert tensile(high, simple_pull(80e3, 13e-3, 0.04)).outcome is Outcome.FINISHED


def test_nothing_happens_without_a_pull() -> None:
    record = run("evacuate to 50 kPa and hold 2 s; vent")
    assert record.outcome is Outcome.FINISHED
    assert (record.force == 0).all() and (record.work == 0).all()
    assert record.time[-1] == 2.0
