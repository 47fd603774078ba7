"""Faulty load cells and rigs in friction tests, in files of a rig without code of layerjam."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from independent.sled_rig import Rig, campaign, run, write
from laboratory.measure.layouts import REAL
from layerjam.core.errors import FileError
from layerjam.laboratory.identify.friction.spikes import find_spikes, remove_spikes
from layerjam.laboratory.measure.noise import find_quantum, rounding_limit
from layerjam.laboratory.measure.saturation import find_plateau

FIELD = REAL / "field"
NORMAL = 2.0
STATIC, KINETIC = 0.356, 0.300
"""Friction of `Rig` under that normal force."""


def levels(result: Any) -> dict[str, str]:
    """{check: level}."""
    return {row["name"]: row["level"] for row in result.checks}


def reason(result: Any, name: str) -> str:
    """Sentence of a check."""
    return str(next(row["sentence"] for row in result.checks if row["name"] == name))


def measured(folder: Path, count: int = 4, seed: int = 1, scatter: float = 0.02, **rig: Any) -> Any:
    """The result of a campaign."""
    return lj.friction(campaign(folder, count, seed, scatter, **rig), normal_force=NORMAL)


def test_healthy_tests_pass(clean: Any) -> None:
    assert clean.exit_code == 0 and set(levels(clean).values()) == {"passed"}
    assert clean.kinetic == pytest.approx(KINETIC, rel=0.02)
    assert clean.static == pytest.approx(STATIC, rel=0.03)
    assert clean.intervals["kinetic"]["low"] < KINETIC < clean.intervals["kinetic"]["high"]


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The result of a campaign without a fault."""
    return measured(tmp_path_factory.mktemp("clean"))


# the brake's own friction ------------------------------------------------------------------


