"""A brake as if it were calibrated: with tests from 50 kPa to 70 kPa, and slips up to 20 mm."""

from __future__ import annotations

import math

import tomlkit

from layerjam.brake.device.evidence import Evidence, Part, state_fitted
from layerjam.brake.device.load import load

NAMES = ("scale_factor", "stiffness_measured", "enclosure_force")
NONE = (0.0, 0.0, 0.0)


def add_tests(name: str) -> str:
    """TOML text of a brake of the catalogue with tests: 1 % for the mean, 3 % for the next test."""
    file = load(name)

    def part(of: str, sd: float) -> Part:
        return Part(of, ((sd**2, 0.0, 0.0), (0.0, sd**2, 0.0), NONE), math.inf)

    entry = Evidence(
        command="calibrate",
        date="2026-11-29",
        tests=6,
        mountings=3,
        names=NAMES,
        exponent_sd=0.05,
        ranges={
            "vacuum": (50e3, 70e3),
            "slip": (0.0, 0.02),
            "force": (0.0, 150.0),
            "speed": (5e-3, 20e-3),
        },
        fitted=state_fitted("calibrate", file.known_values),
        parts=(part("mean", 0.01), part("test", 0.03)),
    )
    return f"{file.text}\n{tomlkit.dumps({'tested': [entry.to_toml()]})}"
