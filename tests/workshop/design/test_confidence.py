"""The share of brakes that meet a constraint, against closed forms and an independent draw."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.stats import norm

import layerjam as lj
from layerjam.brake.simulate import prediction
from layerjam.core.evolve import evolve
from layerjam.workshop.design import search
from layerjam.workshop.design.robust import assess
from workshop.design.test_design import LIGHT, SMALL, read


def chances_of(asked, **at):
    """Return the chances of one design, which has the first design's other values."""
    point = asked.grid.point(0)._replace(count=11.0, width=0.013, overlap=0.068, vacuum=80e3)
    point = point._replace(**at)
    values = {"film": asked.grid.names[0], "clamped_length": 0.1}
    return assess(asked, point, values)


def test_the_chance_to_hold_is_that_of_an_independent_monte_carlo():
    """The hold is the product of static friction and scale factor, each log-normal."""
    asked = read(SMALL.replace('"holding_force >= 150 N"', '"holding_force >= 190 N"'))
    found = chances_of(asked)
    held = 0.875 * 0.32 * 10 * 0.013 * 0.068 * 80e3
    random = np.random.default_rng(5)
    static, fit, repeat, pressure = random.standard_normal((4, 400_000))
    spread = math.sqrt(math.log1p(0.0818**2))
    beyond = 0.06 * math.log(80e3 / 101325) * pressure
    drawn = held * np.exp(spread * static + math.log(2) / 1.96 * fit + 0.03 * repeat + beyond)
    chance = found.chances["holding_force >= 190 N"]
    assert 0.5 < chance.probability < 0.7
    assert chance.probability == pytest.approx((drawn >= 190).mean(), abs=0.01)
    # the quantile of 1000 samples has a standard error of 2.5 %
    assert chance.low == pytest.approx(np.quantile(drawn, 0.05), rel=0.05)
    assert chances_of(asked).chances == found.chances
    assert found.prediction.basis.word == "handbook"


def test_the_lines_of_a_design_show_the_interval_of_its_hold(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SMALL, encoding="utf-8")
    result = lj.design(path)
    made = result.chosen
    held = 0.875 * 0.32 * (made["count"] - 1) * made["width"] * made["overlap"] * made["vacuum"]
    assert made["holding_force"] == pytest.approx(held)
    random = np.random.default_rng(6)
    static, fit, repeat, pressure = random.standard_normal((4, 400_000))
    spread = math.sqrt(math.log1p(0.0818**2))
    beyond = 0.06 * math.log(made["vacuum"] / 101325) * pressure
    drawn = held * np.exp(spread * static + math.log(2) / 1.96 * fit + 0.03 * repeat + beyond)
    (line,) = (line for line in result.lines() if line.startswith("  holding_force: "))
    value, *ends = map(float, re.findall(r"([0-9.]+) N\b", line)[:3])
    assert value == pytest.approx(held, rel=1e-3)
    # the quantile of 1000 samples has a standard error of 2.5 %
    assert ends == pytest.approx(list(np.quantile(drawn, (0.025, 0.975))), rel=0.05)
    (line,) = (line for line in result.lines() if line.startswith("  mass: "))
    assert "95 %" not in line


def test_a_scatter_of_the_specification_replaces_that_of_the_film():
    text = SMALL + '[scatter]\nstatic = "30 %"\nsamples = 4000\n'
    asked = read(text.replace('"holding_force >= 150 N"', '"holding_force >= 190 N"'))
    found = chances_of(asked)
    held = 0.875 * 0.32 * 10 * 0.013 * 0.068 * 80e3
    width = math.sqrt(math.log1p(0.3**2) + (math.log(2) / 1.96) ** 2 + 0.03**2)
    due = norm.cdf(math.log(held / 190) / width)
    assert found.prediction.samples == 4000
    chance = found.chances["holding_force >= 190 N"]
    assert chance.probability == pytest.approx(due, abs=4 * chance.error)


