"""Zero, resolution, drift and saturation in `pull`, `enclosure` and `crash`, by NumPy alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from laboratory.measure.layouts import REAL
from layerjam.core.errors import FileError
from layerjam.laboratory.measure.saturation import find_plateau

FIELD = REAL / "field"
AREA, GAUGE = 18e-6, 33e-3
SPECIMEN: dict[str, Any] = {"area": "18 mm^2", "gauge_length": "33 mm"}


def levels(result: Any) -> dict[str, str]:
    """{check: level}."""
    return {row["name"]: row["level"] for row in result.checks}


def specimen(
    path: Path,
    seed: int,
    *,
    zero: float = 0.0,
    step: float = 0.0,
    limit: float = np.inf,
    noise: float = 2e-3,
    rest: int = 0,
    drift: float = 0.0,
    broken: bool = False,
) -> tuple[Path, float]:
    """Write a tensile test of a rubber, σ = 2 C (λ - 1/λ²); return it with the stress at 100 %."""
    draw = np.random.default_rng(seed)
    shear = 50e3 * (1 + 0.02 * draw.standard_normal())
    strain = np.concatenate([np.zeros(rest), np.linspace(0, 3, 601)])
    force = AREA * shear * (1 + strain - (1 + strain) ** -2)
    if broken:
        strain = np.concatenate([strain, np.linspace(3, 3.3, 60)])
        force = np.concatenate([force, np.zeros(60)])
    reading = force + zero + drift * np.linspace(0, 1, len(force))
    reading = np.minimum(reading, limit) + noise * draw.standard_normal(len(force))
    reading = np.round(reading / step) * step if step else reading
    rows = zip((strain * GAUGE * 1e3).tolist(), reading.tolist(), strict=True)
    lines = ["Extension (mm),Load (N)", *(f"{x:.4f},{f:.5f}" for x, f in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path, shear * (2 - 0.25)


@pytest.mark.parametrize(
    ("zero", "level", "rest"),
    [
        (0.0, "passed", 20),
        (-0.4, "failed", 0),
        pytest.param(0.0, "passed", 0, marks=pytest.mark.slow),
        pytest.param(0.08, "warning", 0, marks=pytest.mark.slow),
        pytest.param(0.08, "warning", 20, marks=pytest.mark.slow),
        pytest.param(-0.4, "failed", 20, marks=pytest.mark.slow),
    ],
)
def test_enclosure_finds_the_zero_and_subtracts_it(
    tmp_path: Path, zero: float, level: str, rest: int
) -> None:
    """Without strain, or where the curve begins if the record has no rest."""
    made = [specimen(tmp_path / f"{i}.csv", i, zero=zero, rest=rest) for i in range(3)]
    files, true = [path for path, _ in made], float(np.mean([value for _, value in made]))
    result = lj.enclosure(files, **SPECIMEN)
    assert levels(result)["zero"] == level
    assert (result.exit_code == 4) == (level == "failed")
    tared = lj.enclosure(files, **SPECIMEN, tare=True)
    assert tared.modulus_100 == pytest.approx(true, rel=5e-3) and tared.exit_code == 0


def test_enclosure_checks_resolution_and_drift(tmp_path: Path) -> None:
    coarse, _ = specimen(tmp_path / "coarse.csv", 1, step=1.0, noise=0.0)
    assert levels(lj.enclosure(coarse, **SPECIMEN))["resolution"] == "failed"
    fine, _ = specimen(tmp_path / "fine.csv", 1, step=0.01)
    assert levels(lj.enclosure(fine, **SPECIMEN))["resolution"] == "passed"
    for drift, level in ((0.0, "passed"), (0.2, "warning"), (0.8, "failed")):
        path, _ = specimen(tmp_path / "drift.csv", 2, drift=drift, broken=True, rest=20)
        assert levels(lj.enclosure(path, **SPECIMEN))["drift"] == level


@pytest.mark.parametrize("noise", [0.0, 1e-3, 1e-2])
def test_enclosure_refuses_a_saturated_load_cell(tmp_path: Path, noise: float) -> None:
    for seed in range(5):
        path, _ = specimen(tmp_path / "cut.csv", seed, limit=2.0, noise=noise)
        with pytest.raises(FileError, match="the load cell was saturated"):
            lj.enclosure(path, **SPECIMEN)


def pull_file(
    path: Path, seed: int, zero: float = 0.0, limit: float = np.inf, noise: float = 0.05,
    rate: float = 200.0,
) -> Path:  # fmt: skip
    """Write a pull at 13 mm/s: rest, rise at 100 N/mm, sliding at A + e sqrt(x) - c x."""
    draw = np.random.default_rng(seed)
    time = np.arange(0, 4.0, 1 / rate)
    elongation = np.maximum(time - 0.5, 0) * 13.0
    slip = np.maximum(elongation - 0.6, 0)
    force = np.minimum(100 * elongation, 60.0) + np.where(
        slip > 0, 2.0 * np.sqrt(slip) - 0.6 * slip, 0.0
    )
    reading = np.minimum(force + zero, limit) + noise * draw.standard_normal(len(time))
    rows = zip(time.tolist(), elongation.tolist(), reading.tolist(), strict=True)
    lines = ["Time (s),Extension (mm),Load (N)", *(f"{t:.4f},{u:.4f},{f:.4f}" for t, u, f in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(("zero", "level"), [(0.3, "passed"), (3.0, "warning"), (9.0, "failed")])
def test_pull_checks_the_zero(tmp_path: Path, zero: float, level: str) -> None:
    path = pull_file(tmp_path / "pull.csv", 1, zero)
    assert levels(lj.pull(path))["zero"] == level
    tared = lj.pull(path, tare=True)
    assert levels(tared)["zero"] == "passed"
    assert tared.pulls[0]["peak_force"] == pytest.approx(61.67, rel=2e-3)


@pytest.mark.parametrize("noise", [0.02, 0.1])
def test_pull_refuses_a_saturated_load_cell_with_noise(tmp_path: Path, noise: float) -> None:
    for seed in range(5):
        with pytest.raises(FileError, match="the load cell was saturated"):
            lj.pull(pull_file(tmp_path / "cut.csv", seed, limit=50.0, noise=noise))


@pytest.mark.parametrize(
    ("shapes", "most"), [(500, 1), pytest.param(2000, 4, marks=pytest.mark.slow)]
)
def test_tops_of_healthy_pulls_are_not_plateaus(shapes: int, most: int) -> None:
    """Shapes with a corner, a smooth top and a gradual fall, at all rates."""
    false = 0
    for seed in range(shapes):
        draw = np.random.default_rng(seed)
        step = 10 ** draw.uniform(-2.2, -0.7)
        elongation = np.arange(0, 40, step)
        rise, peak = 10 ** draw.uniform(1, 2.3), draw.uniform(20, 150)
        slip = np.maximum(elongation - peak / rise, 0)
        force = np.minimum(rise * elongation, peak) * (1 - slip / draw.uniform(60, 150))
        force = force + draw.uniform(0, 0.15) * peak * np.sqrt(slip / 20)
        noise = peak * 10 ** draw.uniform(-4, -1.7)
        found = find_plateau(force + noise * draw.standard_normal(len(force)))
        false += found is not None and found.ends
    assert false <= most


def impact(seed: int, limit: float, before: float, after: float) -> tuple[np.ndarray, np.ndarray]:
    """A half-sine pulse of 500 m/s² over 20 ms, cut at `limit`, with noise before and after it."""
    draw = np.random.default_rng(seed)
    time = np.arange(0, 0.2, 1e-4)
    pulse = 500 * np.sin(np.pi * np.clip((time - 0.08) / 0.02, 0, 1))
    analogue = np.minimum(pulse + before * draw.standard_normal(len(time)), limit)
    return time, analogue + after * draw.standard_normal(len(time))


def crash_file(path: Path, time: np.ndarray, values: np.ndarray) -> Path:
    """Write a log of acceleration."""
    rows = zip(time.tolist(), values.tolist(), strict=True)
    lines = ["Time (s),Acceleration (m/s^2)", *(f"{t:.4f},{a:.4f}" for t, a in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_crash_finds_an_amplifier_that_saturates_before_the_noise(tmp_path: Path) -> None:
    """The noise falls at the top: saturated. Equal noise: perhaps a flat pulse, a warning."""
    for seed in range(3):
        cut = crash_file(tmp_path / "cut.csv", *impact(seed, 350.0, 3.0, 0.5))
        assert levels(lj.crash(cut, filter_class="none"))["saturation"] == "failed"
        equal = crash_file(tmp_path / "equal.csv", *impact(seed, 350.0, 0.0, 1.0))
        result = lj.crash(equal, filter_class="none")
        assert levels(result)["saturation"] == "warning" and not result.saturated
        assert any("--range" in w for w in result.warnings)
        whole = crash_file(tmp_path / "whole.csv", *impact(seed, np.inf, 2.0, 0.5))
        assert levels(lj.crash(whole, filter_class="none"))["saturation"] == "passed"


@pytest.mark.skipif(not FIELD.is_dir(), reason="no files from the field here")
def test_the_offset_of_a_specimen_from_the_field() -> None:
    path = FIELD / "14_enclosure_load_offset_plus.csv"
    assert levels(lj.enclosure(path, **SPECIMEN))["zero"] == "failed"
    tared = lj.enclosure(path, **SPECIMEN, tare=True)
    assert tared.modulus_100 == pytest.approx(87.5e3, abs=100)
