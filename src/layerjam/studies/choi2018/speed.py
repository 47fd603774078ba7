"""Claims on judder (Fig. 4) and on wet sheets (Fig. 6), and the study behind the first."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.load import load
from layerjam.mechanics.friction import holding_force, sheet_friction
from layerjam.mechanics.pull import brake_force
from layerjam.mechanics.stick_slip.laws import critical_speed, of_film, slow_saw
from layerjam.mechanics.stick_slip.wet import ILLUSTRATIVE, ILLUSTRATIVE_VISCOUS, wet_force
from layerjam.simulate.procedure import simple_pull
from layerjam.simulate.stack import tensile_stack
from layerjam.simulate.stick_slip import moving_mass, series_stiffness, slide_of, tooth
from layerjam.studies.choi2018.claims import Claim, beyond, statement
from layerjam.units import show

FULL, SLOW, FAST = 94.5e3, 1e-3, 25e-3
FILMS = {"Kapton": "choi2018-kapton", "PTFE": "choi2018-ptfe"}
STRIBECK = np.geomspace(1e-5, 1e2, 15)
"""Stribeck speeds of the study [m/s]: log-uniform prior, nothing is measured."""
DAMPING = np.geomspace(0.3, 300.0, 16)
"""Damping of mount and film of the study [N s/m], alike for both films; log-uniform prior."""
Array = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True, kw_only=True)
class FilmJudder:
    """What one film does at 94.5 kPa."""

    static: float
    """Table I with a, all interfaces at once [N]."""
    kinetic: float
    """[N]"""
    staggered: float
    """Greatest force with static friction where sheets let go one after another [N]."""
    together: float
    """Half of the saw's swing over kinetic force, Table I alone."""
    apart: float
    """The same with the staggered bound."""
    slack: bool
    """Whether Table I alone lets the spring go slack."""
    stiffness: float
    """[N/m]"""
    mass: float
    """[kg]"""
    judders: Array
    """(len(DAMPING), len(STRIBECK)) at 1 mm/s, with the staggered bound."""
    settles: float
    """Least damping without judder at 1 mm/s for a small v_s [N s/m]."""


def _saw_share(static: float, kinetic: float, stiffness: float, mass: float) -> tuple[float, bool]:
    saw = slow_saw(static, kinetic, stiffness, mass, SLOW)
    return float(saw.force_high - saw.force_low) / 2 / kinetic, bool(saw.slack)


def _least_damping(static: float, kinetic: float, stiffness: float, mass: float) -> float:
    """Damping [N s/m] at which the critical speed has come down to 1 mm/s."""
    from scipy.optimize import brentq

    limit = 2 * np.sqrt(stiffness * mass)

    def above(share: float) -> float:
        speed = critical_speed(static, kinetic, stiffness, mass, share * limit)
        return float(np.log(max(float(speed), 1e-300) / SLOW))

    return float(limit * brentq(above, 1e-4, 0.999))


def _study(name: str) -> FilmJudder:
    file = load(name)
    brake: Brake = file.brake
    static = float(holding_force(FULL, brake))
    kinetic = float(sheet_friction(0.0, FULL, brake))
    pull = simple_pull(FULL, SLOW, 0.005)
    tops = [float(tensile_stack(file, pull, static=s)[0].force.max()) for s in (True, False)]
    # the sleeve carries a little at the peak; the ratio to the same stack's kinetic peak leaves it
    staggered = kinetic * tops[0] / tops[1]
    spring, mass = series_stiffness(brake), moving_mass(brake)
    together, slack = _saw_share(static, kinetic, spring, mass)
    apart, _ = _saw_share(staggered, kinetic, spring, mass)
    curve = of_film(brake)
    ratio = staggered / kinetic
    at = slide_of(
        brake, vacuum=FULL, speed=SLOW, mass=mass, stiffness=spring, stribeck=curve, frozen=True
    )
    at = at._replace(rise=ratio - 1, stribeck=STRIBECK[None, :], damping=DAMPING[:, None])
    return FilmJudder(
        static=static, kinetic=kinetic, staggered=staggered, together=together, apart=apart,
        slack=slack, stiffness=spring, mass=mass, judders=tooth(at, swings=60).judders,
        settles=_least_damping(staggered, kinetic, spring, mass),
    )  # fmt: skip


