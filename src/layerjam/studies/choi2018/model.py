"""Claims that can be tested with the force laws."""

from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake, enclosure_mass, mass, sheet_mass
from layerjam.brake.device.load import load
from layerjam.brake.fluid.closed_forms import rise_time
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.mechanics.enclosure import enclosure_force, enclosure_law, enclosure_stretch
from layerjam.brake.mechanics.energy import slip_work
from layerjam.brake.mechanics.friction import friction_per_contact, holding_force, sheet_friction
from layerjam.brake.mechanics.limits import buckling_force
from layerjam.brake.mechanics.pull import brake_force, peak, peak_vacuum
from layerjam.brake.mechanics.stiffness import (
    mount_stiffness,
    stiffness_before_slip,
    stiffness_sliding,
)
from layerjam.brake.mechanics.stop.exact import STOPPED, stop
from layerjam.brake.mechanics.stop.tune import tuned_vacuum, vacuum_eq10
from layerjam.brake.simulate.drop import series_spring
from layerjam.brake.simulate.procedure import simple_pull
from layerjam.brake.simulate.rope_alone import simulate_damped_rope
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.studies.choi2018.claims import Claim, claim
from layerjam.studies.choi2018.figures import CALIBRATED, FULL, NAMES, STIFFNESSES, TESTED
from layerjam.workshop.design.published import published_devices

G = 9.80665


def load_brakes() -> tuple[Brake, Brake]:
    """Return the paper's calibrated brakes: Kapton and PTFE."""
    return load("choi2018-kapton").brake, load("choi2018-ptfe").brake


def _compute_peak(brake: Brake) -> float:
    """Return the peak force of a pull to 40 mm at 94.5 kPa [N]."""
    return float(peak(FULL, TESTED, brake).force)


def claim_structure() -> list[Claim]:
    """Return the claims in section II-A: description of the brake."""
    kapton, _ = load_brakes()
    sheets = kapton.sheets
    buckling = float(buckling_force(0.0, kapton))
    top = float(peak(FULL, sheets.usable_travel, kapton).force)
    parts = sheets.count * sheet_mass(kapton), enclosure_mass(kapton)
    masses = (*parts, mass(kapton) - sum(parts))
    sheets_mass, enclosure, other_mass = (show(m, "kg") for m in masses)
    return [
        claim("stretches", (sheets.overlap - sheets.usable_travel) * 1e3),
        claim("weight", sum(parts) * 1e3, sheets=sheets_mass, enclosure=enclosure, left=other_mass),
        claim("buckles", holds=buckling < top / 100, one=buckling, top=top),
    ]


def claim_equations() -> list[Claim]:
    """Return the claims in section II-B: the model's equations."""
    kapton, ptfe = load_brakes()
    right = float(enclosure_force(0.02, FULL, kapton))
    printed_force = right / 0.02**0.5 * 0.02
    # with lengths in mm, E and P per mm^2 and A in mm^2 increase the argument of the root 1000-fold
    in_mm = right / 0.02**0.5 * 1e3**-0.5 * 20.0
    sheets, section = kapton.sheets, kapton.sheets.width * kapton.sheets.thickness
    springs = [(6, sheets.free_left), (11, sheets.overlap), (5, sheets.free_right)]
    series = 1 / sum(length / (kapton.film.modulus * n * section) for n, length in springs)
    stuck = [float(stiffness_before_slip(b)) for b in (kapton, ptfe)]
    sliding = [float(stiffness_sliding(0.0, b)) / 1e3 for b in (kapton, ptfe)]
    stretch = float(enclosure_stretch(TESTED, FULL, kapton))
    force = float(brake_force(0.02, FULL, kapton))
    parts = float(sheet_friction(0.02, FULL, kapton)) + right
    forces = [float(law(TESTED, FULL, kapton)) for law in (enclosure_force, brake_force)]
    is_equal = abs(series - stuck[0]) < 1e-9 * stuck[0]
    wrong: dict[str, Any] = {"right": right, "printed": printed_force, "in_mm": in_mm}
    return [
        claim("springs", holds=is_equal, kapton=stuck[0] / 1e3, ptfe=stuck[1] / 1e3),
        claim("sum", holds=abs(force - parts) < 1e-9 * parts, force=force),
        claim("enclosure", holds=abs(in_mm - printed_force) < 1e-6, **wrong),
        claim(
            "stretch", holds=stretch < 1.5, stretch=stretch, enclosure=forces[0], force=forces[1]
        ),
        claim("eq6-kapton", sliding[0]),
        claim("eq6-ptfe", sliding[1]),
    ]


def claim_materials() -> list[Claim]:
    """Return the claims in section III-A, Fig. 4."""
    films = ("kapton", "polyester", "ptfe", "ptfe-fiberglass")
    peaks = {name: _compute_peak(load(f"choi2018-{name}").brake) for name in films}
    bounds = [float(peak_vacuum(b)) / 1e3 for b in load_brakes()]
    slope = _slope_at(20e-3, 31e3, load_brakes()[0])
    words = ", ".join(f"{name} {force:.0f} N" for name, force in peaks.items())
    times = peaks["kapton"] / peaks["ptfe"]
    return [
        claim("order", words),
        claim("kapton-over-ptfe", holds=times > 1, times=times),
        claim("slopes", holds=slope > 0, kapton=bounds[0], ptfe=bounds[1], falls=-slope / 1e3),
    ]


