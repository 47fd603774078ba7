"""What `tune` advises is built and tuned again, as a user would: it must do."""

from __future__ import annotations

import os
import re
from collections import Counter
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from counts import cases
from layerjam.bench.commands.plan import plan
from layerjam.brake.commands.drop import drop
from layerjam.brake.commands.tuning import TunedVacuum, tune
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.simulate.tuned import Case, tuning_vacuum
from layerjam.core.errors import QuantityError
from layerjam.core.units import parse

G = 9.80665
QUANTITY = r"([\d.e+-]+ [a-z/µμ]+)"
KINDS: tuple[dict[str, Any], ...] = (
    {},
    {"stiffness_measured": None},
    {"pressure_exponent": -0.15, "test_pressure": 5e4},
)


def random_case(rng: np.random.Generator) -> tuple[Brake, dict[str, Any]]:
    """A brake, and a mass that it may or may not stop."""
    name = ("choi2018-kapton", "choi2018-ptfe")[int(rng.integers(2))]
    usable = rng.uniform(5e-3, 65e-3)
    brake = load(name).brake.with_(
        count=int(rng.integers(2, 60)),
        width=rng.uniform(5e-3, 40e-3),
        usable_travel=usable,
        scale_factor=10 ** rng.uniform(-0.5, 0.4),
        **KINDS[int(rng.choice(3, p=(0.7, 0.2, 0.1)))],
    )
    most = float(lj.peak(9e4, usable, brake).force)
    mass = most / G * 10 ** rng.uniform(-2.5, 0.3)
    energy = float(lj.slip_work(usable, 9e4, brake))
    case: dict[str, Any] = {
        "mass": mass,
        "speed": np.sqrt(2 * energy / mass) * 10 ** rng.uniform(-1.7, 0.5),
        "travel": usable * rng.uniform(0.02, 1),
        "horizontal": bool(rng.random() < 0.2),
        "rope_stiffness": None if rng.random() < 0.4 else 10 ** rng.uniform(2, 5),
    }
    return brake, case


def advised(answer: TunedVacuum) -> dict[str, list[str]]:
    """What the answer names as doing, from its sentence and its numbers."""
    said, found = answer.reason or "", {}
    found["travel"] = re.findall(rf"{QUANTITY} of travel", said)
    found["sheets"] = re.findall(r"(\d+) sheets(?= or| would)", said)
    found["brakes"] = re.findall(r"(\d+) brakes in parallel would", said)
    if "would suffice" in said and "none of" in said:
        found |= {"sheets": [], "brakes": []}
    ends = [e for pair in re.findall(rf"from {QUANTITY} to {QUANTITY} there", said) for e in pair]
    ends += re.findall(rf"stops up to {QUANTITY}", said)
    numbers = (answer.least_speed, answer.greatest_speed)
    found["speed"] = ends + [repr(v) + " m/s" for v in numbers if v is not None]
    given = {"travel": answer.travel_needed, "sheets": answer.sheets_needed}
    given["brakes"] = answer.brakes_needed
    for name, value in given.items():
        assert len(found[name]) == (value is not None), (name, said)
    return found


def followed(
    brake: Brake, case: dict[str, Any], name: str, text: str
) -> tuple[Brake, dict[str, Any]]:
    """The brake and the case of one who does as advised."""
    if name in ("travel", "speed"):
        return brake, case | {name: parse(text, "m" if name == "travel" else "m/s", name)}
    if name == "sheets":
        return brake.with_(count=int(text)), case
    n, rope = int(text), case["rope_stiffness"]
    return brake, case | {"mass": case["mass"] / n, "rope_stiffness": rope and rope / n}


def misses(brake: Brake, case: dict[str, Any], vacuum: float) -> float:
    """How far from a stop after just the travel it is, over the energy that is brought.

    Energy by quadrature of the force over the slip; infinite where the mass stops or the spring
    runs away before, or the brake does not hold the weight there.
    """
    slip = np.linspace(0, np.sqrt(case["travel"]), 4001) ** 2
    force = np.asarray(lj.brake_force(slip, vacuum, brake))
    rope = case["rope_stiffness"] or np.inf
    own = float(lj.stiffness_before_slip(brake))
    drawn = slip + force * (1 / rope + 1 / (brake.stiffness_measured or own))
    weight = 0.0 if case["horizontal"] else case["mass"] * G
    work = np.concatenate([[0.0], np.cumsum(np.diff(drawn) * (force[1:] + force[:-1]) / 2)])
    work += force[0] * (drawn[0] - slip[0]) / 2
    brought = case["mass"] * case["speed"] ** 2 / 2 + weight * drawn
    left = (brought - work) / brought
    if (left[:-1] < -1e-6).any() or (np.diff(drawn) <= -1e-12).any():
        return np.inf
    return float(abs(left[-1])) if force[-1] >= weight * (1 - 1e-6) else np.inf


