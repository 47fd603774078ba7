"""A need in a few numbers as a specification for `design`: what to vary is set up around it."""

from __future__ import annotations

import math
from dataclasses import replace

from layerjam.commands.answer import Quantity, si
from layerjam.design.design_file import plain_name
from layerjam.design.merit import MERITS
from layerjam.design.spec import NEED, examples
from layerjam.device.file import BrakeFile
from layerjam.errors import QuantityError
from layerjam.records.toml import parse_toml, quoted
from layerjam.units import QuantitySpec, exact_text, show

HOLD: dict[str, QuantitySpec] = {
    "force": replace(MERITS["holding_force"], open_lo=True, hi=1e7),
    "mass": QuantitySpec("kg", "greatest mass of all brakes", open_lo=True, hi=100),
    "width": QuantitySpec("m", "greatest width of the sheets of one brake", open_lo=True, hi=1),
    "length": QuantitySpec(
        "m", "greatest length at rest, clamped ends included", open_lo=True, hi=5
    ),
    "stress_margin": replace(MERITS["stress_margin"], hi=100),
}
"""What a brake that holds is asked for; a stress_margin of 0 asks for none."""
STOP: dict[str, QuantitySpec] = {**NEED, "stress_margin": HOLD["stress_margin"]}
"""What a brake that stops a mass is asked for."""
STEPS = 20
VACUUMS = (0.6, 0.8, 0.93)
"""Parts of the site's atmosphere; the paper's pump reached 94.5 kPa of 101.3."""


def hold(
    brake: BrakeFile, called: str, *, force: Quantity, mass: Quantity, width: Quantity,
    length: Quantity, stress_margin: float = 2.0,
) -> str:  # fmt: skip
    """The TOML text that asks for a light brake which holds `force`.

    `called` is how the text names the brake to begin from. Raises QuantityError for numbers out of
    bounds, a length that the brake's free and clamped parts alone take up, or a margin on stress
    where the film's strength is not known.
    """
    got = _read(HOLD, force=force, mass=mass, width=width, length=length,
                stress_margin=stress_margin)  # fmt: skip
    least = got["width"] / 4
    asked = exact_text(got["force"], "N")
    rules = [
        f"holding_force >= {asked}",
        f"mass <= {exact_text(got['mass'], 'kg')}",
        f"width <= {exact_text(got['width'], 'm')}",
        f"length <= {exact_text(got['length'], 'm')}",
    ]
    return _text(
        brake, called, f"hold-{asked}".replace(" ", ""), f"Hold {asked} with little mass.",
        [*rules, *_margin(brake, got["stress_margin"])],
        ["minimise mass", "maximise energy_capacity"], "",
        {
            "count": "{ from = 3, to = 61, step = 2 }",
            "width": _range(least, got["width"], "m"),
            "overlap": _overlaps(brake, got["length"]),
            "vacuum": _vacuums(brake),
            "parallel": "[1, 2, 3, 4]",
        },
    )  # fmt: skip


def stop(
    brake: BrakeFile, called: str, *, mass: Quantity, speed: Quantity, travel: Quantity,
    force: Quantity, stress_margin: float = 1.5,
) -> str:  # fmt: skip
    """The TOML text that asks for brakes which stop a mass within a travel and below a force.

    The mass moves level. Raises QuantityError as `hold` does.
    """
    got = _read(STOP, mass=mass, speed=speed, travel=travel, force=force,
                stress_margin=stress_margin)  # fmt: skip
    units = {name: spec.unit for name, spec in STOP.items()}
    asked = {n: exact_text(got[n], units[n]) for n in ("mass", "speed", "travel", "force")}
    table = "\n[stop]\n" + "".join(f"{n} = {quoted(v)}\n" for n, v in asked.items())
    sheets = brake.brake.sheets
    longest = max(2 * sheets.overlap, 1.2 * got["travel"] / 2)
    return _text(
        brake, called, "stop", f"Stop {asked['mass']} from {asked['speed']} within "
        f"{asked['travel']} of slip and below {asked['force']}.",
        _margin(brake, got["stress_margin"]), ["minimise mass", "minimise stop_peak"],
        f"{table}horizontal = true\n",
        {
            "count": "{ from = 5, to = 37, step = 4 }",
            "width": "[" + ", ".join(quoted(exact_text(sheets.width * f, "m")) for f in
                                     (1, 1.5, 2, 2.5, 3)) + "]",
            "overlap": _range(_gap(brake) + 0.1 * longest, longest, "m", 12),
            "vacuum": _vacuums(brake),
            "series": "[1, 2, 3, 4]",
            "parallel": "[1, 2, 3, 4, 6, 8]",
        },
    )  # fmt: skip


