"""Two arms whose muscles let go, one with its brake evacuated: computed in MuJoCo, drawn as an SVG.

pip install ".[mujoco]" gymnasium
python examples/elbow_animation.py elbow-animation.svg
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from elbow import DRUM, FULL, REACH, STEP, model

LENGTH, FRAME, RELAXED = 6.0, 0.05, 0.6
"""Of the film, of a picture, and when the muscles let go [s]."""
DOWN, HOLD, OPEN = 2.0, 3.6, 4.8
"""The brake lets the hand down, holds it again, is vented [s]."""
SLOW = np.radians(22.0)
"""Speed at which it lets the hand down [rad/s]."""
LOAD = 0.6
SCALE = 420.0
"""Pixels a metre."""
BLUE, PALE, GREY, INK, SKIN = "#0072B2", "#dbe9f2", "#66717d", "#1c2530", "#e9d9cb"


@dataclass(frozen=True)
class Film:
    """What is shown, at every picture."""

    angle: np.ndarray
    """Of the forearm below the horizontal [degrees]."""
    vacuum: np.ndarray
    """In the brake [kPa]."""


def asked(time: float, speed: float, before: float) -> float:
    """The vacuum asked for [Pa]: hold, let down slowly, hold, let go."""
    if time < DOWN or HOLD <= time < OPEN:
        return FULL
    if time >= OPEN:
        return 0.0
    return float(np.clip(before + 400.0 * (speed - SLOW), 0.0, FULL))


def run(braked: bool) -> Film:
    """The arm over the whole film; until they let go the muscles hold it still."""
    arm = model()
    hand = arm.body("load").id
    arm.body_mass[hand] *= LOAD
    arm.body_inertia[hand] *= LOAD
    data = mujoco.MjData(arm)
    mujoco.mj_setConst(arm, data)
    # it begins at the vacuum that it holds with
    data.act[0] = FULL if braked else 0.0
    angles, vacuums, wanted = [], [], data.act[0]
    for index in range(round(LENGTH / STEP)):
        if index % round(FRAME / STEP) == 0:
            angles.append(np.degrees(data.qpos[0]))
            vacuums.append(data.act[0] / 1e3)
        wanted = asked(data.time, data.qvel[0], wanted) if braked else 0.0
        data.ctrl[0] = wanted
        muscle = data.time < RELAXED
        data.qfrc_applied[0] = -_torque() if muscle else 0.0
        mujoco.mj_step(arm, data)
        if muscle:
            data.qpos[0] = data.qvel[0] = 0.0
    return Film(np.array(angles), np.array(vacuums))


def _torque() -> float:
    return 9.80665 * REACH * (LOAD + 0.5 * 1.2)


def values(numbers: Sequence[float], form: str = "{:.1f}") -> str:
    """Numbers as SMIL takes them."""
    return ";".join(form.format(number) for number in numbers)


def moving(kind: str, texts: str, extra: str = "") -> str:
    """An element that changes its parent over the film, again and again."""
    return f'<{kind} {extra} values="{texts}" dur="{LENGTH}s" repeatCount="indefinite"/>'


def colour(share: float) -> str:
    """From pale to blue as the vacuum rises."""
    ends = [[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in (PALE, BLUE)]
    mixed = [round(a + share * (b - a)) for a, b in zip(*ends, strict=True)]
    return "#" + "".join(f"{part:02x}" for part in mixed)


def person(film: Film, words: str) -> str:
    """Head, trunk, an upper arm that is held out, and the forearm that moves."""
    elbow, wrist, tip = 0.30 * SCALE, 0.12 * SCALE, REACH * SCALE
    fills = ";".join(colour(v) for v in film.vacuum / (FULL / 1e3))
    brake = f'fill="{colour(film.vacuum[0] / (FULL / 1e3))}" stroke="{INK}" stroke-width="0.8"'
    paint = moving("animate", fills, 'attributeName="fill"')
    drum = DRUM * SCALE
    return f"""
  <text x="0" y="-104" font-size="14" font-weight="bold" fill="{INK}">{words}</text>
  <circle cx="18" cy="-62" r="24" fill="{SKIN}"/>
  <path d="M-6 -28 q24 -14 48 0 l4 150 h-56 z" fill="#c7d3dc"/>
  <rect x="24" y="-17" width="{elbow - 24:.0f}" height="34" rx="17" fill="#c7d3dc"/>
  <g transform="translate({elbow:.0f} 0)">
    <g>{moving("animateTransform", values(film.angle), 'attributeName="transform" type="rotate"')}
      <rect x="-13" y="-13" width="{tip + 14:.0f}" height="26" rx="13" fill="{SKIN}"/>
      <rect x="{tip - 6:.0f}" y="-24" width="18" height="48" rx="5" fill="{GREY}"/>
      <path d="M0 {-drum - 4:.1f} h{wrist + 26:.0f} v8 H0 z" {brake}>{paint}</path>
    </g>
    <circle r="{drum + 1:.1f}" fill="#f7f9fa" stroke="{INK}" stroke-width="0.8"/>
    <circle r="{drum + 4:.1f}" {brake} fill-opacity="0.9">{paint}</circle>
    <circle r="{drum - 4:.1f}" fill="#f7f9fa" stroke="{INK}" stroke-width="0.8"/>
    <path d="M0 {-drum - 4:.1f} h-78 v8 h78 z" {brake}>{paint}</path>
  </g>"""


def chart(films: dict[str, tuple[Film, str]], width: float, height: float) -> str:
    """Angle over time of both arms, the vacuum as a strip, and a line that shows the time."""
    times = np.arange(0.0, LENGTH, FRAME)
    across, down = times / LENGTH * width, height / 80.0
    parts = []
    held = films["evacuated"][0]
    for x, share in zip(across, held.vacuum / (FULL / 1e3), strict=True):
        wide = FRAME / LENGTH * width + 0.4
        parts.append(f'<rect x="{x:.1f}" y="-16" width="{wide:.1f}" height="9" '
                     f'fill="{colour(share)}"/>')  # fmt: skip
    for angle in (0, 40, 80):
        y = angle * down
        parts.append(f'<line x2="{width}" y1="{y}" y2="{y}" stroke="#e7ebee"/>'
                     f'<text x="-8" y="{y + 4}" text-anchor="end">{angle}°</text>')  # fmt: skip
    for film, line in films.values():
        path = " ".join(f"{x:.1f},{a * down:.1f}" for x, a in zip(across, film.angle, strict=True))
        parts.append(f'<polyline points="{path}" fill="none" stroke="{line}" stroke-width="2.4"/>')
    for second in range(int(LENGTH) + 1):
        x = second / LENGTH * width
        parts.append(f'<text x="{x:.0f}" y="{height + 18}" text-anchor="middle">{second}</text>')
    for time, word in ((RELAXED, "muscles off"), (DOWN, "let down"), (HOLD, "hold"),
                       (OPEN, "vented")):  # fmt: skip
        x = time / LENGTH * width
        parts.append(f'<text x="{x:.0f}" y="-22">{word}</text>'
                     f'<path d="M{x:.0f} -19 v14" stroke="{INK}"/>')  # fmt: skip
    cursor = moving("animate", f"0;{width}", 'attributeName="x1"')
    other = moving("animate", f"0;{width}", 'attributeName="x2"')
    parts.append(f'<line y1="-16" y2="{height}" stroke="{INK}" stroke-width="1.2">'
                 f"{cursor}{other}</line>")  # fmt: skip
    return "\n  ".join(parts)


def picture() -> str:
    """The whole SVG."""
    vented, braked = run(False), run(True)
    curves = chart({"vented": (vented, GREY), "evacuated": (braked, BLUE)}, 590, 110)
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 720 520" width="720"
  font-family="DejaVu Sans, Verdana, sans-serif" font-size="12" fill="{GREY}">
<title>Two arms whose muscles let go: without vacuum the forearm falls, with it it stays, is let
down slowly, and stays again</title>
<rect width="720" height="520" fill="white"/>
<g transform="translate(60 130)">{person(vented, "Brake vented")}</g>
<g transform="translate(405 130)">{person(braked, "Brake evacuated")}</g>
<g transform="translate(80 372)">
  {curves}
  <text x="295" y="145" text-anchor="middle">time [s]</text>
  <text x="590" y="145" text-anchor="end">computed</text>
  <text x="-62" y="-6" font-size="11">vacuum</text>
  <text transform="translate(-50 55) rotate(-90)" text-anchor="middle">forearm below</text>
  <text transform="translate(-36 55) rotate(-90)" text-anchor="middle">the horizontal [°]</text>
</g>
</svg>
"""


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(picture(), encoding="utf-8")
