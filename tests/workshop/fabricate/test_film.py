"""The film of a whole brake: counts, files, stock, and what must not go into a laser."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from counts import cases
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.device.workshop import Build
from layerjam.core.errors import FileError, QuantityError
from layerjam.workshop.fabricate.checks import check_drawability
from layerjam.workshop.fabricate.choices import resolve_choices
from layerjam.workshop.fabricate.film import Film, auxiliary_files, lay_out_film
from layerjam.workshop.fabricate.lengths import CannotBuildError, compute_lengths
from layerjam.workshop.fabricate.verdicts import Check, refusals
from workshop.fabricate.flat import of_bulges, opened

KAPTON, PTFE = load("choi2018-kapton"), load("choi2018-ptfe")


def made(file: BrakeFile = KAPTON, copies: int = 1, **build: object) -> Film:
    chosen = resolve_choices(file, overrides=build).build
    found = compute_lengths(file.brake, chosen)
    check_drawability(file.brake, chosen, found)
    return lay_out_film(file, chosen, found, copies)


def check(found: Film, key: str) -> Check:
    (one,) = (c for c in found.checks if c.key == key)
    return one


def test_the_papers_brake() -> None:
    found = made()
    assert [(p.name, p.count) for p in found.parts] == [("sheet", 11), ("spacer", 11)]
    each = 85 * 13 - (2 - math.pi / 2) * 1.25 - math.pi * 9 / 4
    filler = 6 * 13 - (2 - math.pi / 2) * 0.5 - math.pi * 9 / 4
    assert found.area == pytest.approx(11e-6 * (each + filler), rel=1e-13)
    edges = 2 * (85 + 13) + 2 * (6 + 13) - (4 - math.pi) * (1.5 + 1.0) + 2 * math.pi * 3
    assert found.cut_length == pytest.approx(11e-3 * edges, rel=1e-13)
    (piece,) = found.pieces
    assert found.used == pytest.approx(found.area * 1e6 / (piece.length * piece.width), rel=1e-13)
    assert not refusals(found.checks) and found.notes == []
    assert set(found.files()) == {
        f"cut/{name}.{end}" for name in ("sheet", "spacer", "film-1") for end in ("dxf", "svg")
    }


@st.composite
def brakes(draw: st.DrawFn, most: int = 60) -> BrakeFile:
    """A brake whose sides may differ: n from 2, 25 to 500 µm, 8 to 100 mm wide."""
    width, overlap = draw(st.floats(8e-3, 0.1)), draw(st.floats(0.02, 0.2))
    free = draw(st.floats(5e-3, 0.03)), draw(st.floats(5e-3, 0.03))
    clamped = draw(st.floats(6e-3, 0.02))
    return KAPTON.with_(
        count=draw(st.integers(2, most)),
        width=width,
        thickness=draw(st.floats(25e-6, 500e-6)),
        length=overlap + max(free) + clamped,
        overlap=overlap,
        usable_travel=overlap / 2,
        free_left=free[0],
        free_right=free[1],
        clamped_length=clamped,
        screw_hole=draw(st.sampled_from((2.2e-3, 3e-3, 4.5e-3))),
    )


@settings(max_examples=8)
@given(brakes(10), st.sampled_from((0.0, 0.15e-3)), st.integers(1, 2))
def test_random_brakes_as_a_checker_reads_them(file: BrakeFile, kerf: float, copies: int) -> None:
    judge(file, kerf, copies)


@pytest.mark.slow
@settings(max_examples=cases(150, 25))
@given(brakes(), st.sampled_from((0.0, 0.15e-3)), st.integers(1, 3))
def test_many_random_brakes(file: BrakeFile, kerf: float, copies: int) -> None:
    judge(file, kerf, copies)


def judge(file: BrakeFile, kerf: float, copies: int) -> None:
    """Refused in words, or every outline and hole where section 2.2 puts them."""
    try:
        found = made(file, copies, kerf=kerf)
    except (CannotBuildError, QuantityError):
        return
    sheets, hole = file.brake.sheets, file.brake.mount.screw_hole * 1e3
    screws = max(1, round(sheets.width * 1e3 / 20))
    if refusals(found.checks):
        return
    outlines = holes = 0
    lines = {name: data for name, data in found.files().items() if name.endswith(".dxf")}
    for name, data in lines.items():
        space = opened(data).modelspace()
        if name.startswith("cut/film-"):
            outlines += len(space.query('LWPOLYLINE[layer=="CUT"]'))
            holes += len(space.query("CIRCLE"))
            radii = {round(circle.dxf.radius, 12) for circle in space.query("CIRCLE")}
            assert radii == {round((hole - kerf * 1e3) / 2, 12)}
    count = copies * sheets.count
    assert (outlines, holes) == (2 * count, 2 * count * screws)
    for side, free in (("left", sheets.free_left), ("right", sheets.free_right)):
        same = math.isclose(sheets.free_left, sheets.free_right, rel_tol=1e-9)
        name = "cut/sheet.dxf" if same else f"cut/sheet-{side}.dxf"
        space = opened(lines[name]).modelspace()
        (outline,) = space.query("LWPOLYLINE")
        area, _ = of_bulges(outline.get_points("xyb"))
        corners = (2 - math.pi / 2) * (1 + 0.25)
        assert area == pytest.approx(sheets.length * sheets.width * 1e6 - corners, rel=1e-9)
        clamped = (sheets.length - free - sheets.overlap) * 1e3
        xs, _ = zip(*outline.get_points("xy"), strict=True)
        for circle in space.query("CIRCLE"):
            assert circle.dxf.center.x - min(xs) == pytest.approx(clamped / 2, abs=1e-9)


def test_unlike_sides_have_parts_of_their_own() -> None:
    file = KAPTON.with_(free_left="9 mm", count=6)
    counts = {part.name: part.count for part in made(file).parts}
    assert counts == {"sheet-left": 3, "sheet-right": 3, "spacer-left": 3, "spacer-right": 3}
    counts = {part.name: part.count for part in made(file.with_(count=7), copies=2).parts}
    # at either cap each layer is filled: by a sheet of this side, or a spacer
    assert counts == {"sheet-left": 8, "sheet-right": 6, "spacer-left": 6, "spacer-right": 8}
    spacers = {p.name: p.outline.length for p in made(file).parts if "spacer" in p.name}
    assert spacers == {"spacer-left": pytest.approx(8), "spacer-right": pytest.approx(6)}


def test_stock_and_bed() -> None:
    found = made(stock_length=0.2, stock_width=0.1)
    assert len(found.pieces) == 2 and check(found, "stock").ok
    found = made(stock_length=0.09, stock_width=0.1)
    stock = check(found, "stock")
    assert not stock.ok and stock.is_refused and stock.value == pytest.approx(5e-3)
    assert "length" in stock.text and found.pieces == []
    # the bed bounds the pieces, laid either way
    found = made(laser_bed=(0.1, 0.096))
    assert len(found.pieces) > 1 and check(found, "laser-bed").ok
    assert all(max(piece.length, piece.width) <= 100 for piece in found.pieces)
    bed = check(made(laser_bed=(0.08, 0.3), stock_length=0.4, stock_width=0.3), "laser-bed")
    assert not bed.ok and bed.is_refused and bed.value == pytest.approx(0.22)
    tall = check(made(laser_bed=(0.05, 0.09)), "laser-bed")
    assert not tall.ok and tall.value == pytest.approx(5e-3)
    assert check(made(laser_bed=(0.02, 0.2)), "laser-bed").ok is False


def test_holes_that_nobody_can_cut() -> None:
    assert check(made(), "holes").value == pytest.approx(1.5e-3)
    thick = KAPTON.with_(thickness="2 mm", screw_hole="2.5 mm", count=2)
    assert not check(made(thick), "hole-size").ok  # less than 1.5 sheets
    assert not check(made(KAPTON.with_(screws=4)), "holes").ok  # 13 mm hold no four of 3 mm
    assert check(made(KAPTON.with_(screw_hole="4.1 mm")), "holes").ok is False  # 0.95 mm of rim
    with pytest.raises(QuantityError, match=r"build\.clamp_radius: 4 mm is not less than half"):
        made(clamp_radius=4e-3)
    with pytest.raises(QuantityError, match=r"build\.clamp_radius: 42 mm is not less than half"):
        made(KAPTON.with_(width="95 mm", length="86 mm"), tip_radius=45e-3, clamp_radius=42e-3)


TEXT = KAPTON.render("mine")


def own(laser: str, use: str = "kapton-hn") -> BrakeFile:
    """The paper's brake with another film, and a line about lasers."""
    stated = ("laser =", 'product = "Kapton')
    kept = [row for row in TEXT.splitlines() if not row.startswith(stated)]
    at = kept.index("[film]")
    return BrakeFile.read(
        "\n".join([*kept[: at + 1], f'use = "{use}"', laser, *kept[at + 1 :]]), "x"
    )