@pytest.fixture(scope="module")
def own_brake(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A brake whose friction was measured."""
    folder = tmp_path_factory.mktemp("own")
    files = campaign(folder, 5, 7)
    out = folder / "own.toml"
    result = lj.friction(files, normal_force=NORMAL, brake="choi2018-kapton", out=out)
    assert result.exit_code == 0 and result.reference["basis"] == "catalogue"
    return out


@pytest.mark.parametrize("gain", [0.5, 0.75, 1.5, 2.0, 4.0])
def test_a_gain_of_all_tests_shows_against_the_own_friction(
    own_brake: Path, tmp_path: Path, gain: float
) -> None:
    out = tmp_path / "again.toml"
    files = campaign(tmp_path, 4, 8, gain=gain)
    result = lj.friction(files, normal_force=NORMAL, brake=own_brake, out=out)
    assert result.exit_code == 4 and levels(result)["film"] == "failed" and not out.exists()
    assert "the brake's own measured value" in reason(result, "film")
    assert result.reference["basis"] == "own measurement"


def test_the_same_film_agrees_with_its_own_friction(own_brake: Path, tmp_path: Path) -> None:
    files = campaign(tmp_path, 4, 9)
    result = lj.friction(files, normal_force=NORMAL, brake=own_brake, out=tmp_path / "again.toml")
    assert result.exit_code == 0 and levels(result)["film"] == "passed"
    factor = levels(measured(tmp_path, seed=9))
    assert factor["film"] == "passed"  # without a brake, the usual range of films


# resolution --------------------------------------------------------------------------------


@pytest.mark.parametrize("step", [0.5, 1.0])
def test_a_coarse_load_cell_fails(tmp_path: Path, step: float) -> None:
    result = measured(tmp_path, step=step)
    assert result.exit_code == 4 and levels(result)["resolution"] == "failed"
    for name, true in (("static", STATIC), ("kinetic", KINETIC)):
        interval = result.intervals[name]
        assert interval["high"] - interval["low"] >= step / NORMAL * 0.95
        assert interval["low"] < true < interval["high"]


@pytest.mark.parametrize(
    ("campaigns", "least"), [(12, 11), pytest.param(40, 37, marks=pytest.mark.slow)]
)
def test_the_interval_contains_the_truth_at_a_resolution_that_passes(
    tmp_path: Path, campaigns: int, least: int
) -> None:
    """Steps of 4 % of the force, texture and noise far below."""
    inside = 0
    for seed in range(campaigns):
        level = np.random.default_rng(seed).uniform(0.58, 0.62)
        result = measured(
            tmp_path, 3, seed, 0.002, step=0.024, texture=1e-3, noise=1e-4, kinetic=level, rate=20.0
        )
        interval = result.intervals["kinetic"]
        inside += interval["low"] <= level / NORMAL <= interval["high"]
        assert interval["high"] - interval["low"] >= 0.95 * 0.024 / NORMAL
    assert inside >= least


def test_noise_averages_the_resolution_out() -> None:
    """The mean of rounded normal samples, by simulation, is closer than the limit says."""
    draw = np.random.default_rng(2)
    for noise in (0.05, 0.2, 0.5, 0.7, 1.0, 2.0):
        errors = []
        for offset in draw.uniform(-0.5, 0.5, 40):
            true = offset + noise * draw.standard_normal(20_000)
            codes = np.round(true)
            errors.append(abs(codes.mean() - offset) - 3 * noise / 20_000**0.5)
        assert max(errors) <= rounding_limit(codes, 1.0) + 1e-3, noise
    assert find_quantum(np.round(draw.normal(0, 3, 500)) * 0.02) == pytest.approx(0.02)
    assert rounding_limit(np.full(50, 0.5), 0.5) == 0.25


# spikes ------------------------------------------------------------------------------------


@pytest.mark.parametrize("samples", [1, 2, 3])
@pytest.mark.parametrize("place", [0.03, 0.3, 0.7])
def test_a_spike_in_each_test_is_named_and_left_out(
    clean: Any, tmp_path: Path, samples: int, place: float
) -> None:
    spoilt = measured(tmp_path, spike=0.4, spike_width=samples, spike_at=place)
    assert spoilt.static == pytest.approx(clean.static, rel=0.02)
    assert spoilt.kinetic == pytest.approx(clean.kinetic, rel=1e-3)
    time = 3 + place * 0.11 / 2.5e-3
    named = " ".join(w for w in spoilt.warnings if "a spike of" in w)
    assert f"at {int(time)}." in named
    assert all(f"sled-{number}.csv" in named for number in (1, 2, 3, 4)) or "all 4" in named
    assert [row["spikes"] for row in spoilt.repeats_table] == [1, 1, 1, 1]


def test_a_negative_spike_is_left_out_as_well(clean: Any, tmp_path: Path) -> None:
    result = measured(tmp_path, spike=-0.6, spike_width=3)
    assert result.kinetic == pytest.approx(clean.kinetic, rel=1e-3)
    assert any("a spike of -0." in w for w in result.warnings)


def test_peaks_and_teeth_that_a_string_can_produce_are_kept() -> None:
    """Sharp static peaks at all rates, and stick–slip, whose teeth rise as fast as the string."""
    for rate in (10.0, 50.0, 1000.0):
        for seed in range(8):
            draw = np.random.default_rng(seed)
            rig = Rig(
                rate=rate, static=0.6 * draw.uniform(1, 2), stiffness=10 ** draw.uniform(2, 3.7)
            )
            _, travel, force = run(rig, seed)
            assert find_spikes(travel, force, 0.6) == []
    travel = np.arange(0, 0.1, 2.5e-5)
    rising = np.minimum(300 * travel, 0.7)
    teeth = np.where(300 * travel > 0.7, 0.5 + np.mod(300 * travel - 0.7, 0.2), rising)
    assert find_spikes(travel, teeth, 0.6) == []
    trembling = teeth + 0.3 * (np.arange(len(teeth)) % 50 == 7)
    assert find_spikes(travel, trembling, 0.6) == []  # 80 of them are a vibration
    spikes = find_spikes(travel, teeth + 0.5 * (np.arange(len(teeth)) == 2000), 0.6)
    assert len(spikes) == 1 and spikes[0].samples == 1
    assert remove_spikes(teeth + 0.5 * (np.arange(len(teeth)) == 2000), spikes).max() < 0.71


# zero and drift ----------------------------------------------------------------------------


def test_a_zero_error_fails_and_tare_subtracts_it(clean: Any, tmp_path: Path) -> None:
    files = campaign(tmp_path, 4, 1, zero=0.12)
    result = lj.friction(files, normal_force=NORMAL)
    assert result.exit_code == 4 and levels(result)["zero"] == "failed"
    assert "+20%" in reason(result, "zero") and "--tare" in reason(result, "zero")
    tared = lj.friction(files, normal_force=NORMAL, tare=True)
    assert tared.exit_code == 0 and levels(tared)["zero"] == "passed"
    assert tared.kinetic == pytest.approx(clean.kinetic, rel=2e-3)
    assert tared.static == pytest.approx(clean.static, rel=5e-3)
    assert [row["tared"] for row in tared.repeats_table] == pytest.approx([0.12] * 4, abs=1e-3)


@pytest.mark.parametrize(
    ("zero", "level"), [(0.006, "passed"), (0.03, "warning"), (-0.1, "failed")]
)
def test_the_size_of_the_zero_decides(tmp_path: Path, zero: float, level: str) -> None:
    assert levels(measured(tmp_path, zero=zero))["zero"] == level


def test_a_record_that_starts_on_its_rise_shows_no_zero(tmp_path: Path) -> None:
    files = campaign(tmp_path, 3, 1, rest=0.0, slack=0.0, zero=0.12)
    result = lj.friction(files, normal_force=NORMAL)
    assert levels(result)["zero"] == "note" and "unknown" in reason(result, "zero")
    with pytest.raises(FileError, match="no earlier force to subtract"):
        lj.friction(files, normal_force=NORMAL, tare=True)


@pytest.mark.parametrize("home", [0.0, 4.0])
@pytest.mark.parametrize(
    ("part", "level"), [(0.005, "passed"), (0.05, "warning"), (-0.15, "failed")]
)
def test_a_drift_of_the_zero_is_found_by_its_size(
    tmp_path: Path, home: float, part: float, level: str
) -> None:
    """`part` of the kinetic force up to the middle of the window, 31 s after the beginning."""
    result = measured(tmp_path, drift=part * 0.6 / 31, home=home, texture=2e-3)
    assert levels(result)["drift"] == level


def test_a_rig_that_is_not_level_is_a_warning_if_the_zero_returns(tmp_path: Path) -> None:
    tilt = 0.15 * 0.6 / 0.07
    assert levels(measured(tmp_path, tilt=tilt))["drift"] == "failed"
    result = measured(tmp_path, tilt=tilt, home=4.0)
    assert levels(result)["drift"] == "warning" and "not level" in reason(result, "drift")


def test_ageing_names_the_zero_and_subtracts_it(tmp_path: Path) -> None:
    files = campaign(tmp_path, 4, 3, zero=0.12)
    for number, path in enumerate(files):
        hold = f'hold = "{10 ** (number % 2 + 1)} s"\nnormal_force = "{NORMAL} N"\n'
        path.with_name(f"{path.name}.toml").write_text(hold, encoding="utf-8")
    result = lj.ageing(files)
    assert sum("--tare" in w for w in result.warnings) == 4
    tared = lj.ageing(files, tare=True)
    assert not any("--tare" in w for w in tared.warnings)
    assert result.static - tared.static == pytest.approx(0.06, rel=0.02)


# saturation and slack ----------------------------------------------------------------------


@pytest.mark.parametrize("noise", [1e-3, 2e-3])
@pytest.mark.parametrize("limit", [0.4, 0.5, 0.55])
def test_a_saturated_load_cell_is_found_through_noise(
    tmp_path: Path, limit: float, noise: float
) -> None:
    result = measured(tmp_path, limit=limit, noise=noise)
    assert result.exit_code == 4 and levels(result)["saturation"] == "failed"
    assert "but for noise in sled-1.csv" in reason(result, "saturation")
    one = measured(tmp_path, 1, limit=limit, noise=noise)
    assert levels(one)["saturation"] == "warning"


def test_a_static_peak_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    """The force rises by 7.5 mN a sample, and static friction is 0.1 N above the limit."""
    for seed in range(4):
        path = write(tmp_path / "cut.csv", Rig(rate=100.0, static=0.8, limit=0.7), seed)
        with pytest.raises(FileError, match="the load cell was saturated: 1.* samples in a row"):
            lj.friction(path, normal_force=NORMAL)


def test_tests_without_saturation_have_no_plateau_that_ends() -> None:
    """Sliding without texture is as even as a saturated cell; then only its level decides."""
    for seed in range(50):
        draw = np.random.default_rng(seed)
        rig = Rig(
            rate=float(draw.choice([10, 50, 500])), noise=10 ** draw.uniform(-3.5, -2),
            static=0.6 * draw.uniform(1.0, 1.5), texture=float(draw.choice([0, 0.01, 0.03])),
            stiffness=10 ** draw.uniform(1.8, 3.5),
        )  # fmt: skip
        found = find_plateau(run(rig, seed)[2])
        assert found is None or not found.ends


def test_slack_that_reaches_into_the_window_fails(tmp_path: Path) -> None:
    result = measured(tmp_path, slack=0.045)
    assert result.exit_code == 4 and levels(result)["slack"] == "failed"
    told = reason(result, "slack")
    start = told.rpartition("--from ")[2].rstrip(")")
    later = lj.friction(sorted(tmp_path.glob("*.csv")), normal_force=NORMAL, start=start)
    assert later.exit_code == 0 and later.kinetic == pytest.approx(KINETIC, rel=0.02)


# files from the field ----------------------------------------------------------------------


@pytest.mark.skipif(not FIELD.is_dir(), reason="no files from the field here")
def test_the_files_from_the_field() -> None:
    offset = FIELD / "02_friction_load_cell_offset.csv"
    assert "0.4001 N" in reason(lj.friction(offset, normal_force=NORMAL), "zero")
    tared = lj.friction(offset, normal_force=NORMAL, tare=True)
    assert (tared.kinetic, tared.static) == pytest.approx((0.300, 0.356), abs=1e-3)
    spike = lj.friction(FIELD / "03_friction_one_sample_spike.csv", normal_force=NORMAL)
    assert spike.static == pytest.approx(0.356, abs=1e-3)
    assert any("a spike of 1.4 N over 1 sample at 3.1 s" in w for w in spike.warnings)
