"""Ten designs whose best is known in closed form or by trying them all, and their specifications.

Kapton's brake of the paper: c = a mu (n-1) W P a metre of overlap, lengths and masses as in its
file. Every function gives (specification, quantity, its best value).
"""

from __future__ import annotations

import json
import math

import numpy as np

from layerjam.brake.mechanics.stop.tune import tuned_vacuum
from strategies import KAPTON as B

S, F, E = B.sheets, B.film, B.enclosure
FULL = B.site.atmosphere
HOLD = B.scale_factor * F.static
SPARE = S.length - S.overlap
SLEEVE = S.free_left + S.free_right
HIGH = S.count * S.thickness


def spec(vary: str, constraints: list[str], objectives: list[str], more: str = "", top: str = ""):
    return (
        f'name = "known"\nbrake = "choi2018-kapton"\nwithout = ["buildable", "drawn_mass"]\n{top}'
        f"constraints = {json.dumps(constraints)}\nobjectives = {json.dumps(objectives)}\n"
        f"{more}\n[vary]\n{vary}\n"
    )


def mass_of(count: float, width: float, overlap: float) -> float:
    """Mass of a brake, written out once more [kg]."""
    sheets = count * width * S.thickness * (overlap + SPARE) * F.density
    section = 2 * E.wall * (width + count * S.thickness) + 4 * E.wall**2
    return sheets + section * (overlap + SLEEVE) * E.density + B.fittings_mass


def narrowest():
    """The least mass that holds 250 N, by its width: W = F/(a mu_s (n-1) L2 P)."""
    width = 250 / (HOLD * 10 * S.overlap * FULL)
    text = spec('width = { from = "5 mm", to = "30 mm", step = "0.5 mm" }',
                ["holding_force >= 250 N"], ["minimise mass"])  # fmt: skip
    return text, "mass", mass_of(11, width, S.overlap)


def longest():
    """The greatest hold in 150 mm: the overlap is what free lengths and clamps leave."""
    overlap = 0.150 - SLEEVE - 2 * B.mount.clamped_length
    text = spec('overlap = { from = "20 mm", to = "200 mm", step = "7 mm" }',
                ["clamped_length <= 150 mm"], ["maximise holding_force"])  # fmt: skip
    return text, "holding_force", HOLD * 10 * S.width * FULL * overlap


def smallest_box():
    """Least volume at a given W L2 = A: W = sqrt(2 w A/b), b the length beside the overlap."""
    area = 250 / (HOLD * 10 * FULL)
    beside = SLEEVE + 2 * B.mount.clamped_length
    width = math.sqrt(2 * E.wall * area / beside)
    text = spec('width = { from = "2 mm", to = "40 mm", step = "2 mm" }\n'
                'overlap = { from = "20 mm", to = "400 mm", step = "20 mm" }\n'
                'vacuum = "101.325 kPa"',
                ["holding_force >= 250 N"], ["minimise volume"])  # fmt: skip
    # the screw's hole is 3 mm: the best width lies above it
    assert width > B.mount.screw_hole
    box = (width + 2 * E.wall) * (HIGH + 2 * E.wall) * (area / width + beside)
    return text, "volume", box


def lightest():
    """Least mass at a given W L2 = A: both terms of dm/dW balance."""
    area = 600 / (HOLD * 10 * FULL)
    falls = (2 * E.wall * HIGH + 4 * E.wall**2) * E.density * area
    rises = 11 * S.thickness * F.density * SPARE + 2 * E.wall * SLEEVE * E.density
    width = math.sqrt(falls / rises)
    text = spec('width = { from = "4 mm", to = "60 mm", step = "4 mm" }\n'
                'overlap = { from = "20 mm", to = "500 mm", step = "20 mm" }',
                ["holding_force >= 600 N"], ["minimise mass"])  # fmt: skip
    return text, "mass", mass_of(11, width, area / width)


