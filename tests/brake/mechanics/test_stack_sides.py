"""A stack is the same seen from either of its caps and from either of its faces."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.brake.kernel.stack import pull_stack
from layerjam.brake.mechanics.stack.solve import Stack
from layerjam.brake.simulate.stack_layout import Interfaces, make_stack
from strategies import KAPTON

PATH = np.concatenate([np.linspace(0, 0.02, 41), np.linspace(0.02, 0.0195, 11)[1:]])


def uneven(count: int) -> Stack:
    """Soft sheets and interfaces that all differ, in an enclosure with a fifth of the force."""
    random = np.random.default_rng(count)
    stack = make_stack(KAPTON, 5e3, interfaces=Interfaces(friction=np.exp(random.normal(0, 1, 10))))
    stack = stack._replace(springs=stack.springs * random.uniform(0.01, 0.02, 11))
    first = {name: getattr(stack, name)[: count - 1] for name in ("friction", "ratio", "length")}
    sheets = {name: getattr(stack, name)[:count] for name in ("springs", "right")}
    return stack._replace(**first, **sheets, ends=np.array([0, count - 1]))


@pytest.mark.parametrize("count", [10, 11])
def test_a_pull_does_not_depend_on_which_cap_is_held_or_which_sheet_is_first(count: int) -> None:
    stack = uneven(count)
    names = ("springs", "right", "friction", "ratio", "length")
    other_cap = stack._replace(right=~stack.right)
    upside_down = stack._replace(**{name: getattr(stack, name)[::-1].copy() for name in names})
    run = pull_stack(PATH, stack)
    for same, order in ((other_cap, 1), (upside_down, -1)):
        mirrored = pull_stack(PATH, same)
        assert mirrored.force == pytest.approx(run.force, rel=1e-9, abs=1e-9)
        assert mirrored.slip[:, ::order] == pytest.approx(run.slip, rel=1e-9, abs=1e-12)
        assert mirrored.heat == pytest.approx(run.heat, rel=1e-9, abs=1e-12)
