"""Least squares over all curves: the truth comes back, and what cannot be told is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from laboratory.campaigns.bench import FULL, curve
from laboratory.identify.fitted import TRUTH, campaign
from layerjam.core.errors import FitError
from layerjam.laboratory.identify.calibration.forward import reduce_curves
from layerjam.laboratory.identify.calibration.whole_curves import (
    _make_brake_sources,
    calibrate_curves,
)
from layerjam.laboratory.identify.curves import (
    crosshead_speed,
    group_conditions,
    make_curves,
    number_repeats,
    require_usable_pull,
    select_fitted_part,
)
from layerjam.laboratory.identify.pull.features import pull_features
from strategies import KAPTON, PTFE, change

THREE = (40e3, 60e3, 90e3)
BLANK = change(KAPTON, scale_factor=1.0, stiffness_measured=None)


def close(found, truth, rel=1e-6) -> None:
    assert tuple(found.values[n] for n in ("scale_factor", "stiffness", "enclosure_factor")) == (
        pytest.approx(truth, rel=rel)
    )


@pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
def test_the_truth_comes_back_without_noise(brake) -> None:
    blank = replace(brake, scale_factor=1.0, stiffness_measured=None)
    found = calibrate_curves(campaign(THREE, 1, brake=brake, slack=1e-4), blank)
    close(found, TRUTH, 2e-4)  # stretches of equal elongation, the bend lies within one
    assert found.fit.settled and all(c.passed for c in found.checks), found.checks


def test_with_noise_and_scatter_it_lies_within_the_interval() -> None:
    spread = (0.03, 0.03, 0.05)
    curves = campaign(THREE, 3, spread=spread, noise=0.15, slack=1e-4, seed=8)
    found = calibrate_curves(curves, BLANK)  # of a seed without similar neighbours
    for name, truth in zip(("scale_factor", "stiffness", "enclosure_factor"), TRUTH, strict=True):
        interval = found.intervals[name]
        assert interval is not None and interval.low < truth < interval.high
        assert interval.degrees_of_freedom == pytest.approx(8, abs=0.1)
        assert 0 < interval.standard_error < 0.04 * truth
    assert found.errors_rest_on == "the scatter between 9 pulls"


def test_curves_that_tell_little_noise_give_the_mean_of_their_own() -> None:
    """Every curve counts alike where noise is small, also at different vacuums."""
    curves = campaign(THREE, 2, spread=(0.03, 0.02, 0.05))
    found = calibrate_curves(curves, BLANK)
    own = found.fit.own.own
    np.testing.assert_allclose(found.fit.population.estimate, own[:, :3].mean(axis=0), rtol=1e-5)
    scatter = own[:, 0].std(ddof=1) / np.sqrt(len(curves))
    interval = found.intervals["scale_factor"]
    assert interval is not None
    assert interval.standard_error / found.scale_factor == pytest.approx(scatter, rel=1e-3)


def test_the_start_does_not_matter() -> None:
    curves = campaign((FULL,), 3, spread=(0.02, 0.02, 0.02), noise=0.1)
    starts = [change(KAPTON, scale_factor=a, stiffness_measured=k)
              for a, k in ((0.4, None), (1.0, 5e4), (2.5, 6e5))]  # fmt: skip
    found = [calibrate_curves(curves, brake).values for brake in starts]
    for one in found[1:]:
        assert one == pytest.approx(found[0], rel=1e-6)


def test_pressure_exponent_and_speed_law() -> None:
    curves = campaign(THREE, 1, exponent=-0.1, slope=0.08, speeds=(0.005, 0.02))
    found = calibrate_curves(curves, BLANK, ("pressure_exponent", "speed"))
    assert found.values["pressure_exponent"] == pytest.approx(-0.1, abs=1e-4)
    assert found.values["speed_slope"] == pytest.approx(0.08, abs=1e-4)
    assert found.reference_speed == pytest.approx(0.01)
    middle = float(np.prod(THREE) ** (1 / 3))
    assert found.reference_pressure == pytest.approx(middle)
    at = 0.9 * (middle / 60e3) ** -0.1
    assert found.scale_factor == pytest.approx(at, rel=1e-4)
    # a brake that states its friction test's pressure has the factor there
    stated = change(BLANK, pressure_exponent=0.0, test_pressure=3.9e3)
    there = calibrate_curves(curves, stated, ("pressure_exponent", "speed"))
    assert there.scale_factor == pytest.approx(0.9 * (3.9e3 / 60e3) ** -0.1, rel=1e-3)
    assert there.reference_pressure == 3.9e3
    # held at the truth instead of fitted, the rest is the same
    held = calibrate_curves(curves, change(stated, pressure_exponent=-0.1), ("speed",))
    assert held.scale_factor == pytest.approx(there.scale_factor, rel=1e-3)
    assert "pressure_exponent" not in held.values


def test_only_sheets_that_fan_out_state_the_lowest_pressure() -> None:
    """The sheets feel 0.8 of the gauge's vacuum, of which the least is 40 kPa."""
    fitted = calibrate_curves(campaign(THREE, 1), BLANK, ("pressure_exponent",))
    assert fitted.fit is not None

    def lowest_pressure(spacers: bool | None) -> float | None:
        brake = change(BLANK, mount__spacers=spacers, vacuum_share=0.8)
        sources = _make_brake_sources(fitted.fit, fitted.values, fitted.standard_errors, brake)
        return sources["lowest_pressure"][0] if "lowest_pressure" in sources else None

    assert lowest_pressure(False) == pytest.approx(0.8 * 40e3)
    assert lowest_pressure(True) is lowest_pressure(None) is None


