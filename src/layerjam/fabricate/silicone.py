"""Casting the enclosure: how much silicone, how hard it is to fill, whether the core bends.

C12 and C13 of the specification.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import partial

import numpy as np

from layerjam.device.workshop import Build, Casting
from layerjam.fabricate.lengths import Lengths, Mould
from layerjam.fabricate.mould import casting
from layerjam.fabricate.verdicts import Check
from layerjam.units import show

MOST_PRESSURE = 100e3
"""Above this a syringe by hand does not fill it [Pa]."""
BY_HAND = ", too much for a hand: use a press, a thinner silicone or a thicker wall"
BEND = 1e-4
"""By how much the core may bend before the wall is uneven [m]."""
LEAST_PUSH = 1.0
"""Force that the core should bear without that [N]."""
THIN = 0.3e-3
"""A thinner wall is not filled without the viscosity being known [m]."""


def cavity(lengths: Lengths) -> float:
    """Volume of silicone in the mould [m³]."""
    return casting(lengths).volume * 1e-9


def mixed(lengths: Lengths, build: Build, density: float) -> float:
    """Silicone to mix, waste included [kg]."""
    return cavity(lengths) * density * (1 + build.waste)


def halves(mix: str | None, mass: float) -> list[float] | None:
    """Masses [kg] of A and B for a mix such as "1A:1B"; None where it is not known."""
    found = re.fullmatch(r"\s*([\d.]+)\s*A\s*:\s*([\d.]+)\s*B.*", mix or "")
    if found is None:
        return None
    a, b = float(found.group(1)), float(found.group(2))
    return [mass * a / (a + b), mass * b / (a + b)] if a + b > 0 else None


def filling_pressure(lengths: Lengths, viscosity: float, pot_life: float) -> float:
    """Pressure [Pa] that fills the mould in half the pot life, the wall taken as a flat slot.

    12 η (V / ½ pot life) ℓ / (girth w³): Poiseuille's flow between two plates at the distance w, as
    wide as the girth in the middle of the wall, when the mould is just full and all of its length
    resists. Corners count as rounded; the sharp ones of the paper's brake let 5 % more pass.
    """
    found = lengths.mould
    wall = (found.outer_width - found.inner_width) / 2
    girth = 2 * (found.inner_width + found.inner_height) + math.pi * wall
    flow = cavity(lengths) / (pot_life / 2)
    return 12 * viscosity * flow * (found.casting / girth / wall**3) * 1e9


def core_force(lengths: Lengths, modulus: float) -> float:
    """Force [N] in the middle that bends the core, held at both ends, by 0.1 mm.

    192 E I δ/ℓ³, a beam clamped at both ends (Euler and Bernoulli), about its weaker axis.
    """
    found = lengths.mould
    sides = found.inner_width, found.inner_height
    inertia = np.maximum(*sides) * np.minimum(*sides) ** 3 / 12
    return 192 * modulus * inertia / found.casting**3 * BEND * 1e-3


def silicone_checks(build: Build, known: Casting, lengths: Lengths) -> Iterator[Check]:
    """C12 and C13."""
    yield _fill(known, lengths)
    force = core_force(lengths, build.print_modulus)
    yield Check(
        code="C13",
        key="core-bends",
        words=partial(_core_words, force, lengths.mould),
        value=force,
        limit=LEAST_PUSH,
        at_most=False,
        unit="N",
    )


def _core_words(force: float, found: Mould, ok: bool | None) -> str:
    said = f"the printed core bends by 0.1 mm under {show(force, 'N', 2)}"
    return said if ok else (
        f"{said}: cut the core from metal or acrylic, {found.core:.4g} mm × "
        f"{found.inner_width:.4g} mm × {found.inner_height:.4g} mm"
    )  # fmt: skip


def _fill(known: Casting, lengths: Lengths) -> Check:
    if known.viscosity is None or known.pot_life is None:
        missing = [name for name in ("viscosity", "pot_life") if getattr(known, name) is None]
        thin = lengths.wall < THIN * 1e3
        return Check(
            code="C12",
            key="fill",
            words=partial(_unknown_words, missing, lengths.wall * 1e-3),
            value=lengths.wall * 1e-3 if np.any(thin) else None,
            limit=THIN if np.any(thin) else MOST_PRESSURE,
            at_most=False,
            unit="m" if np.any(thin) else "Pa",
            otherwise="refused",
            applies=thin,
        )
    pressure = filling_pressure(lengths, known.viscosity, known.pot_life)
    return Check(
        code="C12",
        key="fill",
        words=partial(_fill_words, pressure),
        value=pressure,
        limit=MOST_PRESSURE,
        unit="Pa",
    )


def _unknown_words(missing: list[str], wall: float, ok: bool | None) -> str:
    what = " and ".join(f"enclosure.{name}" for name in missing)
    said = f"filling pressure not known: {what} {'is' if len(missing) == 1 else 'are'} not given"
    if ok is False:
        said += f", and a wall of {show(wall, 'm')} is not filled by guess"
    return said


def _fill_words(pressure: float, ok: bool | None) -> str:
    said = f"filling in half the pot life takes {show(pressure, 'Pa', 2)}"
    return said if ok else said + BY_HAND
