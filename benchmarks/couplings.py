"""What a coupling of the brake to a mass costs in accuracy, by the kernel that every FMU holds.

python -m benchmarks.couplings
"""

from __future__ import annotations

from collections.abc import Callable

import layerjam as lj
from layerjam.brake.kernel.kernel import Kernel

MASS, SPEED, VACUUM, ROPE = 1.0, 2.5, 94.5e3, 16.8e3
GRAVITY = lj.load("choi2018-kapton").brake.site.gravity
STEPS = (1e-3, 0.5e-3, 0.1e-3)
Coupling = Callable[[Kernel, float], float]


def _kernel() -> Kernel:
    return Kernel(lj.load("choi2018-kapton"), rope_stiffness=ROPE)


def jacobi(kernel: Kernel, step: float, lead: float = 0.0) -> float:
    """Mass and brake step at once; `lead` 1 lets the brake go on at the velocity it was told."""
    place, speed = 0.0, SPEED
    while speed > 0:
        force = kernel.force
        kernel.move(place + lead * speed * step, VACUUM)
        gain = step * (GRAVITY - force / MASS)
        place, speed = place + step * (speed + gain / 2), speed + gain
    return kernel.slip


def gauss_seidel(kernel: Kernel, step: float) -> float:
    """The mass first (semi-implicit Euler), then the brake to where it is."""
    place, speed = 0.0, SPEED
    while speed > 0:
        speed += step * (GRAVITY - kernel.force / MASS)
        place += speed * step
        kernel.move(place, VACUUM)
    return kernel.slip


def trapezoid(kernel: Kernel, step: float) -> float:
    """Implicit: Newton's method on the force at the end of the step, asked without committing."""
    place, speed = 0.0, SPEED
    while speed > 0:
        start, ahead = kernel.force, speed
        for _ in range(20):
            there = place + step * (speed + ahead) / 2
            before = kernel.state
            force = kernel.move(there, VACUUM)
            slope = kernel.tangent()
            kernel.state = before
            gap = ahead - speed - step * (GRAVITY - (start + force) / 2 / MASS)
            change = gap / (1 + step**2 * slope / 4 / MASS)
            ahead -= change
            if abs(change) < 1e-13:
                break
        place, speed = place + step * (speed + ahead) / 2, ahead
        kernel.move(place, VACUUM)
    return kernel.slip


COUPLINGS: tuple[tuple[str, Coupling], ...] = (
    ("both at once, elongation only", jacobi),
    ("both at once, elongation and velocity", lambda k, h: jacobi(k, h, 1.0)),
    ("the mass first, then the brake", gauss_seidel),
    ("implicit, with the FMU's slope", trapezoid),
)


def table() -> str:
    """Errors of the slip [um] as a table in Markdown."""
    drop = lj.drop("choi2018-kapton", mass=MASS, speed=SPEED, vacuum=VACUUM, rope_stiffness=ROPE)
    exact = float(drop.slip or 0)
    head = "| coupling | " + " | ".join(f"{1e3 * step:g} ms" for step in STEPS) + " |"
    rows = [head, "|---|" + "---|" * len(STEPS)]
    for name, couple in COUPLINGS:
        errors = (f"{1e6 * (couple(_kernel(), step) - exact):+.1f} µm" for step in STEPS)
        rows.append(f"| {name} | " + " | ".join(errors) + " |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
