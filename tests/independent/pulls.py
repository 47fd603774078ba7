"""Campaigns of pulls as a laboratory writes them: NumPy only, no part of layerjam.

The law is that of Choi et al. 2018 (eq. 4 to 7): sheets F = c (L - x), c = a mu (n - 1) W P, and an
enclosure 2 sqrt(E A P mu_e W x), with the slip x, in a rig of stiffness k: elongation u = x + F/k.
The brake is the Kapton brake of the paper; its numbers are repeated here on purpose.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

FRICTION, SHEETS, WIDTH, OVERLAP = 0.24, 11, 13e-3, 68e-3
WALL, MODULUS, SILICONE = 1e-3, 0.1e6, 0.80
SCALE_FACTOR, STIFFNESS = 0.875, 131e3
VACUUMS = (30e3, 55e3, 80e3)
BRAKE = "choi2018-kapton"


@dataclass(frozen=True, kw_only=True)
class Pull:
    """One pull: its true numbers, and what the laboratory states about it (SI units).

    `tare` [N] is added to all forces, `multiplier` multiplies them (a wrong unit). Static friction
    exceeds kinetic by the share `static`, which fades to 1/e over `fades` [m] of slip. `facts` are
    the lines of the sidecar besides the vacuum.
    """

    vacuum: float
    scale_factor: float = SCALE_FACTOR
    stiffness: float = STIFFNESS
    enclosure: float = 1.0
    true_vacuum: float | None = None
    tare: float = 0.0
    multiplier: float = 1.0
    static: float = 0.0
    fades: float = 30e-3
    overlap: float = OVERLAP
    noise: float = 0.05
    slack: float = 1e-3
    speed: float = 13e-3
    facts: Mapping[str, str] = field(default_factory=dict)

    @property
    def pressure(self) -> float:
        """True vacuum [Pa]."""
        return self.vacuum if self.true_vacuum is None else self.true_vacuum

    def sliding_force(self, slip: np.ndarray) -> np.ndarray:
        """Return the force [N] that keeps the brake sliding at a slip [m]."""
        per_length = self.scale_factor * FRICTION * (SHEETS - 1) * WIDTH * self.pressure
        fade = 1 + self.static * np.exp(-slip / self.fades)
        sleeve = 2 * np.sqrt(MODULUS * WIDTH * WALL * self.pressure * SILICONE * WIDTH * slip)
        return per_length * (self.overlap - slip) * fade + self.enclosure * sleeve

    def record(
        self, random: np.random.Generator, samples: int = 1500, travel: float = 0.04
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return time [s], elongation [m] and force [N] as the machine records them."""
        slip = np.concatenate([[0.0], np.geomspace(1e-9, 1.2 * travel, 4000)])
        force = self.sliding_force(slip)
        reached = slip + force / self.stiffness
        u = np.linspace(-self.slack, travel, samples)
        onset = reached[0]
        y = np.where(u < onset, self.stiffness * np.maximum(u, 0.0), np.interp(u, reached, force))
        y = self.multiplier * (y + self.tare + self.noise * random.standard_normal(samples))
        elongation = u + self.slack
        return elongation / self.speed, elongation, y


def write(
    folder: Path, pulls: Sequence[Pull], seed: int = 1, name: str = "pull-{:02d}.csv"
) -> list[Path]:
    """Write one CSV file and one sidecar per pull; return the paths of the CSV files."""
    random = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for number, pull in enumerate(pulls, 1):
        path = folder / name.format(number)
        time, elongation, force = pull.record(random)
        rows = [
            f"{t:.4f},{1e3 * u:.5f},{f:.4f}"
            for t, u, f in zip(time, elongation, force, strict=True)
        ]
        path.write_text("\n".join(["time (s),elongation (mm),force (N)", *rows, ""]), "utf-8")
        facts = {
            "vacuum": f'"{pull.vacuum / 1e3:.6g} kPa"',
            "speed": f'"{1e3 * pull.speed:.6g} mm/s"',
        }
        lines = [f"{key} = {text}" for key, text in {**facts, **pull.facts}.items()]
        path.with_name(path.name + ".toml").write_text("\n".join([*lines, ""]), "utf-8")
        paths.append(path)
    return paths


def repeats(
    random: np.random.Generator,
    vacuums: Sequence[float] = VACUUMS,
    count: int = 4,
    scatter: float = 0.02,
    **numbers: float,
) -> Iterator[Pull]:
    """Yield `count` pulls at each vacuum, each with its own friction, stiffness and enclosure."""
    for vacuum in vacuums:
        for _ in range(count):
            a, k = 1 + scatter * random.standard_normal(2)
            yield Pull(
                vacuum=vacuum,
                scale_factor=SCALE_FACTOR * a,
                stiffness=STIFFNESS * k,
                enclosure=1 + 0.05 * random.standard_normal(),
                noise=5e-4 * vacuum / 1e3,
                **numbers,
            )
