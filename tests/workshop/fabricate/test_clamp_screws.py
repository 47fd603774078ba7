"""Screws of the clamp: one number for the drawing and the stress, which is that of a cut sheet."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from shapely.geometry import LineString, Point, box

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.limits import clamp_stress
from layerjam.brake.mechanics.pull import peak
from layerjam.brake.mechanics.tracing import double_precision
from layerjam.core.errors import FileError, LayerjamError, QuantityError
from layerjam.workshop.design.merit import make_point, merits
from layerjam.workshop.fabricate.choices import resolve_choices
from layerjam.workshop.fabricate.film import lay_out_film
from layerjam.workshop.fabricate.lengths import compute_lengths
from layerjam.workshop.fabricate.strength import strength_checks

KAPTON = load("choi2018-kapton")
FORCE = 123.0


def built(rows: str, mount: str = "") -> BrakeFile:
    text = KAPTON.text.replace("[mount]\n", f"[mount]\n{mount}\n")
    return BrakeFile.read(f"{text}\n[build]\n{rows}\n", "brake.toml")


def least_section(file: BrakeFile) -> float:
    """What is left of a drawn sheet where least is left of it [m]: cut it and measure."""
    chosen = resolve_choices(file).build
    drawn = lay_out_film(file, chosen, compute_lengths(file.brake, chosen), 1)
    outline = next(part.outline for part in drawn.parts if part.name.startswith("sheet"))
    low_x, low_y, high_x, high_y = outline.box()
    sheet = box(low_x, low_y, high_x, high_y)
    for hole in outline.holes:
        sheet = sheet.difference(Point(hole.x, hole.y).buffer(hole.diameter / 2, 4096))
    cuts = np.union1d(np.linspace(low_x, high_x, 101), [hole.x for hole in outline.holes])
    lines = (LineString([(x, low_y - 1), (x, high_y + 1)]) for x in cuts)
    return min(sheet.intersection(line).length for line in lines) * 1e-3


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"width": "60 mm", "count": 8},
        {"width": "60 mm", "screws": 1},
        {"width": "31 mm", "screws": 4, "screw_hole": "4.1 mm"},
        {"width": "29 mm", "thickness": "0.1 mm", "count": 40},
        {"width": "50 mm", "screws": 7, "screw_hole": "2.4 mm"},
    ],
)
def test_the_stress_is_that_of_the_drawn_sheet_cut_through(changes: dict[str, str | int]) -> None:
    file = KAPTON.with_(**changes)
    sheets = file.brake.sheets
    bears = least_section(file) * sheets.thickness * (sheets.count // 2)
    stress = float(clamp_stress(FORCE, file.brake))
    assert stress == pytest.approx(FORCE / bears, rel=1e-6)
    # the check of a build, which draws from its own lengths, says the same
    build = resolve_choices(file).build
    found = strength_checks(FORCE, file.brake, build, compute_lengths(file.brake, build), "")
    (net,) = (check for check in found if check.key == "sheet-net")
    assert net.value == pytest.approx(stress, rel=1e-9)


def test_screws_that_nobody_states_are_one_for_every_20_mm() -> None:
    for width, screws in ((5, 1), (13, 1), (29, 1), (31, 2), (60, 3), (100, 5), (500, 25)):
        brake = KAPTON.brake.with_(width=f"{width} mm")
        assert (
            compute_lengths(brake, resolve_choices(BrakeFile.from_record(brake)).build).screws
            == screws
        )
        assert float(clamp_stress(FORCE, brake)) == pytest.approx(
            FORCE / (5 * (width - 3 * screws) * 1e-3 * 0.254e-3), rel=1e-12
        )


def test_what_only_build_states_counts_in_the_stress() -> None:
    drawn, stated = built("screws = 2"), built("", mount="screws = 2")
    assert drawn.brake == stated.brake and drawn.brake.mount.screws == 2
    assert drawn.sources["mount.screws"] == drawn.sources["build.screws"]
    once, twice = KAPTON.brake, drawn.brake
    ratio = float(clamp_stress(FORCE, twice)) / float(clamp_stress(FORCE, once))
    assert ratio == pytest.approx(10 / 7, rel=1e-12)
    again = BrakeFile.read(drawn.render("again"), "again.toml")
    assert again.brake == twice and again.making == drawn.making


def test_build_and_mount_must_agree(tmp_path) -> None:
    assert built("screws = 2", mount="screws = 2").brake.mount.screws == 2
    with pytest.raises(FileError, match=r"build\.screws: 2 contradicts .* it states 3") as caught:
        built("screws = 2", mount="screws = 3")
    assert caught.value.line is not None
    with pytest.raises(LayerjamError, match=r"build\.screws: 2 contradicts"):
        built("screws = 2").with_(screws=3)
    # nor may a workshop draw other screws than the stress counts
    shop = tmp_path / "shop.toml"
    shop.write_text("[build]\nscrews = 2\n")
    with pytest.raises(
        FileError, match=r"the default for sheets 13 mm wide is 1; write screws = 2 in \[mount\]"
    ):
        resolve_choices(KAPTON, shop)
    with pytest.raises(QuantityError, match=r"build\.screws: 2 contradicts"):
        resolve_choices(KAPTON, overrides={"screws": 2})
    assert resolve_choices(KAPTON.with_(screws=2), shop).build.screws == 2


def test_a_design_bears_less_with_more_screws_and_none_where_they_leave_nothing() -> None:
    widths = np.array([8e-3, 13e-3, 25e-3, 55e-3])
    with double_precision():
        for screws in (None, 1, 3):
            mount = replace(KAPTON.brake.mount, screws=screws)
            base = replace(KAPTON.brake, mount=mount)
            found = merits(make_point(base, 90e3)._replace(width=widths), base)
            for i, width in enumerate(widths):
                many = screws or max(1, round(width / 20e-3))
                net = width - many * 3e-3
                margin = found["stress_margin"][i]
                if net <= 0:
                    assert np.isnan(margin)
                    continue
                sheets = replace(base.sheets, width=float(width))
                own = replace(base, sheets=sheets, weighed_mass=None)
                top = float(peak(90e3, base.sheets.usable_travel, own).force)
                due = base.film.strength * 5 * net * 0.254e-3 / top
                # the design's stiffness is that of its own sheets, which does not move the peak
                assert float(margin) == pytest.approx(due, rel=1e-9)


def test_the_stress_follows_the_width_between_two_numbers_of_screws() -> None:
    def stress(width: float) -> float:
        sheets = replace(KAPTON.brake.sheets, width=width)
        return clamp_stress(FORCE, replace(KAPTON.brake, sheets=sheets))

    with jax.enable_x64(True):
        for width, screws in ((13e-3, 1), (55e-3, 3)):
            net = width - screws * 3e-3
            due = -FORCE / (5 * 0.254e-3 * net**2)
            assert float(jax.grad(stress)(width)) == pytest.approx(due, rel=1e-12)
        both = jax.vmap(stress)(np.array([13e-3, 55e-3]))
    each = [float(stress(13e-3)), float(stress(55e-3))]
    assert np.asarray(both) == pytest.approx(each, rel=1e-14)