def false_advice(count: int, seed: int) -> tuple[list[Any], Counter[str]]:
    """Advice that does not do when it is followed, and how much there was of each kind."""
    rng, wrong, met = np.random.default_rng(seed), [], Counter[str]()
    for _ in range(count):
        brake, case = random_case(rng)
        answer = tune(brake, **case, searches=("speeds", "alternatives"))
        met["tuned" if answer.feasible else "refused"] += 1
        for name, texts in advised(answer).items():
            for text in texts:
                met[name] += 1
                other, then = followed(brake, case, name, text)
                again = tune(other, **then, searches=())
                if again.vacuum is None or misses(other, then, again.vacuum) > 1e-5:
                    wrong.append((name, text, case, brake, answer.reason))
    return wrong, met


CASES = int(os.environ.get("LAYERJAM_ADVICE", cases(500, 120)))
"""Random cases of the slow test; 10,000 were run once and take some ten minutes."""


@pytest.mark.slow
def test_every_advice_of_many_random_cases_does():
    wrong, met = false_advice(CASES, seed=14)
    assert wrong == []
    least = CASES // 12
    assert min(met[k] for k in ("tuned", "refused", "travel", "sheets", "brakes", "speed")) > least


def test_what_would_be_too_slow_is_not_advised():
    answer = tune("choi2018-kapton", mass="12 kg", speed="0.1 m/s", travel="40 mm")
    # no number of sheets does, by hand: each is too weak to hold it or too strong to let it run
    case = {"mass": "12 kg", "speed": "0.1 m/s", "travel": "40 mm"}
    brake = load("choi2018-kapton").brake
    numbers = {"mass": 12.0, "speed": 0.1, "travel": 0.04, "gravity": brake.site.gravity}
    for n in range(2, 60):
        assert tuning_vacuum(Case(brake=brake.with_(count=n), rope=None, **numbers)) is None
    assert answer.sheets_needed is None and "sheets" not in answer.reason
    fewest = answer.brakes_needed
    share = [tune(brake, **case | {"mass": 12 / n}).feasible for n in range(2, fewest + 1)]
    assert share.index(True) == len(share) - 1
    assert tune(brake, **case | {"travel": answer.travel_needed}).feasible


def test_drop_and_plan_advise_as_tune_does():
    case: dict[str, Any] = {"mass": "1 kg", "speed": "5 m/s", "travel": "40 mm"}
    said = tune("choi2018-kapton", **case).reason
    assert drop("choi2018-kapton", vacuum="tuned", **case).reason == said
    planned = plan("choi2018", "choi2018-kapton", warning="3 s", **case)
    assert planned.reason == f"no vacuum available at the site is sufficient: {said}"


def test_without_the_speeds_everything_else_is_the_same() -> None:
    """The workbench leaves the search out; without a solution the reason needs it."""
    case = {"mass": "1 kg", "travel": "40 mm", "rope_stiffness": "16.8 kN/m"}
    for speed, ends in (("2.5 m/s", 2), ("6 m/s", 0)):
        whole = tune("choi2018-kapton", speed=speed, **case)
        short = tune("choi2018-kapton", speed=speed, searches=("safety", "alternatives"), **case)
        rows, others = dict(whole.rows()), dict(short.rows())
        left_out = [name for name, text in rows.items() if others.get(name) != text]
        assert left_out == ["least speed", "greatest speed"][:ends]


@pytest.mark.parametrize(
    ("searches", "words"),
    [
        (("speed",), "searches: .* is not allowed; list some of 'safety'"),
        ("speed", "searches: .* is not allowed; list some of 'safety'"),
        (5, "searches: 5 is not a list of text"),
    ],
)
def test_a_search_of_another_name_is_refused(searches: Any, words: str) -> None:
    with pytest.raises(QuantityError, match=words):
        tune("choi2018-kapton", mass="1 kg", speed="1.5 m/s", travel="40 mm", searches=searches)


@pytest.mark.parametrize("speed", ["0.05 m/s", "6 m/s"])
def test_the_basis_does_not_depend_on_the_other_searches(speed: str) -> None:
    case = {"mass": "12 kg", "speed": speed, "travel": "40 mm"}
    whole, alone = (
        tune("choi2018-kapton", **case),
        tune("choi2018-kapton", **case, searches=("safety",)),
    )
    assert not whole.feasible
    assert (alone.basis, alone.basis_reason) == (whole.basis, whole.basis_reason)
    assert alone.extrapolated == whole.extrapolated