@pytest.mark.parametrize(("limit", "due"), [("180 N", 1.0), ("199 N", 0.0)])
def test_without_any_spread_a_constraint_is_met_or_not(monkeypatch, limit, due):
    monkeypatch.setattr(prediction, "list_unknowns", lambda file: ())
    monkeypatch.setattr(prediction, "exponent_sd", lambda fit: 0.0)
    monkeypatch.setattr(prediction, "SPEED_SD", 0.0)
    asked = read(SMALL.replace('"holding_force >= 150 N"', f'"holding_force >= {limit}"'))
    found = chances_of(asked)
    assert found.chances[f"holding_force >= {limit}"].probability == due
    assert found.reaches(0.999) == (due == 1.0)


def test_design_judges_the_next_brake_whichever_interval_it_prints(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SMALL, encoding="utf-8")
    following, mean = (lj.design(path, interval=of) for of in ("next", "mean"))
    (low, high), (inner, outer) = (r.interval("holding_force") for r in (following, mean))
    assert low < inner < outer < high
    assert (mean.chosen, mean.robustness) == (following.chosen, following.robustness)
    assert mean.intervals["holding_force"]["of"] == "mean"


@pytest.mark.parametrize(
    ("hold", "confidence"), [(150, 0.5), (150, 0.9), (120, 0.98), (170, 0.95), (178, 0.95)]
)
def test_probabilities_left_out_change_no_highlight(monkeypatch, hold, confidence):
    """Against the probabilities of all designs, with the choice from a list in plain Python."""
    monkeypatch.setattr(search, "FIRST_LOOK", 2)
    monkeypatch.setattr(search, "FAMILIES", 3)
    text = SMALL.replace("holding_force >= 150 N", f"holding_force >= {hold} N")
    look = search.Search(evolve(read(text), confidence=confidence))
    run = look.run_chunk(0, look.spec.grid.size)
    picks = look.find_highlights(run)
    every = np.arange(look.spec.grid.size)
    force, mass, work, length = (
        look.kernel.all_merits(every)[look.row[name]]
        for name in ("holding_force", "mass", "energy_capacity", "clamped_length")
    )
    fits = every[(force >= hold) & (length <= 0.110)]
    chance = dict(zip(fits, look.samples.find_probabilities(fits), strict=True))
    score = dict(zip(fits, np.log(mass[fits] / work[fits]), strict=True))
    family = dict(zip(fits, look.families(fits), strict=True))
    due = set()
    for steps in range(search.SURER):
        first = {}
        for k in sorted(fits, key=lambda k: (score[k], k)):
            if chance[k] >= confidence + steps / 64 - 1e-9:
                first.setdefault(family[k], k)
        due |= {*[*first.values()][:3]}
    known = dict(zip(run.numbers, run.asked[-1], strict=True))
    assert all(known[k] == chance[k] for k in known if not math.isnan(known[k]))
    assert not any(math.isnan(known[k]) for k in run.numbers[picks.front])
    if due:
        assert {*run.numbers[picks.best]} == due
    else:
        assert chance[run.numbers[picks.surest]] == max(chance.values()) < confidence


def test_a_design_without_a_score_hides_no_other_of_its_family(monkeypatch):
    """An objective of zero has no logarithm, and such a design is not chosen."""
    monkeypatch.setattr(search, "FIRST_LOOK", 1)
    look = search.Search(evolve(read(LIGHT), confidence=0.5))
    run = look.run_chunk(0, look.spec.grid.size)
    every = np.arange(look.spec.grid.size)
    family = look.families(every)
    # the best of another family than that of the front, whose probability is always computed
    picks = look.find_highlights(run)
    highlighted = run.numbers[picks.best]
    best = int(highlighted[family[highlighted] != family[highlighted[0]]][0])
    values = dict(zip(look.spec.merits, look.kernel.all_merits(every), strict=False))
    quantities = np.stack([values[name] for name in look.wanted])
    fits = look.check_constraints(quantities).all(axis=0)
    chance = look.samples.find_probabilities(every)
    is_sure = fits & (chance >= 0.5 + search.SURER / 64)
    (others,) = np.nonzero(is_sure & (family == family[best]) & (every != best))
    quantities[look.wanted.index("mass"), others[0]] = 0.0
    found = look._find_chances(look.samples, every, quantities, fits)
    assert found[best] >= 0.5