def test_films_and_lasers() -> None:
    careful = check(made(cutter="laser"), "film-and-laser")
    assert careful.ok and "care" in careful.text
    assert check(made(load("choi2018-polyester"), cutter="laser"), "film-and-laser").ok
    for name in ("choi2018-ptfe", "choi2018-ptfe-fiberglass"):
        found = made(load(name), cutter="laser")
        never = check(found, "film-and-laser")
        assert never.ok is False and never.is_refused and never.code == "C15"
        for cutter in ("service", "knife"):
            other = made(load(name), cutter=cutter)
            assert check(other, "film-and-laser").ok is None
            assert not refusals(other.checks)
            for path, data in other.files().items():
                assert b"Never cut this film with a laser." in data, path


def test_a_film_of_which_nothing_is_said_goes_into_no_laser() -> None:
    nameless = BrakeFile.read(
        "\n".join(row for row in TEXT.splitlines() if not row.startswith("laser =")), "x"
    )
    assert nameless.making.film.laser is None
    with pytest.raises(QuantityError, match=r"film\.laser.*PVC"):
        made(nameless, cutter="laser")
    assert made(nameless).pieces and made(nameless, cutter="knife").pieces
    with pytest.raises(QuantityError, match="has no source"):
        made(own('laser = "yes"'), cutter="laser")
    with pytest.raises(FileError, match="unknown laser 'maybe'"):
        own('laser = "maybe"')