def fewest_sheets():
    """Whole sheets: n - 1 = the least whole number that holds 400 N."""
    count = 1 + math.ceil(400 / (HOLD * S.width * S.overlap * FULL))
    text = spec("count = { from = 2, to = 60, step = 1 }",
                ["holding_force >= 400 N"], ["minimise mass"])  # fmt: skip
    return text, "mass", mass_of(count, S.width, S.overlap)


def densest():
    """Force density over sheets and vacuum, by trying them all on the formulas written out."""
    best = 0.0
    for count in range(2, 81):
        c = B.scale_factor * F.kinetic * (count - 1) * S.width * 94.5e3
        e = 2 * math.sqrt(E.modulus * S.width * E.wall * F.friction_on_silicone * S.width * 94.5e3)
        best = max(best, (c * S.overlap + e**2 / (4 * c)) / mass_of(count, S.width, S.overlap))
    text = spec('count = { from = 2, to = 80, step = 1 }\nvacuum = ["50 kPa", "94.5 kPa"]',
                ["height <= 30 mm"], ["maximise force_density"])  # fmt: skip
    return text, "force_density", best


def fastest():
    """The shortest rise that holds 200 N: P = F/(a mu_s (n-1) W L2), V/Q ln((1-.1r)/(1-.9r))."""
    share = 200 / (HOLD * 10 * S.width * S.overlap) / FULL
    time = 7.503e-6 / 3.33e-6 * math.log((1 - 0.1 * share) / (1 - 0.9 * share))
    text = spec('vacuum = { from = "20 kPa", to = "100 kPa", step = "9 kPa" }',
                ["holding_force >= 200 N"], ["minimise rise_time"],
                top='line = "choi2018"\n')  # fmt: skip
    return text, "rise_time", time


def hardest():
    """The greatest hold at a stress margin of 5: c L2 + e^2/4c is linear in P."""
    bears = F.strength / 5 * 5 * (S.width - B.mount.screw_hole) * S.thickness
    sleeve = E.modulus * E.wall * F.friction_on_silicone * S.width
    c = B.scale_factor * F.kinetic * 10
    vacuum = (bears - sleeve / c) / (c * S.width * S.overlap)
    text = spec('vacuum = { from = "20 kPa", to = "100 kPa", step = "9 kPa" }',
                ["stress_margin >= 5"], ["maximise holding_force"])  # fmt: skip
    return text, "holding_force", HOLD * 10 * S.width * S.overlap * vacuum


def softest():
    """The least peak that stops 1 kg within 40 mm: at the tuned vacuum, where it takes them all."""
    k = B.stiffness_measured
    vacuum = float(tuned_vacuum(1.0, 2.5, 0.04, k, B.site.gravity, B))
    c = B.scale_factor * F.kinetic * 10 * S.width * vacuum
    e = 2 * math.sqrt(E.modulus * E.wall * F.friction_on_silicone * vacuum) * S.width
    text = spec('vacuum = { from = "10 kPa", to = "100 kPa", step = "9 kPa" }', [],
                ["minimise stop_peak"],
                '[stop]\nmass = "1 kg"\nspeed = "2.5 m/s"\ntravel = "40 mm"\n')  # fmt: skip
    return text, "stop_peak", c * S.overlap + e**2 / (4 * c)


def balanced():
    """Mass against hold to the power 0.4, by the overlap: L2 = q m0/(m1 (1 - q))."""
    share = 0.4
    slope = mass_of(11, S.width, 1.0) - mass_of(11, S.width, 0.0)
    overlap = share * mass_of(11, S.width, 0.0) / (slope * (1 - share))
    text = spec('overlap = { from = "20 mm", to = "500 mm", step = "40 mm" }', [],
                ["minimise mass", "maximise holding_force"],
                top=f"weights = [1, {share}]\n")  # fmt: skip
    return text, "mass", mass_of(11, S.width, overlap)


PROBLEMS = (
    narrowest, longest, smallest_box, lightest, fewest_sheets, densest, fastest, hardest, softest,
    balanced,
)  # fmt: skip
assert np.isclose(mass_of(11, S.width, S.overlap), 0.020, rtol=1e-3)
