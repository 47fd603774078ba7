"""The fit of ageing: exact lines, intervals that cover the truth, doubts; synthetic data only."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import layerjam as lj
from layerjam.core.errors import FitError, LayerjamError
from layerjam.laboratory.campaigns.campaign import campaign
from layerjam.laboratory.campaigns.spec import FrictionTests, Pulls, Spec, Truth
from layerjam.laboratory.identify.friction.ageing import fit_ageing

HOLDS = (1.0, 10.0, 100.0, 1000.0)


def keys(warnings: object) -> set[str]:
    return {w.key for w in warnings}  # type: ignore[attr-defined]


def test_an_exact_line_comes_back() -> None:
    hold = np.repeat(HOLDS, 2)
    static = 0.3 + 0.02 * np.log10(hold / 10) + np.tile([1e-4, -1e-4], 4)
    found = fit_ageing(hold, static, 10.0)
    assert found.static == pytest.approx(0.3, abs=1e-12) and found.hold == pytest.approx(10)
    assert found.ageing == pytest.approx(0.02, abs=1e-12)
    assert found.sd == pytest.approx(1e-4 * np.sqrt(8 / 6))
    assert not found.warnings
    middle = fit_ageing(hold, static)
    assert middle.hold == pytest.approx(10**1.5)
    assert np.ptp(middle.static_interval) < np.ptp(found.static_interval)


def test_intervals_cover_the_truth_in_19_of_20_cases() -> None:
    """Against drawn pulls; SciPy's regression gives the same standard error."""
    from scipy.stats import linregress, t

    rng, inside, level, cases = np.random.default_rng(4), 0, 0, 2000
    hold = np.repeat(HOLDS, 3)
    for _ in range(cases):
        static = 0.3 + 0.02 * np.log10(hold / 10) + rng.normal(0, 0.012, len(hold))
        found = fit_ageing(hold, static, 10.0)
        inside += found.ageing_interval[0] <= 0.02 <= found.ageing_interval[1]
        level += found.static_interval[0] <= 0.3 <= found.static_interval[1]
    # 95 % and three standard errors of 2000 draws
    assert abs(inside / cases - 0.95) < 0.015
    assert abs(level / cases - 0.95) < 0.015
    line = linregress(np.log10(hold), static)
    reach = t.ppf(0.975, len(hold) - 2) * line.stderr
    assert found.ageing_interval == pytest.approx((line.slope - reach, line.slope + reach))
    at = reach / line.stderr * np.hypot(line.intercept_stderr, 0)
    zero = fit_ageing(hold, static, 1.0).static_interval
    # symmetric about the logarithm: static friction is positive
    spread = np.exp(at / line.intercept)
    assert zero == pytest.approx((line.intercept / spread, line.intercept * spread))


def test_doubts_are_said() -> None:
    rng, hold = np.random.default_rng(1), np.repeat(HOLDS, 3)
    noise = rng.normal(0, 0.002, len(hold))
    assert "no-ageing" in keys(fit_ageing(hold, 0.3 + noise).warnings)
    decades = np.log10(hold)
    bent = fit_ageing(hold, 0.3 + 0.02 * decades**2 + noise)
    assert keys(bent.warnings) == {"not-logarithmic"}
    short = fit_ageing([1, 1, 2, 2], [0.30, 0.301, 0.31, 0.311])
    assert "narrow-holds" in keys(short.warnings)
    far = fit_ageing(hold, 0.3 + 0.02 * decades + noise, 1e6)
    assert keys(far.warnings) == {"hold-outside"}


def test_a_curve_is_suspected_where_there_is_none_in_one_of_20_cases() -> None:
    rng, hold, cases = np.random.default_rng(9), np.repeat(HOLDS, 3), 1000
    found = sum(
        "not-logarithmic"
        in keys(fit_ageing(hold, 0.3 + 0.03 * np.log10(hold) + rng.normal(0, 0.01, 12)).warnings)
        for _ in range(cases)
    )
    assert abs(found / cases - 0.05) < 0.021


def test_too_little_is_refused() -> None:
    with pytest.raises(FitError, match="at least 4"):
        fit_ageing([1, 10, 100], [0.3, 0.31, 0.32])
    with pytest.raises(FitError, match="different length"):
        fit_ageing([5, 5, 5, 5], [0.3, 0.31, 0.32, 0.3])
    with pytest.raises(FitError, match="longer than zero"):
        fit_ageing([0, 5, 5, 5], [0.3, 0.31, 0.32, 0.3])


def hold_pulls(seed: int, scatter: float = 0.02) -> Spec:
    """Synthetic hold–pull tests of a film that ages by 0.025 for ten times the hold."""
    return Spec(
        brakes=(Truth(brake="choi2018-kapton", static=0.31, ageing=0.025, static_hold=10.0),),
        seed=seed,
        pulls=Pulls(vacuums=()),
        friction=FrictionTests(
            repeats=3, holds=(1.0, 10.0, 100.0, 1000.0), static_scatter=scatter, force_noise=1e-3
        ),
    )


@pytest.mark.slow
def test_the_virtual_laboratorys_truth_is_covered() -> None:
    """Synthetic records, read as files are; most of 20 campaigns' intervals hold the truth."""
    inside = 0
    for seed in range(20):
        traces = campaign(hold_pulls(seed)).traces()
        assert all(t.facts.synthetic and t.facts.hold is not None for t in traces)
        found = lj.ageing(traces, hold="10 s")
        assert found.pulls == 12
        inside += found.ageing_low <= 0.025 <= found.ageing_high
    # 19 are expected; fewer than 16 of 20 come by chance in 0.3 % of cases
    assert inside >= 16


def test_from_files_into_a_brake(tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    lj.write_campaign(_written(tmp_path), out=folder)
    files = sorted(p for p in folder.glob("friction_*") if p.suffix != ".toml")
    assert len(files) == 12
    out = tmp_path / "aged.toml"
    found = lj.ageing(files, hold=10.0, brake="choi2018-kapton", out=out)
    film = lj.load(out).brake.film
    assert film.static == pytest.approx(found.static, rel=1e-6)
    assert film.ageing == pytest.approx(found.ageing, rel=1e-6) and film.static_hold == 10
    assert 0.015 < found.ageing < 0.035
    again = lj.friction(files, brake=out, out=tmp_path / "again.toml")
    assert any("film.static_hold were fitted with the old" in w for w in again.warnings)
    held = lj.laws.aged_holding_force(1000.0, 94.5e3, lj.load(out))
    assert float(held) > float(lj.holding_force(94.5e3, lj.load(out)))
    # without holds nothing can be said
    (folder / (files[0].name + ".toml")).unlink()
    partly = lj.ageing(files, hold=10.0, test={"normal_force": "2.45 N"})
    assert list(partly.refused) == [str(files[0])] and partly.exit_code == 3
    with pytest.raises(LayerjamError, match="give both"):
        lj.ageing(files, out=out)


def _written(tmp_path: Path) -> Path:
    path = tmp_path / "spec.toml"
    path.write_text(
        'seed = 3\n[[brakes]]\nbrake = "choi2018-kapton"\nstatic = 0.31\nageing = 0.025\n'
        'static_hold = "10 s"\n[pulls]\nvacuums = []\n[friction]\nrepeats = 3\n'
        'holds = ["1 s", "10 s", "100 s", "1000 s"]\nstatic_scatter = 0.02\n',
        encoding="utf-8",
    )
    return path