def test_lifting_a_never_is_said_in_every_file() -> None:
    words = "own enclosure, extraction for fluorides"
    lifted = own(f'laser = {{ value = "yes", kind = "measured", source = "{words}" }}', "ptfe")
    assert lifted.sources["film.laser"].was.startswith("never: in air at 500")
    found = made(lifted, cutter="laser")
    assert check(found, "film-and-laser").ok and not refusals(found.checks)
    for path, data in found.files().items():
        assert b"WARNING: the catalogue says never" in data and words.encode() in data, path
        if path.endswith(".dxf"):
            opened(data)
    # and nothing is drawn in a service's file but what is cut
    space = opened(found.files()["cut/sheet.dxf"]).modelspace()
    assert {e.dxftype() for e in space} == {"LWPOLYLINE", "CIRCLE"}
    # for another cutter the laser's word does not count
    assert made(lifted, cutter="knife").notes == []


def test_what_is_no_film() -> None:
    chosen = resolve_choices(KAPTON).build
    drawn = compute_lengths(KAPTON.brake, chosen)
    files = auxiliary_files(chosen, drawn, parallel=3, series=2, coupons=True)
    assert set(files) == {f"cut/{name}.dxf" for name in ("jig", "yoke", "link", "coupon")}
    assert set(auxiliary_files(chosen, drawn, 1, 1, False)) == {"cut/jig.dxf"}

    def holes(name: str) -> list[float]:
        space = opened(files[f"cut/{name}.dxf"]).modelspace()
        assert all(c.dxf.radius == pytest.approx(3.05) for c in space.query("CIRCLE"))
        return sorted(c.dxf.center.x for c in space.query("CIRCLE"))

    jig, yoke, link = holes("jig"), holes("yoke"), holes("link")
    assert jig[1] - jig[0] == pytest.approx(154.4)
    assert link[1] - link[0] == pytest.approx(15)
    assert [x - yoke[0] for x in yoke] == pytest.approx([0, 21.8, 21.8, 43.6])
    (outline,) = opened(files["cut/yoke.dxf"]).modelspace().query("LWPOLYLINE")
    xs, _ = zip(*outline.get_points("xy"), strict=True)
    assert max(xs) - min(xs) == pytest.approx(2 * 21.8 + 20)


def test_the_kerf_of_a_build_reaches_the_pieces_and_not_the_service() -> None:
    plain, burnt = made(), made(kerf=0.2e-3)
    files = {name: burnt.files()[name] for name in ("cut/sheet.dxf", "cut/spacer.svg")}
    assert files == {name: plain.files()[name] for name in files}
    assert burnt.pieces[0].parts[0].length == pytest.approx(85.2)
    assert (
        replace(Build(), kerf=0.2e-3).kerf
        == resolve_choices(KAPTON, overrides={"kerf": 0.2e-3}).build.kerf
    )
