"""`design` asks what `build` asks: nothing that it proposes is refused there."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import layerjam as lj
from counts import cases
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.limits import greatest_force
from layerjam.brake.simulate.prediction import Deviations, change_numbers
from layerjam.core.errors import FileError, LayerjamError
from layerjam.core.evolve import evolve
from layerjam.workshop.commands.build import judge_build
from layerjam.workshop.commands.design import brake_of
from layerjam.workshop.design.few_numbers import hold, stop
from layerjam.workshop.design.grid import Kernel
from layerjam.workshop.design.merit import is_buildable, make_brake
from layerjam.workshop.design.request import DesignRequest
from layerjam.workshop.design.requirements import BUILDABLE
from layerjam.workshop.design.search import Search
from layerjam.workshop.design.specification import make_specification, read_spec

TINY = """
brake = "choi2018-kapton"
constraints = ["mass <= 30 g"]
objectives = ["minimise mass"]
[vary]
width = ["7 mm", "13 mm"]
"""
MIXED = """
brake = "choi2018-kapton"
constraints = ["holding_force >= 50 N"]
objectives = ["maximise energy_density"]
[vary]
count = [6, 7, 24, 41]
width = { from = "7 mm", to = "67 mm", step = "4 mm" }
thickness = ["25 um", "127 um", "254 um"]
overlap = ["50 mm", "68 mm"]
free_right = ["11 mm", "14 mm"]
vacuum = ["60 kPa", "94.5 kPa"]
parallel = [1, 3]
"""


def test_a_nut_that_does_not_fit_rules_a_width_out() -> None:
    """The lighter brake is 7 mm wide, and a nut of M3 with its walls needs 8.1 mm."""
    text = TINY.replace("mass <= 30 g", "holding_force >= 10 N")
    made = lj.design(read_spec(text, "tiny"))
    assert made.chosen["width"] == 0.013 and made.chosen["buildable"] >= 1
    (kept,) = (row for row in made.forbidden if row["constraint"] == "buildable")
    assert kept["design"]["width"] == 0.007 and kept["value"] <= 7 / 8.1 * (1 + 1e-6)
    assert "C4: 7 mm of width per screw" in kept["reason"]
    free = lj.design(read_spec(text.replace("[vary]", 'without = "buildable"\n[vary]'), "tiny"))
    assert free.chosen["width"] == 0.007


def test_both_defaults_are_off_by_name() -> None:
    from layerjam.workshop.commands.design import _read_spec

    def rules(more: str = "") -> list[str]:
        spec = read_spec(TINY.replace("[vary]", f"{more}\n[vary]"), "tiny")
        return [str(c) for c in _read_spec(spec, {}).constraints]

    assert rules() == ["drawn_mass <= 30 g", "buildable"]
    assert rules('without = ["buildable"]') == ["drawn_mass <= 30 g"]
    assert rules('without = ["drawn_mass"]') == ["mass <= 30 g", "buildable"]
    assert rules('without = ["buildable", "drawn_mass"]') == ["mass <= 30 g"]
    with pytest.raises(FileError, match="without"):
        rules('without = ["everything"]')
    assert BUILDABLE.is_met(1.0) and not BUILDABLE.is_met(0.999) and not BUILDABLE.is_met(math.nan)


def refused(made, number: int | None) -> str | None:
    """Why `build` refuses one design; it may also be an error about the file."""
    try:
        file = brake_of(made, number)
        found = judge_build(file)
    except LayerjamError as error:
        return str(error)
    return found.reason


@pytest.mark.slow
def test_the_margin_agrees_with_the_build_of_any_design() -> None:
    made = lj.design(read_spec(MIXED, "mixed"), confidence=None)
    search = made.record.search
    numbers = np.random.default_rng(7).choice(search.spec.grid.size, 120, replace=False)
    rows = search.designs(np.sort(numbers))
    for row in rows:
        why = refused(made, row["number"])
        assert (row["buildable"] >= 1) == (why is None), (row, why)
    good = [row["buildable"] >= 1 for row in rows]
    assert 10 < sum(good) < 110
    assert refused(made, None) is None


def some_requests(seed: int, count: int) -> list[DesignRequest]:
    """Random needs: to hold with little mass, or to stop a mass."""
    rng = np.random.default_rng(seed)
    made = []
    for number in range(count):
        name = ("choi2018-kapton", "choi2018-polyester", "choi2018-ptfe")[number % 3]
        file, force = load(name), float(np.exp(rng.uniform(np.log(20), np.log(600))))
        margin = 0.0 if file.brake.film.strength is None else 1.5
        if number % 5:
            made.append(
                hold(
                    file, name,
                    force=force,
                    mass=float(rng.uniform(0.02, 0.15)),
                    width=float(rng.uniform(0.012, 0.06)),
                    length=float(rng.uniform(0.14, 0.3)),
                    stress_margin=margin,
                )
            )  # fmt: skip
        else:
            speed, mass = float(rng.uniform(0.5, 2)), float(rng.uniform(0.5, 5))
            travel = float(rng.uniform(0.03, 0.15))
            least = mass * speed**2 / (2 * travel)
            made.append(
                stop(
                    file, name, mass=mass, speed=speed, travel=travel,
                    force=float(rng.uniform(3, 10)) * least, stress_margin=margin,
                )
            )  # fmt: skip
    return made


@pytest.mark.campaign
def test_what_random_requests_propose_is_built() -> None:
    """The chosen design, the runner-up and the refined one, each by `build`; none is refused."""
    proposed = 0
    count = cases(50, 3)
    for request in some_requests(11, count):
        made = lj.design(make_specification(request), confidence=None)
        if not made.feasible:
            continue
        numbers = [row["number"] for row in (made.chosen, made.runner_up) if row]
        for number in [*numbers, *([None] if made.refined else [])]:
            assert refused(made, number) is None, (request.title, number)
            proposed += 1
        print(request.title, proposed, flush=True)
    assert proposed >= 1.2 * count


@pytest.mark.slow
def test_the_request_whose_proposals_were_refused() -> None:
    """Hold 150 N with 25 g: as drawn, ties and fittings aside."""
    kapton = load("choi2018-kapton")
    asked = hold(
        kapton, "choi2018-kapton", force="150 N", mass="25 g", width="30 mm", length="120 mm"
    )
    made = lj.design(make_specification(asked), confidence=None)
    assert made.feasible
    for row in (made.chosen, made.runner_up, made.refined):
        assert row["drawn_mass"] <= 0.025 * (1 + 1e-9)
    for number in (made.chosen["number"], made.runner_up["number"], None):
        file = brake_of(made, number)
        found = judge_build(file)
        assert found.feasible and found.mass <= 0.025 * (1 + 1e-9)


def row_of_one(record):
    """Return a record whose numbers are arrays of one item."""
    values = {f.name: getattr(record, f.name) for f in dataclasses.fields(record)}
    numbers = {k: np.array([float(v)]) for k, v in values.items() if isinstance(v, float | int)
               or (isinstance(v, np.ndarray | np.generic) and np.ndim(v) == 0)}  # fmt: skip
    return evolve(record, **numbers)


def test_samples_of_a_drawing_are_those_of_brakes_drawn_one_by_one() -> None:
    """With plastic of 12 MPa, some brakes of a design are refused, by their friction."""
    from layerjam.workshop.commands.design import _read_spec

    spec = evolve(read_spec(MIXED, "mixed"), confidence=0.9)
    look = Search(_read_spec(spec, {}))
    evaluation, numbers = look.spec.evaluation, np.arange(look.spec.grid.size)
    evaluation = evolve(
        evaluation,
        draw=evolve(evaluation.draw, build=evolve(evaluation.draw.build, print_strength=12e6)),
    )
    kernel = Kernel(look.spec.grid, evaluation)
    samples = Deviations(*(row[0, :8, None] for row in look.samples.deviations))
    rows = kernel.drawn_merits(numbers, samples)["buildable"]
    drawn, differ = 0, 0
    for number in numbers[::37]:
        point = look.spec.grid.point(number)
        for sample, margin in enumerate(rows[:, number]):
            logs = Deviations(*(float(row[sample, 0]) for row in samples))
            brake = change_numbers(make_brake(point, evaluation.base), logs)
            if not is_buildable(point, brake):
                assert math.isnan(margin)
                continue
            alone = evolve(brake, sheets=row_of_one(brake.sheets), film=row_of_one(brake.film))
            wall = np.array([brake.enclosure.wall])
            alone = evolve(alone, enclosure=evolve(brake.enclosure, wall=wall), weighed_mass=None)
            bill = evaluation.draw(alone, np.array([greatest_force(brake)]))
            assert margin == pytest.approx(bill.margin[0], rel=1e-9, nan_ok=True)
            drawn += 1
        differ += np.ptp(rows[:, number]) > 1e-3
    assert drawn > 100 and differ > 5