def _read(meanings: dict[str, QuantitySpec], **given: Quantity) -> dict[str, float]:
    return {name: si(value, meanings[name], name) for name, value in given.items()}


def _text(
    brake: BrakeFile, called: str, name: str, what: str, rules: list[str], goals: list[str],
    more: str, vary: dict[str, str],
) -> str:  # fmt: skip
    lines = [
        f"# {what} Written from a few numbers; every line may be changed.",
        f"name = {quoted(plain_name(name))}",
        f"brake = {quoted(called)}       # everything that is not varied, and the film's friction",
        "constraints = [", *(f"    {quoted(rule)}," for rule in rules), "]",
        f"objectives = [{', '.join(map(quoted, goals))}]",
        "weights = [2, 1]",
    ]  # fmt: skip
    lines += [*more.splitlines(), "", *_films(called), "", "[vary]"]
    lines += [f"{key} = {value}" for key, value in vary.items()]
    return "\n".join(lines) + "\n"


def _films(called: str) -> list[str]:
    """The thicknesses a film is sold in, where an example knows them."""
    known = parse_toml(examples()["stop"], "stop")
    film = known["film"][0]
    if film["use"] != called:
        return ["# add [[film]] with the thicknesses the film is sold in; now it is the brake's"]
    thick = ", ".join(map(quoted, film["thickness"]))
    return [
        "[[film]]", f"use = {quoted(called)}",
        "# DuPont, Bulletin GS-96-7, gauges 100, 200, 300 and 500",
        f"thickness = [{thick}]",
    ]  # fmt: skip


def _margin(brake: BrakeFile, margin: float) -> list[str]:
    if not margin:
        return []
    if brake.brake.film.strength is None:
        raise QuantityError(
            f"stress_margin: {margin:g} cannot be asked for, the strength of the film of "
            f"{brake.name} is not known; 0 asks for none"
        )
    return [f"stress_margin >= {margin:g}"]


def _gap(brake: BrakeFile) -> float:
    """Overlap that must remain, as on the given brake [m]."""
    return brake.brake.sheets.overlap - brake.brake.sheets.usable_travel


def _overlaps(brake: BrakeFile, length: float) -> str:
    """Overlaps that fit a length."""
    sheets = brake.brake.sheets
    taken = sheets.free_left + sheets.free_right + 2 * brake.brake.mount.clamped_length
    most = length - taken
    if most <= _gap(brake):
        raise QuantityError(
            f"length: {show(length, 'm')} leaves no room; free and clamped parts of {brake.name} "
            f"take {show(taken, 'm')}, and {show(_gap(brake), 'm')} of overlap must remain"
        )
    return _range(max(most / 4, (most + _gap(brake)) / 2 if most / 4 <= _gap(brake) else 0), most,
                  "m")  # fmt: skip


def _vacuums(brake: BrakeFile) -> str:
    full = brake.brake.site.atmosphere
    rounded = (math.floor(full * part / 500 + 1e-9) * 500.0 for part in VACUUMS)
    return f"[{', '.join(quoted(exact_text(p, 'Pa')) for p in rounded)}]"


def _range(low: float, high: float, unit: str, steps: int = STEPS) -> str:
    """From about `low` to `high` in round steps that end on `high`."""
    raw = (high - low) / steps
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(f * power for f in (1, 2, 5, 10) if f * power >= raw * (1 - 1e-9))
    first = high - math.floor((high - low) / step * (1 + 1e-9)) * step
    words = [quoted(exact_text(float(f"{v:.6g}"), unit)) for v in (first, high, step)]
    return f"{{ from = {words[0]}, to = {words[1]}, step = {words[2]} }}"


__all__ = ["HOLD", "STOP", "hold", "stop"]
