"""`calibrate --within`: what is asked is answered, and nothing else changes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

import layerjam as lj
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Trace


def pull(factor: float, vacuum: float, seed: int) -> Trace:
    file = lj.load("choi2018-kapton").with_(scale_factor=factor)
    u = np.linspace(0, 0.03, 1500)
    force = np.asarray(lj.laws.force_at_elongation(u, vacuum, file.brake))
    force = force + 0.05 * np.random.default_rng(seed).standard_normal(len(u))
    facts = Facts(vacuum=vacuum, mounting=seed + 1, synthetic=True)
    return Trace(force, u, None, f"pull-{seed}.csv", "made here", facts=facts)


def test_how_many_more_pulls() -> None:
    factors = np.array([0.86, 0.87, 0.885, 0.875])
    vacuums = (94.5e3, 94.5e3, 60e3, 60e3)
    traces = [pull(a, p, k) for k, (a, p) in enumerate(zip(factors, vacuums, strict=True))]
    known = lj.load("choi2018-kapton").with_(force_uncertainty=0)
    plain = lj.calibrate(known, traces)
    asked = lj.calibrate(known, traces, within="0.5 %")
    assert plain.more_pulls is None and asked.scale_factor == plain.scale_factor
    row = asked.more_pulls["scale_factor"]
    spread = factors.std(ddof=1) / factors.mean()
    assert row["half_width"] == pytest.approx(stats.t.ppf(0.975, 3) * spread / 2, rel=0.05)
    least = next(
        m for m in range(200) if stats.t.ppf(0.975, 3 + m) * spread / (4 + m) ** 0.5 <= 0.005
    )
    assert abs(row["likely"] - least) <= 1 + 0.1 * least and row["sure"] > row["likely"]
    assert "any of these vacuums" in str(asked)
    single = lj.calibrate("choi2018-kapton", traces[:1], within="0.5 %")
    assert single.more_pulls["scale_factor"] is None and "repeat one of them" in str(single)