@cache
def fig4_study() -> dict[str, FilmJudder]:
    """Both films of Table I at 94.5 kPa and 1 mm/s; a few seconds, done once."""
    return {film: _study(name) for film, name in FILMS.items()}


def judder_claims() -> list[Claim]:
    """Section III-A: which film judders."""
    study = fig4_study()
    kapton, ptfe = study["Kapton"], study["PTFE"]
    only = kapton.judders & ~ptfe.judders
    slow = STRIBECK[only.any(axis=0)]
    window = sorted((ptfe.settles, kapton.settles))
    ratios = [f"{f.settles / (2 * (f.stiffness * f.mass) ** 0.5):.2f}" for f in (ptfe, kapton)]
    holds = kapton.apart > ptfe.apart
    slack = ", the spring going slack" if ptfe.slack else ""
    words = (
        f"swing of the force over kinetic force: by table I alone ±{kapton.together:.0%} (Kapton) "
        f"and ±{ptfe.together:.0%} (PTFE{slack}); sheets that let go one after another leave "
        f"±{kapton.apart:.0%} and ±{ptfe.apart:.0%}. The order stays the opposite of Fig. 4"
    )
    found = (
        f"Kapton alone judders in {only.mean():.0%} of a wide prior"
        if only.any()
        else "nowhere in a wide prior does Kapton alone judder"
    )
    why = (
        f"v_s from {show(STRIBECK[0], 'm/s')} to {show(STRIBECK[-1], 'm/s')} and damping from "
        f"{show(DAMPING[0], 'N s/m')} to {show(DAMPING[-1], 'N s/m')}, log-uniform and alike for "
        f"both films, on a moving mass of half a brake (assumed). For small v_s it takes a damping "
        f"between {window[0]:.0f} and {window[1]:.0f} N s/m: PTFE's rig is softer, so that the "
        f"same damper creeps there (damping ratio {ratios[0]}; Kapton's limit is {ratios[1]})"
    )
    if only.any():
        why += (
            f"; v_s between {show(float(slow.min()), 'm/s', 2)} and "
            f"{show(float(slow.max()), 'm/s', 2)}"
        )
    return [
        statement(
            "Fig. 4: Kapton and polyester judder at 1 mm/s, PTFE hardly does", "III-A", holds,
            f"±{kapton.together:.0%} and ±{ptfe.together:.0%}", words,
        ),
        beyond(
            "Fig. 4: what would make Kapton judder and PTFE not", "III-A", "stick–slip", "",
            f"{why}. v_s, damping and mass are fitted to one sentence of the paper, none is "
            "measured; weakening with speed alone does not do it", ours=found,
        ),
    ]  # fmt: skip


def wet_claims() -> list[Claim]:
    """Section III-B, Fig. 6: wet sheets."""
    brake = load("choi2018-kapton").brake
    dry, dry_end = (float(brake_force(x, FULL, brake)) for x in (0.0, 0.04))
    slow, slow_end = (float(wet_force(x, SLOW, FULL, brake, ILLUSTRATIVE)) for x in (0.0, 0.04))
    fast = float(wet_force(0.0, FAST, FULL, brake, ILLUSTRATIVE))
    other = float(wet_force(0.0, FAST, FULL, brake, ILLUSTRATIVE_VISCOUS))
    steeper = (slow - slow_end) / (dry - dry_end)
    return [
        beyond(
            "Fig. 6: wet force at two speeds", "III-B", "curves", "",
            "the curves are not published, so nothing can be fitted; the law (Stribeck, adhesion, "
            "viscous part) can be, from your own pulls. An illustrative set gives a higher peak at "
            f"1 mm/s and a fall {steeper:.1f} times as steep, as the paper says. At 25 mm/s it "
            f"gives {fast:.0f} N, a second set {other:.0f} N: the two readings of the sentence",
            ours=f"illustrative: {slow:.0f} N wet, {dry:.0f} N dry at 1 mm/s",
        )
    ]  # fmt: skip
