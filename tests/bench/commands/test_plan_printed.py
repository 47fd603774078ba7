"""What `plan` prints is enough if it is typed again: over random collisions, and at knife edges."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from counts import cases
from layerjam.brake.device.load import load
from layerjam.brake.fluid.line import Reservoir
from layerjam.core.units import QuantitySpec, show_at_least

EDGE = {"mass": "7 kg", "speed": 0.3, "travel": "60 mm"}


@pytest.mark.parametrize("unit", ["Pa", "s", "m^3", "m^3/(s Pa)", "1"])
def test_a_value_rounded_up_is_never_below(unit: str) -> None:
    random, spec = np.random.default_rng(3), QuantitySpec(unit, "a quantity", lo=-math.inf)
    for value in np.exp(random.uniform(-20, 13, 300)).tolist():
        text = show_at_least(value, unit)
        typed = float(text) if unit == "1" else spec.read(text, "value")
        assert Fraction(typed) >= Fraction(value) * (1 - Fraction(1, 10**15))
        assert typed <= value * 1.0011
    assert (
        spec.read(show_at_least(101324.9, "Pa", 101325.0), "p") <= 101325.0 if unit == "Pa" else 1
    )


def test_rounding_up_stays_below_the_greatest_value() -> None:
    assert show_at_least(101324.9, "Pa", 101325.0) == "101.325 kPa"


def plans(count: int, seed: int) -> Any:
    """Random collisions with a short warning, and what `plan` answers."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        case = {
            "mass": float(random.uniform(0.2, 6)),
            "speed": float(random.uniform(0.3, 3)),
            "travel": float(random.uniform(0.01, 0.06)),
            "warning": float(random.uniform(0.02, 3)),
            "horizontal": bool(random.integers(2)),
        }
        yield case, lj.plan("choi2018", "choi2018-kapton", samples=100, **case)


def check_printed(case: dict[str, Any], made: Any) -> int:
    """Type every size of one plan again; the number that were typed."""
    printed = dict(made.rows())
    known = {k: v for k, v in case.items() if k != "warning"}
    count = 0
    if made.tuned_capped:
        assert printed["tuned vacuum"] == printed["reached"]
    if made.needed:
        shown = {k: v for k, v in known.items() if k != "travel"}
        stop = lj.drop("choi2018-kapton", vacuum=printed["needed"], **shown)
        assert stop.outcome in ("STOPPED", "NEVER_SLID")
        assert stop.slip <= case["travel"] * (1 + 1e-9)
        count += 1
    if made.warning_needed is not None:
        again = lj.plan(
            "choi2018",
            "choi2018-kapton",
            samples=100,
            **{**known, "warning": printed["warning needed"]},
        )
        assert again.feasible
        count += 1
    if made.standing_needed:
        again = lj.plan(
            "choi2018", "choi2018-kapton", samples=100, standing=printed["standing needed"], **case
        )
        assert again.feasible
        count += 1
    if made.reservoir_needed is not None:
        volume = QuantitySpec("m^3", "volume").read(printed["reservoir needed"], "volume")
        file = lj.load_line("choi2018")
        tank = Reservoir(volume=volume, conductance=made.reservoir_conductance, delay=0.01)
        line = replace(file, line=replace(file.line, reservoir=tank))
        assert lj.plan(line, "choi2018-kapton", samples=100, **case).feasible
        count += 1
    return count


def test_printed_sizes_typed_again_do() -> None:
    assert sum(check_printed(*one) for one in plans(5, 1)) > 5


@pytest.mark.slow
def test_printed_sizes_of_many_plans_typed_again_do() -> None:
    assert sum(check_printed(*one) for one in plans(cases(75, 25), 2)) >= cases(80, 25)


def test_a_knife_edge_is_named_with_its_margin() -> None:
    """A mass that barely stands: 1 ppm less vacuum and it runs to the end (found by halving)."""
    made = lj.plan("choi2018", "choi2018-kapton", warning=3, samples=100, **EDGE)
    low, high = 0.0, 101325.0
    for _ in range(60):
        middle = (low + high) / 2
        case = {k: v for k, v in EDGE.items() if k != "travel"}
        ends = lj.drop("choi2018-kapton", vacuum=middle, **case).outcome == "BOTTOMED_OUT"
        low, high = (middle, high) if ends else (low, middle)
    assert made.needed == pytest.approx(high, rel=1e-9)
    assert made.knife_edge and made.safe_vacuum > made.needed * 1.02
    (failed,) = made.failed_checks
    assert made.exit_code == 4 and failed["name"] == "knife edge"
    assert show_at_least(made.safe_vacuum, "Pa") in failed["reason"]
    kept = lj.plan(
        "choi2018", "choi2018-kapton", warning=3, samples=100, **EDGE, accept={"knife edge": "why"}
    )
    assert kept.exit_code == 0 and kept.verdict == "accepted"
    for mass, speed, share in ((7.14, 0.306, 0.98), (7.0, 0.3, 0.98), (7.14, 0.306, 1.0)):
        stop = lj.drop("choi2018-kapton", mass=mass, speed=speed, vacuum=made.safe_vacuum * share)
        assert stop.outcome == "STOPPED" and stop.slip <= 0.06


def test_an_ordinary_plan_is_no_knife_edge() -> None:
    made = lj.plan(
        "choi2018", "choi2018-kapton", mass=1, speed=2.5, travel=0.04, warning=3, samples=100
    )
    assert made.knife_edge is False and made.needed * 1.02 < made.safe_vacuum < made.reached
    assert made.verdict == "passed" and {c["level"] for c in made.checks} == {"passed"}


@pytest.mark.parametrize(("share", "code"), [(0.9, 4), (1.1, 0)])
def test_a_plan_fails_if_its_peak_tears_the_sheets(share: float, code: int) -> None:
    """Strength as a share of the stress by hand: the peak force over the sheets of one side."""
    ordinary = {"mass": 1, "speed": 2.5, "travel": 0.04, "warning": 3, "samples": 100}
    file = load("choi2018-kapton")
    made, sheets = lj.plan("choi2018", file, **ordinary), file.brake.sheets
    section = sheets.count // 2 * sheets.width * sheets.thickness
    peak = max(made.record.full.peak_force, made.record.tuned.peak_force)
    weak = lj.plan("choi2018", file.with_(strength=share * peak / section), **ordinary)
    assert weak.exit_code == code
    assert [one["name"] for one in weak.failed_checks] == ["sheet strength"] * (code == 4)
