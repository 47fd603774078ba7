"""The moving picture of README and docs is what its script computes now, and is plain SVG."""

from __future__ import annotations

import re
from types import ModuleType
from xml.etree import ElementTree

import numpy as np
import pytest

import layerjam as lj
from docs.examples import ROOT, script

SCRIPT = ROOT / "docs" / "images" / "stop_animation.py"
COMMITTED = SCRIPT.with_name("stop.svg").read_text(encoding="utf-8")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


@pytest.fixture(scope="module")
def animation() -> ModuleType:
    """docs/images/stop_animation.py."""
    return script(SCRIPT)


def test_picture_is_what_the_script_draws(animation: ModuleType) -> None:
    drawn = animation.draw(animation.compute())
    texts = [NUMBER.sub("#", t) for t in (COMMITTED, drawn)]
    assert texts[0] == texts[1], "run docs/images/stop_animation.py"
    numbers = [np.array(NUMBER.findall(t), dtype=float) for t in (COMMITTED, drawn)]
    assert np.allclose(*numbers, atol=0.11), "run docs/images/stop_animation.py"


def test_picture_moves_without_a_script_and_rests_for_those_who_ask() -> None:
    root = ElementTree.fromstring(COMMITTED)
    kinds = {element.tag.rsplit("}", 1)[-1] for element in root.iter()}
    assert kinds == {"svg", "title", "style", "clipPath", "rect", "text", "path", "g", "circle"}
    assert len(COMMITTED.encode()) < 300_000
    style = next(element.text or "" for element in root.iter() if element.tag.endswith("style"))
    moving, still = style.split("@media (prefers-reduced-motion: reduce)")
    assert "animation: none !important" in still
    # nothing moves but under this rule
    before, rules = moving.split("@media (prefers-reduced-motion: no-preference) {")
    assert "animation:" not in before and rules.count("animation:") == rules.count("@keyframes")
    assert "url(" not in style and COMMITTED.count("http") == 1  # the namespace


def test_picture_shows_the_stop_and_the_numbers_of_the_command(animation: ModuleType) -> None:
    stop = lj.drop(
        "choi2018-kapton", mass="1 kg", speed="2.5 m/s", rope_stiffness="16.8 kN/m",
        vacuum="70.05 kPa",
    ).require()  # fmt: skip
    texts = [t.text for t in ElementTree.fromstring(COMMITTED).iter() if t.tag.endswith("text")]
    for words in (
        f"slip {stop.slip * 1e3:.1f} mm",
        f"peak force {stop.peak_force:.1f} N: the sheets begin to slide",
        f"standstill after {stop.stopping_time * 1e3:.1f} ms",
        f"vacuum {stop.vacuum / 1e3:.2f} kPa",
    ):
        assert words in texts, words
    for page in ("README.md", "docs/index.md"):
        alternative = (ROOT / page).read_text("utf-8").split("![", 1)[1].split("]", 1)[0]
        for number in (
            f"by {stop.slip * 1e3:.1f} mm",
            f"rises to {stop.peak_force:.1f} N",
            f"after {stop.stopping_time * 1e3:.1f} ms",
        ):
            assert number in alternative, number
    film = animation.compute()
    assert film.time[0] == -animation.FALL and np.all(np.diff(film.time) > 0)
    assert film.slip[-1] == pytest.approx(stop.slip, rel=1e-6)
    assert film.force.max() == pytest.approx(stop.peak_force, rel=1e-3)