def test_a_force_offset_is_fitted_on_request_only() -> None:
    curves = campaign(THREE, 1, offset=3.0)
    found = calibrate_curves(curves, BLANK, ("force_offset",))
    close(found, TRUTH, 3e-3)
    offsets = found.fit.own.own[:, 4] * found.fit.reduced.height
    np.testing.assert_allclose(offsets, 3.0, rtol=0.02)
    without = calibrate_curves(curves, BLANK)
    assert without.scale_factor > 1.01 * TRUTH[0]


def test_a_curve_without_a_peak_takes_part() -> None:
    """At 3 kPa PTFE rises to the end: no peak, no slope, but a curve."""
    low = campaign((3e3,), 1, brake=PTFE)
    assert not low[0].has_peak
    found = calibrate_curves(
        [*campaign((60e3,), 2, brake=PTFE), *low], change(PTFE, scale_factor=1.0)
    )
    close(found, TRUTH, 0.01)


def test_one_curve_has_values_but_no_interval() -> None:
    found = calibrate_curves(campaign((FULL,), 1, noise=0.1), BLANK)
    close(found, TRUTH, 0.01)
    assert set(found.intervals.values()) == set(found.bootstrap.values()) == {None}
    assert "nothing" in found.errors_rest_on
    assert not any(m.files or m.conditions for m in found.leave_one_out.values())


def test_an_exponent_that_hangs_on_one_curve_has_no_interval() -> None:
    curves = [*campaign((FULL,), 2, spread=(0.02,) * 3), *campaign((40e3,), 1)]
    found = calibrate_curves(curves, BLANK, ("pressure_exponent",))
    assert found.intervals["pressure_exponent"] is None
    assert found.bootstrap["pressure_exponent"] is None


def test_leave_one_out_names_the_odd_file() -> None:
    curves = [*campaign(THREE, 2, spread=(0.005,) * 3, noise=0.05)]
    odd = campaign((60e3,), 1, truth=(1.05, 120e3, 1.3))[0]
    curves = [replace(c, path=f"{i}.csv") for i, c in enumerate([*curves, odd])]
    found = calibrate_curves(curves, BLANK)
    moved = found.leave_one_out["scale_factor"]
    assert moved.most_influential == next(iter(moved.files)) == "6.csv"
    again = calibrate_curves(curves[:-1], BLANK)
    assert found.scale_factor + moved.files["6.csv"] == pytest.approx(again.scale_factor, rel=2e-4)
    words = list(moved.conditions)
    assert words[0] == "60 kPa, 13 mm/s" and len(words) == 3


def test_what_cannot_be_told_is_refused() -> None:
    two, slow, fast = (
        campaign((FULL,), 2), campaign((40e3,), 1, speeds=(0.005,)),
        campaign((90e3,), 1, speeds=(0.02,)),
    )  # fmt: skip
    unknown = replace(two[0], speed=None, path="x.csv")
    for curves, free, words in (
        ((), (), "no pull was given"),
        (two, ("pressure_exponent",), "vacuums at least 10 % apart"),
        (two, ("speed",), "speeds at least 20 % apart"),
        (two, ("inertia",), "'inertia' is unknown; choose from pressure_exponent"),
        ((*slow, *fast), ("speed", "pressure_exponent"), "vacuum and speed change together"),
        ((unknown, two[1]), ("speed",), "x.csv has neither a speed"),
    ):
        with pytest.raises(FitError, match=words):
            calibrate_curves(curves, BLANK, free)


def test_pulls_that_cannot_be_used() -> None:
    pull = pull_features(curve(KAPTON))
    with pytest.raises(FitError, match="jams no sheet"):
        require_usable_pull(pull, 0.0)
    few = replace(pull, force=pull.force[::200], elongation=pull.elongation[::200])
    with pytest.raises(FitError, match="samples above 20% of its maximum force"):
        require_usable_pull(few, FULL)


def test_repeats_are_counted_within_their_condition() -> None:
    curves = campaign((FULL, 0.98 * FULL, 40e3), 2, speeds=(0.005, 0.013))
    assert [c.repeat for c in curves] == [1, 2, 1, 2, 3, 4, 3, 4, 1, 2, 1, 2]
    assert sorted(len(g) for g in group_conditions(curves)) == [2, 2, 4, 4]
    assert [c.repeat for c in number_repeats(curves[2:4])] == [1, 2]


def test_speed_from_the_sidecar_or_the_clock() -> None:
    trace = curve(KAPTON)
    assert crosshead_speed(trace) == pytest.approx(0.013)
    assert crosshead_speed(replace(trace, facts=replace(trace.facts, speed=0.02))) == 0.02
    assert crosshead_speed(replace(trace, time=None)) is None
    assert crosshead_speed(replace(trace, time=0 * trace.time)) is None
    assert make_curves([(trace, pull_features(trace), FULL)])[0].speed == pytest.approx(0.013)


def test_reduction_keeps_every_sample_and_the_mean() -> None:
    one = campaign((FULL,), 1, noise=0.2)[0]
    small = reduce_curves([one])
    part = select_fitted_part(one)
    weight = small.weight[0] * len(one.force[part]) / small.weight[0].sum()
    assert weight.sum() == pytest.approx(len(one.force[part]))
    assert (weight * small.force[0]).sum() == pytest.approx(one.force[part].sum(), rel=1e-12)
    assert one.force[part][0] > 0.15 * one.peak_force
