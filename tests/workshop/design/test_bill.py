"""The bill of a design: film, plastic and mass as drawn, against `build` and by hand."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import layerjam as lj
from layerjam.brake.device.load import load
from layerjam.core.errors import QuantityError
from layerjam.workshop.commands.build import _judge_drawing
from layerjam.workshop.commands.design import brake_of
from layerjam.workshop.design.bill import drawn_merits
from layerjam.workshop.design.blocks import encode_block, fingerprint
from layerjam.workshop.design.grid import Kernel
from layerjam.workshop.design.merit import DRAWN_MERITS
from layerjam.workshop.design.search import Search
from layerjam.workshop.design.specification import read_spec
from layerjam.workshop.fabricate.choices import resolve_choices

VARIED = """
brake = "choi2018-kapton"
without = ["buildable", "drawn_mass"]
constraints = [{constraints}]
objectives = [{objectives}]
[vary]
count = [6, 7, 10, 11]
width = {{ from = "11 mm", to = "17 mm", step = "2 mm" }}
overlap = ["50 mm", "68 mm"]
free_right = ["11 mm", "14 mm"]
vacuum = ["60 kPa", "94.5 kPa"]
parallel = [1, 3]
"""


def spec(*constraints: str, objectives: tuple[str, ...] = ("minimise film_area",)):
    quoted = [", ".join(f'"{word}"' for word in words) for words in (constraints, objectives)]
    return read_spec(VARIED.format(constraints=quoted[0], objectives=quoted[1]), "spec")


@pytest.fixture(scope="module")
def found():
    return lj.design(spec("holding_force >= 150 N", objectives=("maximise energy_density",)))


def test_a_designs_bill_is_the_builds_own(found) -> None:
    """Film, plastic and mass of designs of the whole grid, one brake and three, by `build`."""
    search = found.record.search
    numbers = np.random.default_rng(3).choice(search.spec.grid.size, 12, replace=False)
    rows = search.designs(np.sort(numbers))
    assert {row["parallel"] for row in rows} == {1, 3}
    assert {row["count"] % 2 for row in rows} == {0, 1}
    for row in rows:
        file, parallel = brake_of(found, row["number"]), int(row["parallel"])
        said = _judge_drawing(file, resolve_choices(file), parallel, int(row["series"]))
        assert said.film_area == pytest.approx(row["film_area"], rel=1e-9)
        assert said.printed_volume == pytest.approx(row["print_volume"], rel=1e-9)
        assert said.mass == pytest.approx(row["drawn_mass"], rel=1e-9)


def test_designs_that_differ_only_in_their_vacuum_are_drawn_once(found) -> None:
    """What is drawn once has the merits that each design has by itself, and none without vacuum."""
    spec = found.record.search.spec
    axes = {**spec.grid.axes, "vacuum": np.array([60e3, 94.5e3, 2e5])}
    grid, drawn = replace(spec.grid, axes=axes), []

    def draw(brake, force):
        drawn.append(np.size(force))
        return spec.evaluation.draw(brake, force)

    kernel = Kernel(grid, replace(spec.evaluation, draw=draw))
    numbers = np.arange(grid.size)
    merits = kernel.drawn_merits(numbers)
    assert sum(drawn) == grid.size / 3
    evaluation = spec.evaluation
    alone = drawn_merits(grid.point(numbers), evaluation.base, evaluation.draw, grid.size)
    vacuums = grid.columns(numbers)["vacuum"]
    for name in DRAWN_MERITS:
        assert np.array_equal(merits[name], alone[name], equal_nan=True)
        assert np.isnan(merits[name][vacuums == 2e5]).all()
        assert np.isfinite(merits[name][vacuums < 2e5]).any()


def test_the_indices_of_a_design_are_those_of_numpy(found) -> None:
    grid = found.record.search.spec.grid
    numbers = np.arange(grid.size)
    for mine, expected in zip(
        grid.digits(numbers), np.unravel_index(numbers, grid.shape), strict=True
    ):
        assert np.array_equal(mine, expected)
    for outside in (-1, grid.size, np.array([0, -1]), np.array([0, grid.size])):
        with pytest.raises(IndexError, match=f"numbered from 0 to {grid.size - 1}"):
            grid.digits(outside)


def test_between_the_steps_too(found) -> None:
    file = brake_of(found)
    said = _judge_drawing(file, resolve_choices(file), int(found.refined["parallel"]), 1)
    for own, key in (("film_area", "film_area"), ("drawn_mass", "mass")):
        assert found.refined[own] == pytest.approx(getattr(said, key), rel=1e-9)


def by_hand(count: int, width: float, length: float, clamped: float) -> float:
    """Film [mm²] of a brake with equal ends: corners of 1 and 0.5 mm, holes of 3 mm."""
    screws = max(1, round(width / 20))
    holes, round_off = screws * math.pi * 9 / 4, 2 - math.pi / 2
    sheet = length * width - round_off * (1 + 0.25) - holes
    spacer = clamped * width - round_off * 0.5 - holes
    return count * (sheet + spacer)


def test_the_papers_brake_by_hand() -> None:
    """The numbers of the specification: volumes as printed there, masses summed up by hand."""
    held = spec(objectives=("maximise energy_density",))
    row = Search(lj.design(held, confidence=None).record.spec)
    number = next(
        n
        for n in range(held.grid.size)
        if (v := held.grid.values(n))["count"] == 11
        and (v["width"], v["overlap"], v["free_right"], v["parallel"]) == (0.013, 0.068, 0.011, 1)
    )
    design = row.design(number)
    assert design["film_area"] == pytest.approx(by_hand(11, 13, 85, 6) * 1e-6, rel=1e-12)
    volumes = 2 * (3613.35961 + 276.39516) + 38074.80927 + 37748.55487 + 5666.232
    assert design["print_volume"] == pytest.approx(volumes * 1e-9, rel=1e-9)
    sheets = by_hand(11, 13, 85, 6) * 0.254 * 1.42e-6
    enclosure = (15 * 4.794 - 13 * 2.794) * 126 * 1.07e-6
    plastic = 2 * (3613.35961 + 276.39516) * 1.15e-6
    head, shank = math.pi / 4 * 5.5**2 * 3, math.pi / 4 * 9 * 8
    nut = (math.sqrt(3) / 2 * 5.5**2 - math.pi / 4 * 9) * 2.4
    steel = 2 * (0.9 * (head + shank) + nut) * 7.85e-6
    assert design["drawn_mass"] == pytest.approx(sheets + enclosure + plastic + steel, rel=1e-8)


def test_an_objective_of_film_is_the_least_of_all() -> None:
    """Every design by itself, the film by hand; nothing is approximated."""
    made = lj.design(spec("holding_force >= 150 N", "free_right <= 11 mm"), confidence=None)
    grid, base = made.record.spec.grid, load("choi2018-kapton").brake
    best = math.inf
    for number in range(grid.size):
        v = grid.values(number)
        film = base.film
        force = film.static * 0.875 * (v["count"] - 1) * v["width"] * v["overlap"] * v["vacuum"]
        if v["parallel"] * force >= 150 and v["free_right"] <= 0.011:
            length = (v["overlap"] + 0.011 + 0.006) * 1e3
            area = v["parallel"] * by_hand(v["count"], v["width"] * 1e3, length, 6.0)
            best = min(best, area)
    assert made.chosen["film_area"] == pytest.approx(best * 1e-6, rel=1e-9)
    assert made.refined["film_area"] <= made.chosen["film_area"]
    slopes = made.sensitivities["film_area"]
    # area = n (L + c - ...) W - corners and holes
    assert slopes["overlap"] == pytest.approx(
        made.chosen["count"] * made.chosen["width"] * made.chosen["overlap"]
        / made.chosen["film_area"], rel=1e-4,
    )  # fmt: skip
    assert slopes["vacuum"] == slopes["static"] == 0


def test_a_limit_on_the_drawn_mass_holds_and_is_named_where_it_cannot() -> None:
    goals = ("maximise energy_capacity", "minimise print_volume")
    made = lj.design(spec("drawn_mass <= 40 g", objectives=goals))
    assert made.feasible and all(row["drawn_mass"] <= 0.040 for row in made.front)
    costs = np.array([(-r["energy_capacity"], r["print_volume"]) for r in made.front])
    for one, other in itertools.permutations(costs, 2):
        assert not (one <= other).all()
    assert any(f["constraint"].startswith("drawn_mass") for f in made.forbidden)
    none = lj.design(spec("drawn_mass <= 5 g", objectives=goals))
    assert none.exit_code == 1 and "drawn_mass" in none.killed_by
    least = min(r["drawn_mass"] for r in lj.design(spec(objectives=("minimise drawn_mass",))).front)
    assert none.reachable == pytest.approx(least)


def test_what_cannot_be_drawn_has_no_bill_and_is_not_chosen() -> None:
    """A nut of M3 with its walls needs 8.1 mm of width; a model of the brake needs none."""
    wide = '{{ from = "11 mm", to = "17 mm", step = "2 mm" }}'
    narrow = VARIED.replace(wide, '["7 mm", "9 mm"]')
    light = 'objectives = ["minimise mass"]'

    def design(text: str):
        return lj.design(
            read_spec(text.format(constraints="", objectives='"minimise drawn_mass"'), "s")
        )

    made = design(narrow)
    search = Search(made.record.spec)
    assert math.isnan(search.design(0)["drawn_mass"]) and search.design(0)["width"] == 0.007
    assert made.chosen["width"] == 0.009
    assert made.feasible_designs == made.designs  # the brake itself can be used
    plain = design(narrow.replace("objectives = [{objectives}]", light))
    assert plain.chosen["width"] == 0.007 and math.isnan(plain.chosen["drawn_mass"])
    none = design(narrow.replace(', "9 mm"', ""))
    assert none.exit_code == 1 and "drawn_mass" in none.reason and "fit together" in none.reason


def test_blocks_on_disk_hold_what_was_asked() -> None:
    asked, held = spec("drawn_mass <= 40 g"), spec("mass <= 40 g", objectives=("minimise mass",))
    search = Search(lj.design(asked).record.spec)
    assert search.spec.drawn_merits == ("film_area", "drawn_mass")
    from layerjam.workshop.design.blocks import decode_block

    mark = fingerprint(search.spec, search.size)
    back = decode_block(search, encode_block(search, 0, search.run_block(0), mark), mark, 0)
    assert back is not None and np.isfinite(back.asked).any()
    for at, number in enumerate(back.numbers.tolist()):
        design = search.design(number)
        for name, row in zip(search.wanted, back.asked[:-1], strict=True):
            assert row[at] == design[name] or math.isnan(row[at])
    other = replace(search.spec.evaluation.draw.build, wall=2e-3)
    moved = replace(search.spec.evaluation, draw=replace(search.spec.evaluation.draw, build=other))
    assert fingerprint(replace(search.spec, evaluation=moved), search.size) != mark
    # who asks for none of it sweeps as before, whatever the workshop
    plain = lj.design(held, confidence=None).record.spec
    assert fingerprint(plain, 1) == fingerprint(held, 1) and plain.drawn_merits == ()


def test_without_what_draws_it_is_refused() -> None:
    with pytest.raises(QuantityError, match="film_area"):
        Search(spec())
    assert all(math.isnan(Search(spec("mass <= 1 kg", objectives=("minimise mass",))).design(0)[n])
               for n in DRAWN_MERITS)  # fmt: skip


def test_a_designed_brake_keeps_what_is_known_of_making_it(found) -> None:
    file = brake_of(found, found.chosen["number"])
    assert file.making == load("choi2018-kapton").making
    assert file.sources["film.laser"].conflict
    other = VARIED.replace("[vary]", '[[film]]\nuse = "ptfe"\nthickness = "0.25 mm"\n[vary]')
    made = lj.design(
        read_spec(other.format(constraints="", objectives='"maximise force_density"'), "s")
    )
    file = brake_of(made, made.chosen["number"])
    assert (file.making.film.laser, file.making.film.product) == ("never", "PTFE film")
    assert file.making.enclosure.mix == "1A:1B"
