"""Sheet by sheet under the cursor: what slides, how it is drawn, and that it costs nothing else."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.brake.commands.tensile import tensile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.simulate.procedure import simple_pull
from layerjam.brake.simulate.sheet_motion import sheet_motion
from layerjam.brake.simulate.stack import tensile_stack
from layerjam.brake.simulate.stack_layout import Housing, make_stack
from layerjam.workbench.pages.pull import _parse_point
from layerjam.workbench.sheets_drawing import (
    MAX_SHEETS,
    PullView,
    describe_scale,
    draw_stack,
    format_runs,
    round_down,
    slip_sentence,
)

KAPTON = "choi2018-kapton"
PULL = {"vacuum": "60 kPa", "speed": "1 mm/s", "elongation": "30 mm", "model": "stack"}


@pytest.fixture(scope="module")
def found():
    return tensile(KAPTON, **PULL)


@pytest.fixture(scope="module")
def seen(found):
    return PullView.from_motion(found.motion, load(KAPTON).brake.sheets)


def test_the_motion_is_the_stacks_own_at_fewer_samples_and_keeps_every_change(found):
    record, pull = tensile_stack(load(KAPTON), simple_pull(60e3, 1e-3, 30e-3))
    motion = found.motion
    assert len(motion.force) < len(record.force) / 5
    rows = np.searchsorted(record.elongation, motion.elongation)
    for name in ("cap", "sheets", "slip", "sliding", "force"):
        np.testing.assert_array_equal(getattr(motion, name), getattr(pull, name)[rows])
    turns = (pull.sliding[1:] != pull.sliding[:-1]).any(axis=1).sum()
    assert (motion.sliding[1:] != motion.sliding[:-1]).any(axis=1).sum() == turns > 1
    # an interface has slipped by what its two sheets have moved apart
    left, right = motion.sheets[:, :-1], motion.sheets[:, 1:]
    apart = np.where(motion.moving[1:], right - left, left - right)
    np.testing.assert_allclose(motion.slip, apart, atol=1e-12)
    assert tensile(KAPTON, vacuum="60 kPa", speed="1 mm/s", travel="9 mm").motion is None


def test_a_housings_walls_hang_on_the_cap_opposite_to_their_sheet():
    file, housing = load(KAPTON), Housing(friction=3.0)
    record, pull = tensile_stack(file, simple_pull(60e3, 1e-3, 5e-3), housing=housing)
    moving = sheet_motion(record, pull).moving
    np.testing.assert_array_equal(moving, make_stack(file.brake, 60e3, housing=housing).right)


def test_what_slides_bears_its_friction_and_the_sentence_counts_it(seen):
    """Where all slide the force is the sum of the frictions, computed here by itself, and more."""
    brake, motion = load(KAPTON).brake, seen.motion
    at = int(np.flatnonzero(motion.sliding.all(axis=1))[0])
    whole = float(friction_per_contact(60e3, brake)) * brake.sheets.overlap
    assert motion.force[at] == pytest.approx(whole, rel=0.05)
    assert "every sheet slides" in slip_sentence(seen, at)
    assert "no sheet slides" in slip_sentence(seen, 0)
    mixed = seen.informative_sample()
    assert "2 of 10 interfaces slide (1 and 10, from the top)" in slip_sentence(seen, mixed)


def spans(svg: str, kind: str) -> list[tuple[float, float]]:
    made = re.findall(rf'class="{kind}" x="([-\d.]+)" y="[-\d.]+" width="([\d.]+)"', svg)
    return [(float(x), float(x) + float(wide)) for x, wide in made]


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 1.0])
def test_sheets_are_drawn_to_the_scale_that_is_said(seen, share):
    motion, sheets = seen.motion, seen.sheets
    at = round(share * (len(motion.force) - 1))
    svg = draw_stack(seen, at)
    drawn = spans(svg, "sheet-holds") + spans(svg, "sheet-slides")
    assert len(drawn) == sheets.count
    assert len(spans(svg, "sheet-hatch")) == len(spans(svg, "sheet-slides"))
    (ghost,), caps = spans(svg, "sheets-ghost"), spans(svg, "sheets-cap")
    held, moved = caps
    per_metre = (ghost[0] - held[1]) / (sheets.free_left + sheets.overlap + sheets.free_right)
    factor = float(re.search(r"drawn ([\d.e+]+) times", svg)[1]) if "times" in svg else 1.0
    assert (moved[0] - ghost[0]) / per_metre == pytest.approx(
        factor * motion.cap[at], abs=0.02 / per_metre
    )
    free = sorted({round(x, 1) for x, _ in drawn if x > held[1] + 0.1})
    most = factor * motion.sheets[at][motion.moving].max()
    assert free[-1] == pytest.approx(held[1] + per_metre * (sheets.free_left + most), abs=0.06)
    # nothing leaves the drawing
    wide = float(re.search(r'viewBox="0 0 (\d+)', svg)[1])
    assert held[0] >= 0 and moved[1] <= wide


def test_movements_are_large_before_all_slide_and_true_after(seen):
    motion = seen.motion
    assert seen.magnification(seen.informative_sample()) == seen.factor > 50
    assert "times larger" in describe_scale(seen, 0)
    last = len(motion.force) - 1
    assert seen.magnification(last) == 1.0 and "to scale" in describe_scale(seen, last)


def test_the_cursor_finds_its_sample_on_a_pull_that_turns():
    steps = "evacuate to 60 kPa; pull at 1 mm/s until 20 mm; return at 1 mm/s to 10 mm"
    motion = tensile(KAPTON, procedure=steps, model="stack").motion
    turned = PullView.from_motion(motion, load(KAPTON).brake.sheets)
    for at in range(0, len(motion.force), 7):
        near = turned.nearest_sample(float(motion.elongation[at]), float(motion.force[at]))
        assert abs(motion.elongation[near] - motion.elongation[at]) < 2e-4
        assert abs(motion.force[near] - motion.force[at]) < 1.0
    there = turned.nearest_sample(0.015, motion.force.max())
    back = turned.nearest_sample(0.015, motion.force.min())
    assert there < np.argmax(motion.elongation) < back


def test_a_thick_stack_is_drawn_in_part_and_says_so():
    file = load(KAPTON)
    sheets = replace(file.brake.sheets, count=301)
    file = replace(file, brake=replace(file.brake, sheets=sheets))
    motion = sheet_motion(*tensile_stack(file, simple_pull(10e3, 1e-3, 2e-3)))
    thick = PullView.from_motion(motion, sheets)
    svg = draw_stack(thick, thick.informative_sample())
    assert len(spans(svg, "sheet-holds") + spans(svg, "sheet-slides")) == MAX_SHEETS
    assert f"{MAX_SHEETS} of 301 sheets are drawn" in svg


@given(st.sets(st.integers(1, 40), min_size=1))
def test_runs_of_numbers_read_back(numbers):
    text = format_runs(sorted(numbers))
    back = set()
    for part in re.split(r", | and ", text):
        ends = [int(one) for one in part.split("–")]
        back |= set(range(ends[0], ends[-1] + 1))
    assert back == numbers


@given(st.floats(1e-6, 1e9))
def test_a_round_factor_is_never_above(value):
    assert round_down(value) <= value * (1 + 1e-9) and round_down(value) > value / 2.6


@pytest.mark.parametrize("sent", [None, "x", [], [1], ["1", 2], {"x": 1}, [[None, 2]]])
def test_what_no_pointer_sends_moves_nothing(sent):
    assert _parse_point(sent) is None
    assert _parse_point([3, 4.5]) == _parse_point([[3, 4.5]]) == (3.0, 4.5)
