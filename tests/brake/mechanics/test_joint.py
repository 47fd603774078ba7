"""The capstan of interleaved sheets over a joint: tensions iterated along the arc, and limits."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given

from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.joint import capstan_ratio, joint_friction, joint_sheet_force
from strategies import KAPTON, change, points, random_brakes, seeds, stretched

FULL, MU, WIDTH, OVERLAP = 94.5e3, 0.875 * 0.24, 0.013, 0.068


def iterated(
    count: int, vacuum: float, angle: float, radius: float, tension: float, slip: float = 0.0
) -> tuple[float, float]:
    """Pull and greatest tension of one sheet [N]: friction from pressure from tension, repeated.

    Every sheet gathers the friction of its faces from its free end on; the pressure on an interface
    is the vacuum's and, on the arc, that of the tensions outside it over the radius.
    """
    overlap = OVERLAP - slip
    arc = min(radius * angle, overlap)
    cells = np.linspace(0, overlap, 3001)
    step, middle = np.diff(cells), (cells[1:] + cells[:-1]) / 2
    on = np.clip(
        (np.minimum(cells[1:], (overlap + arc) / 2) - np.maximum(cells[:-1], (overlap - arc) / 2))
        / step,
        0,
        1,
    )
    assert len(middle) == len(on)
    friction = np.full((count - 1, len(on)), MU * vacuum * WIDTH)
    for _ in range(2000):
        faces = np.zeros((count, len(on)))
        faces[1:] += friction
        faces[:-1] += friction
        gathered = np.concatenate([np.zeros((count, 1)), np.cumsum(faces * step, axis=1)], axis=1)
        pulls = gathered.copy()
        pulls[::2] = gathered[::2, -1:] - gathered[::2]  # left sheets are free at the right
        outside = tension + np.cumsum(pulls, axis=0)[:-1]
        new = MU * (vacuum * WIDTH + on * (outside[:, 1:] + outside[:, :-1]) / (2 * radius))
        done = np.abs(new - friction).max() < 1e-12 * max(float(new.max()), 1e-30)
        friction = new
        if done:
            return float(pulls.sum(axis=0)[0]), float(pulls.max())
    raise AssertionError("the tensions did not settle")


@pytest.mark.parametrize("count", [2, 3, 4, 7, 11])
@pytest.mark.parametrize(
    ("vacuum", "angle", "radius", "tension", "slip"),
    [
        (FULL, 1.2, 0.03, 0.0, 0.0),
        (20e3, 0.5, 0.05, 3.0, 0.02),
        (0.0, 1.0, 0.04, 2.0, 0.0),
        (FULL, 2.0, 0.06, 1.0, 0.01),
    ],
)
def test_against_tensions_iterated_along_the_arc(
    count: int, vacuum: float, angle: float, radius: float, tension: float, slip: float
) -> None:
    brake = change(KAPTON, sheets__count=count)
    due, sheet = iterated(count, vacuum, angle, radius, tension, slip)
    found = joint_friction(slip, vacuum, angle, radius, tension, brake)
    assert float(found) == pytest.approx(due, rel=1e-4)
    greatest = joint_sheet_force(slip, vacuum, angle, radius, tension, brake)
    assert float(greatest) == pytest.approx(sheet, rel=1e-3)


def test_two_sheets_are_eulers_capstan() -> None:
    """P W R (exp(mu phi) - 1), and none of it without vacuum and tension."""
    brake, radius = change(KAPTON, sheets__count=2), 0.03
    angle = OVERLAP / radius
    due = FULL * WIDTH * radius * (np.exp(MU * angle) - 1)
    assert float(joint_friction(0.0, FULL, angle, radius, 0.0, brake)) == pytest.approx(
        due, rel=1e-12
    )
    assert float(joint_friction(0.0, 0.0, angle, radius, 0.0, brake)) == 0
    # eleven sheets: ten capstans, one behind the other
    ten = FULL * WIDTH * radius * (np.exp(10 * MU * angle) - 1)
    assert float(joint_friction(0.0, FULL, angle, radius, 0.0, KAPTON)) == pytest.approx(
        ten, rel=1e-12
    )


@given(seeds)
def test_a_straight_brake_and_a_slippery_one(seed: int) -> None:
    """mu phi to zero leaves the flat friction, by its angle or by its coefficient."""
    brakes = random_brakes(seed, 50)
    slip, vacuum = points(seed, brakes)
    flat = np.asarray(sheet_friction(slip, vacuum, brakes))
    straight = np.asarray(joint_friction(slip, vacuum, 0.0, 0.05, 0.0, brakes))
    assert straight == pytest.approx(flat, rel=1e-12)
    slippery = change(brakes, film__kinetic=brakes.film.kinetic * 1e-9)
    wrapped = np.asarray(joint_friction(slip, vacuum, 1.5, 0.05, 0.0, slippery))
    assert wrapped == pytest.approx(flat * 1e-9, rel=1e-6)
    # the first term of the angle: half of (n - 1) mu phi where the arc is the whole overlap
    radius = 1e5 * brakes.sheets.overlap
    mu = brakes.scale_factor * brakes.film.kinetic
    share = (brakes.sheets.count - 1) * mu * (brakes.sheets.overlap - slip) / radius
    more = np.asarray(joint_friction(slip, vacuum, 1.0, radius, 0.0, brakes)) / flat - 1
    assert more == pytest.approx(share / 2, rel=2e-3)


@given(seeds)
def test_bending_and_pressing_only_add(seed: int) -> None:
    brakes = random_brakes(seed, 50)
    slip, vacuum = points(seed, brakes)
    angle = np.linspace(0.0, 1.0, 6)[:, None]
    force = np.asarray(joint_friction(slip, vacuum, angle, 0.1, 0.0, brakes))
    assert (np.diff(force, axis=0) >= 0).all()
    pressed = np.asarray(joint_friction(slip, vacuum, 0.5, 0.1, 5.0, brakes))
    assert (pressed > force[0]).all()
    sheet = np.asarray(joint_sheet_force(slip, vacuum, angle, 0.1, 0.0, brakes))
    assert (sheet <= force * (1 + 1e-12)).all()
    metres = np.asarray(joint_friction(slip, vacuum, 0.5, 0.1, 2.0, brakes))
    small = stretched(brakes, 1000.0)
    again = np.asarray(joint_friction(slip * 1e3, vacuum * 1e-6, 0.5, 100.0, 2.0, small))
    assert again == pytest.approx(metres, rel=1e-9)


def test_gradients_and_domain() -> None:
    def force(angle: object) -> object:
        return joint_friction(0.0, FULL, angle, 0.05, 1.0, KAPTON)

    with jax.enable_x64(True):
        around = (float(force(0.5 + 1e-6)) - float(force(0.5 - 1e-6))) / 2e-6  # type: ignore[arg-type]
        assert float(jax.grad(force)(jnp.asarray(0.5))) == pytest.approx(around, rel=1e-6)
        assert np.isfinite(float(jax.grad(force)(jnp.asarray(0.0))))
    for bad in (
        joint_friction(-1e-3, FULL, 0.5, 0.05, 0.0, KAPTON),
        joint_friction(0.0, -1.0, 0.5, 0.05, 0.0, KAPTON),
        joint_friction(0.0, FULL, -0.5, 0.05, 0.0, KAPTON),
        joint_friction(0.0, FULL, 0.5, 0.0, 0.0, KAPTON),
        joint_friction(0.0, FULL, 0.5, 0.05, -1.0, KAPTON),
        joint_sheet_force(0.1, FULL, 0.5, 0.05, 0.0, KAPTON),
        capstan_ratio(-1.0, 0.3),
        capstan_ratio(1.0, -0.3),
    ):
        assert np.isnan(float(bad))
    assert float(capstan_ratio(np.pi, 0.3)) == pytest.approx(2.5663, abs=1e-4)


def test_an_exponent_of_pressure_counts_at_the_joints_least_pressure() -> None:
    """A vacuum at P and a tension T press with P + T/(W R) at least."""
    brake = change(KAPTON, pressure_exponent=-0.2, test_pressure=3.9e3)
    least = 20e3 + 5.0 / (WIDTH * 0.05)
    factor = (least / 3.9e3) ** -0.2
    as_if = change(KAPTON, scale_factor=0.875 * factor)
    found = joint_friction(0.0, 20e3, 0.7, 0.05, 5.0, brake)
    assert float(found) == pytest.approx(
        float(joint_friction(0.0, 20e3, 0.7, 0.05, 5.0, as_if)), rel=1e-12
    )
