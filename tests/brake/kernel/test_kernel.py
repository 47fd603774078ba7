"""The C kernel is `brake_cycle`, move by move, and keeps what the law promises."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest

from brake.kernel.histories import history, most
from c_printers.formulas import LAWS, format_file
from layerjam.brake.device.load import load
from layerjam.brake.kernel import kernel as kernels
from layerjam.brake.kernel.compiler import SOURCES
from layerjam.brake.kernel.kernel import Kernel
from layerjam.brake.kernel.parameters import parameters
from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.core.errors import QuantityError
from strategies import KAPTON, PTFE, change, one, random_brakes

CC = pytest.mark.skipif(
    shutil.which("cc") is None and shutil.which("gcc") is None, reason="no C compiler here"
)
VACUUM = 94.5e3


def gap(brake, seed, kernel=None):
    """Worst disagreement in force [N over what is allowed] and heat [J] before the sheets part."""
    path, vacuum = history(brake, seed)
    law, fast = brake_cycle(path, vacuum, brake), (kernel or Kernel(brake)).cycle(path, vacuum)
    void = np.asarray(law.separated) | np.asarray(law.overflow) | np.asarray(law.snapped)
    fine = ~np.logical_or.accumulate(void)
    assert fine.sum() > 20
    force = np.asarray(law.force)[fine]
    allowed = max(1e-9, 1e-12 * force.max())
    return (
        np.abs(force - fast.force[fine]).max() / allowed,
        np.abs(np.asarray(law.heat) - fast.heat)[fine].max(),
        np.abs(np.asarray(law.slip) - fast.slip)[fine].max(),
    )


def test_the_formulas_are_those_of_the_laws():
    """`python tests/print_c.py` writes them anew."""
    for name in LAWS:
        assert (SOURCES / name).read_text("utf-8") == format_file(name)


@CC
@pytest.mark.parametrize("seed", range(16))
def test_kernel_agrees_with_the_law(seed):
    brakes = random_brakes(seed, 3)
    for brake in (KAPTON, PTFE, one(brakes, seed % 3)):
        force, heat, slip = gap(brake, seed)
        assert force <= 1 and heat <= 1e-11 * max(1, most(brake) / 200) and slip <= 1e-14


@CC
@pytest.mark.slow
def test_the_same_with_an_exponent_a_share_of_the_vacuum_and_spacers():
    bent = replace(one(random_brakes(7, 2, exponent=True), 0), vacuum_share=0.8)
    assert all(gap(bent, seed)[0] <= 1 for seed in (1, 4))
    flat = replace(change(KAPTON, mount__spacers=True), amplification_held=1.05)
    known = parameters(flat).contact * VACUUM * (flat.sheets.overlap - 0.01)
    assert known == pytest.approx(float(sheet_friction(0.01, VACUUM, flat)), rel=1e-12)


@CC
def test_a_held_load_is_held_bit_for_bit():
    """To 0.999 c L2: a thousand calls leave every bit; at 1.001 it slides."""
    k = Kernel(KAPTON)
    p = k.parameters
    onset = p.contact * VACUUM * p.overlap / p.stiffness
    k.move(0.999 * onset, VACUUM)
    held = k.state
    for _ in range(1000):
        k.move(0.999 * onset, VACUUM)
    assert k.state == held and k.slip == 0
    k.move(1.001 * onset, VACUUM)
    assert k.slip > 0
    slid = k.slip, k.enclosure_force, k.heat, k._state.count
    for shake in np.random.default_rng(1).uniform(0.1, 0.999, 1000):
        k.move(shake * onset, VACUUM + 1e3 * (shake > 0.9))
    now = k.slip, k.enclosure_force, k.heat, k._state.count
    assert now == slid, "shaken below its friction, under a vacuum that rises, it does not creep"


@CC
def test_energy_is_kept_on_every_history():
    """External work, integrated here from force over elongation, is heat and what is stored."""
    for seed in range(4):
        path, vacuum = history(KAPTON, 4 * seed + 2)
        dense = np.interp(np.arange(0, 200, 1 / 200), np.arange(len(path)), path)
        under = np.repeat(vacuum[:200], 200)
        made = Kernel(KAPTON).cycle(dense, under)
        assert made.work - made.heat - made.stored == pytest.approx(0, abs=1e-12)
        assert (np.diff(made.heat) >= 0).all()
    dense = np.concatenate([np.linspace(0, dense[0], 4000), dense])
    made = Kernel(KAPTON).cycle(dense, VACUUM)
    area = np.cumsum((made.force[1:] + made.force[:-1]) / 2 * np.diff(dense))
    assert made.work[1:] == pytest.approx(area, abs=2e-5 * made.work.max())


@CC
def test_slope_is_that_of_differences():
    k, rng = Kernel(PTFE), np.random.default_rng(5)
    seen, u = [0, 0, 0], 0.0
    for index in range(400):
        vacuum = 94.5e3 if index < 200 else 300.0
        u = abs(u + rng.normal(1e-4, 6e-4))
        k.move(u, vacuum)
        here, motion = k.state, k._state.motion
        step = -1e-8 if motion == 2 else 1e-8
        slope = (k.peek(u + step, vacuum) - k.force) / step
        assert k.state == here
        if k.force > 1e-2:
            assert slope == pytest.approx(k.tangent(), rel=1e-3, abs=1)
            seen[motion] += 1
    assert min(seen) > 20, "stuck, outward and inward"


@CC
def test_a_weaker_vacuum_lets_a_sliding_brake_give_way_at_the_slope():
    k = Kernel(KAPTON)
    k.move(0.02, VACUUM)
    slope = (k.peek(0.02, VACUUM) - k.peek(0.02, VACUUM - 1)) / 1
    assert slope == pytest.approx(k.vacuum_tangent(), rel=1e-4)
    assert k.peek(0.02, VACUUM + 1) == k.force


@CC
def test_compliance_is_a_spring_in_series():
    """Moved without force to u, the brake itself gets u - eta F: the same as moved there."""
    soft, stiff, eta = Kernel(KAPTON), Kernel(KAPTON), 3e-5
    for u in (0.001, 0.01, 0.03, 0.025, 0.029, 0.002):
        force = soft.move(u, VACUUM, eta)
        assert stiff.move(u - eta * force, VACUUM) == pytest.approx(force, abs=1e-9)
        assert soft.slip == pytest.approx(stiff.slip, abs=1e-15)
        assert soft.work == pytest.approx(stiff.work, abs=1e-11)
        assert soft.work - soft.heat - soft.stored == pytest.approx(0, abs=1e-13)


@CC
def test_a_rope_is_part_of_the_stiffness_and_the_state_travels():
    assert parameters(KAPTON, 16.8e3).stiffness == pytest.approx(1 / (1 / 131e3 + 1 / 16.8e3))
    k = Kernel(load("choi2018-kapton"), rope_stiffness=16.8e3)
    k.move(0.02, VACUUM)
    kept, after = k.state, k.move(0.019, 8e4)
    other = Kernel(KAPTON, rope_stiffness=16.8e3)
    other.state = kept
    assert other.move(0.019, 8e4) == after and other.state == k.state
    with pytest.raises(QuantityError, match="expected 664 bytes, got 663"):
        other.state = kept[:-1]


@CC
def test_sheets_that_part_leave_the_enclosure_alone():
    k, far = Kernel(KAPTON), 0.08
    k.move(far, VACUUM)
    assert k.flags & kernels.SEPARATED
    p = k.parameters
    x = k.slip
    tension = p.enclosure_stiffness * x / p.reach + p.enclosure_contact * VACUUM * p.reach
    small = 2 * np.sqrt(p.enclosure_stiffness * p.enclosure_contact * VACUUM * x)
    saturation = p.enclosure_contact * VACUUM * p.reach**2 / p.enclosure_stiffness
    assert k.force == pytest.approx(tension if x > saturation else small, rel=1e-9)
    assert k.force == pytest.approx(p.stiffness * (far - x), rel=1e-9)
    k.move(0.0, VACUUM)
    k.move(0.01, VACUUM)
    assert k.force < 20, "sheets that parted hold no more"


@CC
def test_what_is_no_number_is_refused_and_changes_nothing():
    k = Kernel(KAPTON)
    k.move(0.01, VACUUM)
    before = k.state
    for bad in ((np.nan, VACUUM), (np.inf, VACUUM), (1e300, VACUUM), (0.01, -1.0), (0.01, np.nan)):
        with pytest.raises(QuantityError):
            k.move(*bad)
        with pytest.raises(QuantityError):
            k.peek(*bad)
        assert k.state == before
    with pytest.raises(QuantityError, match="compliance"):
        k.move(0.01, VACUUM, -1.0)
    assert k.move(-0.5, VACUUM) == 0 and k.flags & kernels.SLACK, "a rope may hang loose"


@pytest.mark.parametrize(
    ("values", "named"),
    [({"mount__spacers": False}, "mount.spacers")],
)
def test_a_law_that_is_not_in_the_kernel_is_refused(values, named):
    with pytest.raises(QuantityError) as caught:
        parameters(change(KAPTON, **values))
    assert caught.value.quantity == named


@CC
def test_single_precision_stays_within_millinewtons():
    worst = 0.0
    for seed in range(8):
        path, vacuum = history(KAPTON, seed)
        slow = Kernel(KAPTON).cycle(path, vacuum)
        fast = Kernel(KAPTON, precision="single").cycle(path, vacuum)
        worst = max(worst, float(np.abs(slow.force - fast.force).max()))
    assert 0 < worst < 5e-3
