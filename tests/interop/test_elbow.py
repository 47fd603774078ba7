"""The example of a brake over an elbow: a sound environment, and training that helps."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from docs.examples import ROOT
from docs.pictures import compare

gymnasium = pytest.importorskip("gymnasium", reason="no Gymnasium here")
pytest.importorskip("cma", reason="no pycma here")
pytest.importorskip("mujoco", reason="no MuJoCo here")
sys.path.insert(0, str(ROOT / "examples"))
pytestmark = pytest.mark.slow


def test_gymnasium_finds_nothing_wrong():
    from elbow import Elbow
    from gymnasium.utils.env_checker import check_env

    check_env(Elbow(), skip_render_check=True)


def test_the_arm_is_held_and_never_lifted():
    """At full vacuum friction bears each load near the horizontal; a brake only lets down."""
    from elbow import Elbow

    arm = Elbow()
    for seed in range(20):
        arm.reset(seed=seed)
        arm.data.qvel[0] = 0.0
        angles = [arm.step(np.array([1.0]))[0][0] for _ in range(60)]
        assert np.degrees(max(angles)) < 25
        # what swings back is the brake's own spring, not more than it was stretched by
        assert np.degrees(angles[-1]) > np.degrees(max(angles)) - 5


def test_the_animation_of_the_gallery_is_what_the_example_draws():
    from elbow_animation import picture

    committed = ROOT / "docs" / "images" / "elbow-animation.svg"
    assert compare(committed.read_text("utf-8"), picture()) == ""


def test_ten_generations_stop_nearer_to_the_target(tmp_path):
    from elbow_train import draw, ends, network, train

    numbers, history = train(600.0, generations=10)
    from elbow import Elbow

    arm = Elbow()
    before = np.median(np.abs(ends(arm, network(np.zeros_like(numbers)))[1]))
    after = np.median(np.abs(ends(arm, network(numbers))[1]))
    assert after < 0.6 * before and len(history) > 0
    figure = tmp_path / "elbow.svg"
    words = draw(figure, network(np.zeros_like(numbers)), network(numbers), history)
    assert "degrees from the target" in words and "<svg" in figure.read_text(encoding="utf-8")
