"""Claims about stick–slip (Fig. 4) and wet sheets (Fig. 6), and a study of stick–slip."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.friction import holding_force, sheet_friction
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stick_slip.laws import critical_speed, film_curve, slow_saw
from layerjam.brake.mechanics.stick_slip.wet import ILLUSTRATIVE, ILLUSTRATIVE_VISCOUS, wet_force
from layerjam.brake.simulate.procedure import simple_pull
from layerjam.brake.simulate.stack import tensile_stack
from layerjam.brake.simulate.stick_slip import (
    make_slide,
    moving_mass,
    series_stiffness,
    single_event,
)
from layerjam.core.threads import cache_threadsafe
from layerjam.core.units import show
from layerjam.studies.choi2018.claims import Claim, claim

FULL, SLOW, FAST = 94.5e3, 1e-3, 25e-3
FILMS = {"Kapton": "choi2018-kapton", "PTFE": "choi2018-ptfe"}
STRIBECK = np.geomspace(1e-5, 1e2, 15)
"""Stribeck speeds in the study [m/s]: a log-uniform prior, for lack of measurements."""
DAMPING = np.geomspace(0.3, 300.0, 16)
"""Damping of mount and film in the study [N s/m], the same for both films: a log-uniform prior."""
Array = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True, kw_only=True)
class FilmJudder:
    """Stick–slip of one film at 94.5 kPa."""

    together: float
    """Ratio of half the sawtooth's peak-to-peak force to the kinetic force, from Table I alone."""
    apart: float
    """The same ratio with the upper bound for staggered sliding."""
    slack: bool
    """Whether the spring becomes slack, from Table I alone."""
    stiffness: float
    """Stiffness [N/m]."""
    mass: float
    """Mass [kg]."""
    judders: Array
    """Whether stick–slip occurs at 1 mm/s with the staggered bound, shape (DAMPING, STRIBECK)."""
    settles: float
    """Smallest damping [N s/m] without stick–slip at 1 mm/s, for a small v_s."""


def _saw_ratio(static: float, kinetic: float, stiffness: float, mass: float) -> tuple[float, bool]:
    saw = slow_saw(static, kinetic, stiffness, mass, SLOW)
    return float(saw.force_high - saw.force_low) / 2 / kinetic, bool(saw.slack)


def _find_damping_limit(static: float, kinetic: float, stiffness: float, mass: float) -> float:
    """Return the damping [N s/m] at which the critical speed is 1 mm/s."""
    from scipy.optimize import brentq

    limit = 2 * np.sqrt(stiffness * mass)

    def excess_share(share: float) -> float:
        speed = critical_speed(static, kinetic, stiffness, mass, share * limit)
        return float(np.log(max(float(speed), 1e-300) / SLOW))

    return float(limit * brentq(excess_share, 1e-4, 0.999))


def _compute_film_judder(name: str) -> FilmJudder:
    file = load(name)
    brake: Brake = file.brake
    static = float(holding_force(FULL, brake))
    kinetic = float(sheet_friction(0.0, FULL, brake))
    pull = simple_pull(FULL, SLOW, 0.005)
    tops = [float(tensile_stack(file, pull, static=s)[0].force.max()) for s in (True, False)]
    # the ratio to the kinetic peak of the same stack excludes the enclosure's force at the peak
    staggered_force = kinetic * tops[0] / tops[1]
    spring, mass = series_stiffness(brake), moving_mass(brake)
    together, slack = _saw_ratio(static, kinetic, spring, mass)
    staggered_share, _ = _saw_ratio(staggered_force, kinetic, spring, mass)
    curve = film_curve(brake)
    ratio = staggered_force / kinetic
    slide = make_slide(
        brake, vacuum=FULL, speed=SLOW, mass=mass, stiffness=spring, stribeck=curve, frozen=True
    )
    slide = slide._replace(rise=ratio - 1, stribeck=STRIBECK[None, :], damping=DAMPING[:, None])
    return FilmJudder(
        together=together,
        apart=staggered_share,
        slack=slack,
        stiffness=spring,
        mass=mass,
        judders=single_event(slide, swings=60).judders,
        settles=_find_damping_limit(staggered_force, kinetic, spring, mass),
    )


@cache_threadsafe
def study_fig4() -> dict[str, FilmJudder]:
    """Return both films of Table I at 94.5 kPa and 1 mm/s; cached because it takes seconds."""
    return {film: _compute_film_judder(name) for film, name in FILMS.items()}


def judder_claims() -> list[Claim]:
    """Return the claims in section III-A: which film shows stick–slip."""
    study = study_fig4()
    kapton, ptfe = study["Kapton"], study["PTFE"]
    kapton_only = kapton.judders & ~ptfe.judders
    speeds = STRIBECK[kapton_only.any(axis=0)]
    finding = "in no sample of a wide prior does only Kapton stick and slip"
    range_note = ""
    if kapton_only.any():
        finding = f"in {kapton_only.mean():.0%} of a wide prior, only Kapton sticks and slips"
        edges = (show(float(v), "m/s", 2) for v in (speeds.min(), speeds.max()))
        range_note = f"; v_s between {' and '.join(edges)}"
    together: dict[str, Any] = {"kapton": kapton.together, "ptfe": ptfe.together}
    staggered_bounds: dict[str, Any] = {"kapton_apart": kapton.apart, "ptfe_apart": ptfe.apart}
    slack = ", with the spring becoming slack" if ptfe.slack else ""
    ranges: dict[str, Any] = {
        "speeds": [show(v, "m/s") for v in (STRIBECK[0], STRIBECK[-1])],
        "dampings": [show(v, "N s/m") for v in (DAMPING[0], DAMPING[-1])],
        "window": sorted((ptfe.settles, kapton.settles)),
        "ratios": [f.settles / (2 * (f.stiffness * f.mass) ** 0.5) for f in (ptfe, kapton)],
    }
    is_true = kapton.apart > ptfe.apart
    return [
        claim("fig4-judder", holds=is_true, slack=slack, **together, **staggered_bounds),
        claim("why-judder", finding, between=range_note, **ranges),
    ]


def wet_claims() -> list[Claim]:
    """Return the claims in section III-B, Fig. 6: wet sheets."""
    brake = load("choi2018-kapton").brake
    dry, dry_end = (float(brake_force(x, FULL, brake)) for x in (0.0, 0.04))
    slow, slow_end = (float(wet_force(x, SLOW, FULL, brake, ILLUSTRATIVE)) for x in (0.0, 0.04))
    sets = ILLUSTRATIVE, ILLUSTRATIVE_VISCOUS
    fast, other_fast = (float(wet_force(0.0, FAST, FULL, brake, film)) for film in sets)
    steeper = (slow - slow_end) / (dry - dry_end)
    our_forces = f"illustrative: {slow:.0f} N wet, {dry:.0f} N dry at 1 mm/s"
    return [claim("wet", our_forces, steeper=steeper, fast=fast, other=other_fast)]
