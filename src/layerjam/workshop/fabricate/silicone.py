"""Casting of the enclosure: amount of silicone, filling pressure and bending of the core.

These are checks C12 and C13 of the specification.
"""

import math
import re
from collections.abc import Iterator
from functools import partial

import numpy as np

from layerjam.brake.device.workshop import Build, Casting
from layerjam.core.units import show
from layerjam.workshop.fabricate.lengths import Lengths, Mould
from layerjam.workshop.fabricate.mould import make_casting
from layerjam.workshop.fabricate.verdicts import Check

MOST_PRESSURE = 100e3
"""Maximum pressure from a syringe that is pressed by hand [Pa]."""
BY_HAND = ", which is too much by hand: use a press, a less viscous silicone or a thicker wall"
BEND = 1e-4
"""Deflection of the core above which the wall is uneven [m]."""
LEAST_PUSH = 1.0
"""Smallest force that should cause this deflection [N]."""
THIN = 0.3e-3
"""Wall thickness below which filling requires a known viscosity [m]."""


def cavity_volume(lengths: Lengths) -> float:
    """Return the volume of silicone in the mould [m³]."""
    return make_casting(lengths).volume * 1e-9


def compute_mix_mass(lengths: Lengths, build: Build, density: float) -> float:
    """Return the mass of silicone to mix, including waste [kg]."""
    return cavity_volume(lengths) * density * (1 + build.waste)


def split_mix(mix: str | None, mass: float) -> list[float] | None:
    """Return the masses [kg] of A and B for a mix such as "1A:1B"; None if the mix is unknown."""
    match = re.fullmatch(r"\s*([\d.]+)\s*A\s*:\s*([\d.]+)\s*B.*", mix or "")
    if match is None:
        return None
    a, b = float(match.group(1)), float(match.group(2))
    return [mass * a / (a + b), mass * b / (a + b)] if a + b > 0 else None


def filling_pressure(lengths: Lengths, viscosity: float, pot_life: float) -> float:
    """Return the pressure [Pa] that fills the mould, treated as a flat slot, in half the pot life.

    It is 12 η (V / ½ pot life) ℓ / (girth w³), the Poiseuille flow between two plates a distance w
    apart and as wide as the girth at mid-wall. The mould is just full, so its whole length resists.
    Corners count as rounded; with the sharp corners of the paper's brake, the flow is 5 % higher.
    """
    mould = lengths.mould
    wall = (mould.outer_width - mould.inner_width) / 2
    girth = 2 * (mould.inner_width + mould.inner_height) + math.pi * wall
    flow = cavity_volume(lengths) / (pot_life / 2)
    return 12 * viscosity * flow * (mould.casting / girth / wall**3) * 1e9


def core_force(lengths: Lengths, modulus: float) -> float:
    """Return the force [N] that bends the middle of the core by 0.1 mm, with both ends held.

    It is 192 E I δ/ℓ³, for a beam clamped at both ends (Euler and Bernoulli), about its weaker
    axis.
    """
    mould = lengths.mould
    sides = mould.inner_width, mould.inner_height
    inertia = np.maximum(*sides) * np.minimum(*sides) ** 3 / 12
    return 192 * modulus * inertia / mould.casting**3 * BEND * 1e-3


def silicone_checks(build: Build, material: Casting, lengths: Lengths) -> Iterator[Check]:
    """Yield the checks C12 and C13."""
    yield _filling_check(material, lengths)
    force = core_force(lengths, build.print_modulus)
    yield Check(
        code="C13",
        key="core-bends",
        words=partial(_describe_core_force, force, lengths.mould),
        value=force,
        limit=LEAST_PUSH,
        at_most=False,
        unit="N",
    )


def _describe_core_force(force: float, mould: Mould, ok: bool | None) -> str:
    text = f"the printed core bends by 0.1 mm under {show(force, 'N', 2)}"
    return text if ok else (
        f"{text}: cut the core from metal or acrylic, {mould.core:.4g} mm × "
        f"{mould.inner_width:.4g} mm × {mould.inner_height:.4g} mm"
    )  # fmt: skip


def _filling_check(material: Casting, lengths: Lengths) -> Check:
    if material.viscosity is None or material.pot_life is None:
        missing = [name for name in ("viscosity", "pot_life") if getattr(material, name) is None]
        thin = lengths.wall < THIN * 1e3
        return Check(
            code="C12",
            key="fill",
            words=partial(_describe_missing_input, missing, lengths.wall * 1e-3),
            value=lengths.wall * 1e-3 if np.any(thin) else None,
            limit=THIN if np.any(thin) else MOST_PRESSURE,
            at_most=False,
            unit="m" if np.any(thin) else "Pa",
            otherwise="refused",
            applies=thin,
        )
    pressure = filling_pressure(lengths, material.viscosity, material.pot_life)
    return Check(
        code="C12",
        key="fill",
        words=partial(_describe_filling, pressure),
        value=pressure,
        limit=MOST_PRESSURE,
        unit="Pa",
    )


def _describe_missing_input(missing: list[str], wall: float, ok: bool | None) -> str:
    inputs = " and ".join(f"enclosure.{name}" for name in missing)
    text = f"filling pressure unknown: {inputs} {'is' if len(missing) == 1 else 'are'} not given"
    if ok is False:
        text += f", and a wall of {show(wall, 'm')} is too thin to leave it unknown"
    return text


def _describe_filling(pressure: float, ok: bool | None) -> str:
    text = f"filling within half the pot life requires a pressure of {show(pressure, 'Pa', 2)}"
    return text if ok else text + BY_HAND