def _slope_at(slip: float, vacuum: float, brake: Brake) -> float:
    """Return the slope of the force versus slip [N/m] at a slip [m] and vacuum [Pa]."""
    face = enclosure_law(vacuum, brake).point_at(slip**0.5)
    return float(face.force_slope / face.slip_slope - friction_per_contact(vacuum, brake))


def claim_fluids() -> list[Claim]:
    """Return the claims in section III-B: air and water."""
    file, line = load("choi2018-kapton"), load_line("choi2018").line
    slow, fast = (
        float(tensile(file, simple_pull(FULL, v, TESTED)).force.max()) for v in (1e-3, 25e-3)
    )
    air, water = (float(rise_time(FULL, line, w) or "nan") for w in (False, True))
    return [
        claim("rise-air", air),
        claim("rise-water", water),
        claim("water-faster", 3.9 / 1.5),
        claim("speed", holds=slow == fast, slow=slow),
        claim("wet-peak"),
    ]


def claim_stiffnesses() -> list[Claim]:
    """Return the claims in section III-D: measured stiffness in the text and in the caption."""
    kapton, ptfe = load_brakes()
    out = []
    for name in CALIBRATED:
        text, caption = (k / 1e3 for k in STIFFNESSES[name])
        top = peak(FULL, TESTED, load(name).brake)
        eq9 = float(top.force / top.elongation) / 1e3
        words: dict[str, Any] = {"film": NAMES[name], "text": text, "caption": caption, "eq9": eq9}
        out.append(claim("caption", caption, instead={"paper": text}, **words))
    out.append(_claim_enclosure_share())
    mounts = [float(mount_stiffness(b)) / 1e3 for b in (kapton, ptfe)]
    is_equal = abs(mounts[0] / mounts[1] - 1) < 0.1
    out.append(claim("mounts", holds=is_equal, kapton=mounts[0], ptfe=mounts[1]))
    static, greatest_force = float(holding_force(FULL, kapton)), _compute_peak(kapton)
    return [
        *out,
        claim("static", holds=static / greatest_force < 1.05, static=static, peak=greatest_force),
    ]


def _claim_enclosure_share() -> Claim:
    """Return the claim on the enclosure's share of the peak force, by slip and by elongation."""
    shares: dict[str, Any] = {}
    for name in CALIBRATED:
        brake = load(name).brake
        top, key = peak(FULL, TESTED, brake), NAMES[name].lower()
        for ending, position in (("", top.slip), ("_eq8", top.elongation)):
            shares[key + ending] = float(enclosure_force(position, FULL, brake) / top.force)
    return claim("minimal", holds=max(shares.values()) < 0.05, **shares)


def claim_damping() -> list[Claim]:
    """Return the claims in section III-E: energy and collisions of 1 kg on the implied rope."""
    from scipy.integrate import quad

    kapton, _ = load_brakes()
    rope = kapton.rope.stiffness if kapton.rope is not None else np.inf
    spring = series_spring(kapton, rope)
    work = float(slip_work(TESTED, FULL, kapton))
    numeric = quad(lambda x: float(brake_force(x, FULL, kapton)), 0, TESTED)[0]
    bare_peak_g = simulate_damped_rope(1.0, 3.7, rope, 0.0, G)[0] / G
    full_peak = float(stop(1.0, 2.5, FULL, spring, G, kapton).peak_force)
    fast_stop = stop(1.0, 3.7, FULL, spring, G, kapton)
    tuned_vacuum_ = float(tuned_vacuum(1.0, 2.5, TESTED, spring, G, kapton))
    tuned_peak = float(stop(1.0, 2.5, tuned_vacuum_, spring, G, kapton).peak_force)
    floor = 1 + 2.5**2 / (2 * G * (TESTED + tuned_peak / spring))
    eq10 = float(vacuum_eq10(1.0, 2.5, TESTED, kapton))
    runs = float(stop(1.0, 2.5, eq10, spring, G, kapton).slip)
    stopped = int(fast_stop.outcome) == STOPPED
    return [
        claim("energy", holds=abs(work - numeric) < 1e-6 * numeric, work=work),
        claim("bare", float(bare_peak_g), rope=show(rope, "N/m")),
        claim("full", full_peak / G, peak=full_peak),
        claim("stopped", holds=stopped, speed=float(fast_stop.end_speed)),
        claim("tuned", tuned_peak / G, tuned=tuned_vacuum_ / 1e3, floor=floor),
        claim("eq10", runs * 1e3, vacuum=eq10 / 1e3),
        claim("unstated"),
    ]


def claim_force_density() -> list[Claim]:
    """Return the claims in section III-F, Fig. 12."""
    kapton, _ = load_brakes()
    thicker_stack = evolve(kapton, sheets=evolve(kapton.sheets, count=kapton.sheets.count + 1))
    top = _compute_peak(kapton)
    best = max(published_devices().devices, key=lambda device: device.density)
    return [
        claim("sheet-force", _compute_peak(thicker_stack) - top),
        claim(
            "sheet-mass", sheet_mass(kapton) * 1e3, whole=(mass(thicker_stack) - mass(kapton)) * 1e3
        ),
        claim("density", top / 20.0),
        claim("largest", top / 20.0, name=best.name, density=best.density / 1e3),
    ]
