"""The stack: cost of an increment over the number of sheets, and many stacks at once.

What a user would pick instead for one increment is a general solver for the same minimum: SciPy's
bounded least squares on the dual.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import Bounds, minimize

from benchmarks.timing import Row, median
from layerjam.brake.device.load import load
from layerjam.brake.kernel.stack import pull_stack
from layerjam.brake.mechanics.stack.solve import Stack
from layerjam.brake.simulate.stack_layout import make_stack
from layerjam.brake.simulate.stack_spread import peak_spread

VACUUM = 94.5e3
INCREMENTS = 400
COUNTS = (11, 30, 100, 300, 1000, 2000)
MANY = 100_000


def stack_with(count: int) -> Stack:
    """The Kapton brake with `count` sheets, in its sleeve, on a mount as much stiffer.

    On the mount of 11 sheets a stack of 600 snaps, and the pull ends there.
    """
    brake = load("choi2018-kapton").brake
    return make_stack(
        replace(brake, sheets=replace(brake.sheets, count=count)), VACUUM, mount=140e3 * count / 11
    )


def seconds(count: int) -> float:
    """Median seconds of one pull to twice the elongation at the peak, in 400 increments."""
    stack = stack_with(count)
    end = 2 * float(stack.friction.sum()) * (1 / stack.mount + 4 / float(stack.springs.sum()))
    path = np.linspace(0, end, INCREMENTS + 1)[1:]
    return median(lambda: pull_stack(path, stack))


def by_quasi_newton(stack: Stack, cap: float) -> object:
    """One increment's dual, |f| <= c, by SciPy's L-BFGS-B, as a user would write it."""
    n = len(stack.springs)
    difference = np.eye(n - 1, n, 1) - np.eye(n - 1, n)
    home = np.where(stack.right, cap, 0.0)
    scaled = difference / stack.springs

    def dual(f: np.ndarray) -> tuple[float, np.ndarray]:
        pull = scaled @ (difference.T @ f)
        gap = difference @ home
        return float(f @ pull / 2 - f @ gap), pull - gap

    bounds = Bounds(-stack.friction, stack.friction)
    return minimize(dual, np.zeros(n - 1), jac=True, bounds=bounds, method="L-BFGS-B")


def rows() -> list[Row]:
    """Seconds, the fitted exponent, and milliseconds a stack."""
    times = {count: seconds(count) for count in COUNTS}
    exponent = np.polyfit(np.log(COUNTS), np.log([times[c] for c in COUNTS]), 1)[0]
    stack = stack_with(11)
    general = INCREMENTS * median(lambda: by_quasi_newton(stack, 1e-4), 5)
    out = [
        Row("400 increments, 11 sheets", times[11], 3e-3, general, "one by one in SciPy L-BFGS-B"),
        Row("400 increments, 2,000 sheets", times[2000]),
        Row("exponent, 11 to 2,000 sheets", float(exponent), 1.1, unit="(sheets)"),
    ]
    file = load("choi2018-kapton")
    batch = median(lambda: peak_spread(file, VACUUM, 0.1, MANY), 3)
    apart = np.log(times[2000] / times[11]) / np.log(2000 / 11)
    out.append(Row("  between the ends alone", float(apart), None, unit="(sheets)"))
    out.append(Row("a stack of 100,000 at once", batch / MANY, 1e-4))
    static = median(lambda: peak_spread(file, VACUUM, 0.1, 10_000, static=True), 3)
    out.append(Row("  with static friction, of 10,000", static / 10_000))
    return out
