"""`length` is the length that `build` draws; the clamped length has a name of its own."""

from __future__ import annotations

import numpy as np
import pytest

import layerjam as lj
from layerjam.brake.device.workshop import Build
from layerjam.core.evolve import evolve
from layerjam.workshop.design.merit import make_point, merits
from layerjam.workshop.design.search import Search
from layerjam.workshop.design.specification import read_spec
from layerjam.workshop.design.verdict import binding_constraints
from layerjam.workshop.fabricate.lengths import compute_lengths

KAPTON = lj.load("choi2018-kapton")
FITTINGS = Build(port=4e-3, pin=8e-3, back=5e-3, gap=4e-3, plenum=2e-3)
OTHER = evolve(KAPTON, making=evolve(KAPTON.making, build=FITTINGS))
SPEC = """
brake = "choi2018-kapton"
constraints = ["length <= 160 mm"]
objectives = ["maximise holding_force"]
[vary]
overlap = { from = "40 mm", to = "80 mm", step = "1 mm" }
free_left = ["0.1 mm", "3 mm", "20 mm"]
offset = ["0 mm", "5 mm"]
series = [1, 2]
"""


@pytest.mark.parametrize("file", [KAPTON, OTHER], ids=["kapton", "other fittings"])
def test_the_length_of_a_brake_is_what_build_draws(file: lj.BrakeFile) -> None:
    build = file.making.build
    single = merits(make_point(file.brake, build=build), file.brake)
    drawn = compute_lengths(file.brake, build).overall / 1e3
    assert float(single["length"]) == pytest.approx(drawn, rel=1e-12)
    row = merits(make_point(file.brake, build=build)._replace(series=3.0), file.brake)
    # links keep the heads of neighbours at the distance of the film's parts
    assert float(row["length"]) == pytest.approx(3 * drawn + 2 * build.gap, rel=1e-12)


def test_the_length_of_each_design_is_what_build_draws_of_its_file() -> None:
    result = lj.design(read_spec(SPEC, "x"))
    search = result.record.search
    for number in np.random.default_rng(1).integers(0, search.spec.grid.size, 12).tolist():
        file = lj.brake_of(result, number)
        design = search.design(number)
        drawn = compute_lengths(file.brake, file.making.build).overall / 1e3
        gap = file.making.build.gap
        assert design["length"] == pytest.approx(
            design["series"] * drawn + (design["series"] - 1) * gap, rel=1e-9
        )
    assert result.chosen["length"] <= 0.160 * (1 + 1e-12)


def test_a_grid_edge_limits_a_design_unless_it_is_a_limit_of_its_own() -> None:
    spec = read_spec(SPEC, "x")
    search = Search(spec)
    design = evolve_design(search, overlap=0.08, free_left=1e-4, offset=0.0, series=1)
    words = binding_constraints(design, spec)
    assert "overlap 80 mm (largest of the grid)" in words
    # no free part is shorter than 0.1 mm, and no row has fewer brakes than one
    assert not any(w.startswith(("free_left", "offset", "series", "vacuum")) for w in words)
    inner = evolve_design(search, overlap=0.06, free_left=0.02, offset=0.005, series=2)
    words = binding_constraints(inner, spec)
    assert [w.split()[0] for w in words if "of the grid" in w] == ["free_left", "offset", "series"]


def evolve_design(search: Search, **values: float) -> dict[str, float]:
    """The design of the grid with these values."""
    grid = search.spec.grid
    digits = [0]
    for name, axis in grid.axes.items():
        digits.append(int(np.argmin(abs(axis - values[name]))) if name in values else 0)
    return search.design(int(grid.number(digits)))


def test_a_wish_of_few_numbers_is_the_built_length() -> None:
    from layerjam.workshop.design.few_numbers import hold
    from layerjam.workshop.design.specification import make_specification

    request = hold(
        KAPTON, "choi2018-kapton", force="100 N", mass="1 kg", width="30 mm", length="180 mm"
    )
    spec = make_specification(evolve(request, objectives=request.objectives))
    search = Search(spec)
    longest = evolve_design(search, overlap=float(spec.grid.axes["overlap"].max()))
    assert longest["length"] == pytest.approx(0.180, rel=1e-6)
