"""Arguments of every public law, inside and outside its domain, and families of random brakes."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from layerjam import laws
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.hyperelastic import Hyperelastic
from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.core.units import quantity, record
from layerjam.laws import Stribeck, WetFilm
from strategies import one, random_brakes

BRAKES, POINTS = 25, 4
Family = Callable[[int], Brake]
Numbers = tuple[np.ndarray, ...]


@record
class Warmth:
    """A further effect on the friction, as a user may write one."""

    rise: float = quantity("K", "temperature above that of the friction test", hi=200)

    def friction_factor(self, vacuum: Any, brake: Brake) -> Any:
        """Return the friction relative to that without the effect."""
        return 1 - 4e-3 * self.rise


def draw(seed: int, low: float, high: float) -> np.ndarray:
    return np.random.default_rng(seed).uniform(low, high, BRAKES)


def aged(seed: int) -> Brake:
    brakes = random_brakes(seed, BRAKES)
    film = replace(
        brakes.film, ageing=draw(seed, -0.01, 0.03), static_hold=draw(seed + 1, 1.0, 100.0)
    )
    return replace(brakes, film=film, effects=(Warmth(rise=draw(seed + 2, 0.0, 50.0)),))


def rubber(seed: int, **parts: Any) -> Brake:
    soft = Hyperelastic(strain=draw(seed, 2.0, 9.0), **parts)
    return replace(random_brakes(seed, BRAKES), hyperelastic=soft)


FAMILIES: dict[str, Family] = {
    "plain": lambda seed: random_brakes(seed, BRAKES),
    "spacers or a fan": lambda seed: random_brakes(seed, BRAKES, spacers=True),
    "pressure exponent": lambda seed: replace(
        random_brakes(seed, BRAKES, exponent=True), vacuum_share=draw(seed, 0.5, 1.0)
    ),
    "fan with an exponent": lambda seed: replace(
        random_brakes(seed, BRAKES, spacers=True, exponent=True),
        amplification_held=draw(seed, 1.0, 3.0),
        lowest_pressure=draw(seed + 1, 1e3, 4e4),
    ),
    "ageing and an effect": aged,
    "speed law": lambda seed: replace(
        random_brakes(seed, BRAKES),
        speed_law=SpeedLaw(
            power=draw(seed, 0.01, 0.5),
            test_speed=draw(seed + 1, 1e-3, 0.1),
            rest_speed=draw(seed + 2, 1e-3, 0.1),
        ),
    ),
    "rubber": lambda seed: rubber(
        seed, c10=draw(seed + 1, 1e4, 1e5), c01=draw(seed + 2, 1e3, 1e4), c20=draw(seed + 3, 0, 300)
    ),
    "rubber that softens": lambda seed: rubber(
        seed,
        mu1=draw(seed + 1, 1e4, 1e5),
        alpha1=draw(seed + 2, 2.0, 3.0),
        softening_r=draw(seed + 3, 1.2, 4.0),
        softening_m=draw(seed + 4, 1e3, 1e5),
        softening_beta=draw(seed + 5, 0.0, 1.0),
    ),
}
RANGES = {
    "slip": (0.0, 0.25), "elongation": (0.0, 0.2), "travel": (0.0, 0.2), "vacuum": (0.0, 1.1e5),
    "force": (0.0, 400.0), "mass": (0.05, 20.0), "speed": (0.0, 5.0), "spring": (3e3, 5e5),
    "gravity": (0.0, 12.0), "hold": (0.0, 1e5), "length": (0.01, 0.3), "deflection": (0.0, 0.02),
    "angle": (0.0, 3.0), "friction": (0.0, 1.0), "radius": (5e-3, 0.1), "tension": (0.0, 100.0),
    "heat": (0.0, 20.0), "allowed_rise": (1.0, 40.0), "film_coefficient": (1.0, 30.0),
    "static": (1.0, 20.0), "kinetic": (0.5, 15.0), "stiffness": (1e3, 1e5), "damping": (0.0, 5.0),
    "damping_ratio": (0.0, 1.0), "drop": (0.0, 5.0), "stribeck_speed": (1e-4, 1e-2),
    "exponent": (0.5, 2.0), "scale_factor": (0.5, 2.0),
}  # fmt: skip
OUTSIDE = (-1.0, 0.0, np.nan, np.inf)
MARCHING = {("speed law", "stop"), ("speed law", "tuned_vacuum")}
"""Laws that march for one family only: JAX runs them in both cases, and one takes minutes."""
MARCHES = ("brake_cycle", "enclosure_cycle", "stop_in_time")
LAWS = {
    name: law
    for name, law in vars(laws).items()
    if inspect.isfunction(law) and law.__module__.startswith("layerjam") and name not in MARCHES
}


def cases(name: str, seed: int) -> tuple[np.ndarray, ...]:
    """Arguments of a law except the brake, shape (BRAKES, POINTS) each; a fifth is outside."""
    rng = np.random.default_rng([seed, *name.encode()])
    shape, rows = (BRAKES, POINTS), []
    for parameter in inspect.signature(LAWS[name]).parameters:
        if parameter in ("brake", "curve", "film"):
            continue
        inside = rng.uniform(*RANGES[parameter], shape)
        rows.append(np.where(rng.random(shape) < 0.1, rng.choice(OUTSIDE, shape), inside))
    return tuple(rows)


CONSTANTS = {
    "curve": Stribeck(static=0.4, kinetic=0.3, speed=1e-3, exponent=1.5, viscous=0.1),
    "film": WetFilm(static=0.3, kinetic=0.1, speed=2e-3, adhesion=300.0, viscosity=500.0),
}


def call(name: str, numbers: tuple[Any, ...], brake: Brake) -> list[Any]:
    """Return the results of a law as a list of arrays."""
    given = iter(numbers)
    parts = inspect.signature(LAWS[name]).parameters
    args = [brake if p == "brake" else CONSTANTS.get(p) or next(given) for p in parts]
    result = LAWS[name](*args)
    return list(result) if isinstance(result, tuple) else [result]


def on_numpy(name: str, numbers: Numbers, brakes: Brake, count: int = BRAKES) -> list[np.ndarray]:
    """Return the results of a law for one brake after the other."""
    rows = [call(name, tuple(n[i] for n in numbers), one(brakes, i)) for i in range(count)]
    columns = zip(*rows, strict=True)
    return [np.stack([np.asarray(value, float) for value in column]) for column in columns]
