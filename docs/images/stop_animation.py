"""Draw the moving picture of README and docs: python docs/images/stop_animation.py [FILE].

`compute` simulates the stop; `draw` writes it as SVG. CSS moves it, and only for readers who have
not asked for less motion: the picture at rest is the end of the stop.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import layerjam as lj
from layerjam.brake.device.load import load
from layerjam.core.units import show

BRAKE = "choi2018-kapton"
MASS, SPEED, ROPE, VACUUM = 1.0, 2.5, 16.8e3, 70.05e3
"""Mass [kg], its speed when the rope becomes taut [m/s], rope [N/m], and the safe vacuum [Pa]."""
FALL = 8e-3
"""Time shown before the rope is taut [s]."""
SLOWER, CYCLE, PLAYS = 100, 8.0, 3
"""Slow-motion factor, length of one play [s], and number of plays."""
SAMPLES = 48

WIDTH, HEIGHT = 680, 440
SCALE = 3.4e3
"""Pixels per metre, for the brake and for the fall."""
WALL, MIDDLE = 46.0, 128.0
"""Left end and middle line of the brake [px]."""
PITCH, SHEET = 6.0, 5.2
"""Distance and thickness of the drawn sheets [px]; real sheets are thinner."""
PULLEY, RADIUS = 545.0, 17.0
SAG, FLAT = 44.0, 0.01
"""Sag of the slack rope as drawn [px], and its scale when the rope is taut: 0 would hide it."""
CHART_X, CHART_Y, CHART_WIDTH, CHART_HEIGHT = 66.0, 228.0, 424.0, 166.0
LAST, HIGHEST = 35e-3, 150.0
"""Ends of the axes: time [s] and force [N]."""

STYLE = """
svg { --card: #ffffff; --edge: #d0d7de; --ink: #1c2530; --grey: #59636e; --line: #e3e8ec;
  --held: #0072b2; --moving: #e69f00; --bag: #eef1f4; --cap: #8a949e; --peak: #c24f00; }
@media (prefers-color-scheme: dark) {
  svg { --card: #15191f; --edge: #3d444d; --ink: #eef2f5; --grey: #a3adb7; --line: #2c333b;
    --held: #56b4e9; --moving: #f0b429; --bag: #232a32; --cap: #77828d; --peak: #ff9257; }
}
text { fill: var(--ink); font: 14px "DejaVu Sans", Verdana, sans-serif; }
.small { fill: var(--grey); font-size: 13px; }
.title { font-size: 18px; font-weight: bold; }
.number { font-weight: bold; }
.held { fill: var(--held); }
.moving { fill: var(--moving); }
.thin { fill: none; stroke: var(--ink); stroke-width: 1.4; vector-effect: non-scaling-stroke; }
.grid { stroke: var(--line); stroke-width: 1; }
.rope { fill: none; stroke: var(--ink); stroke-width: 2; vector-effect: non-scaling-stroke; }
.curve { fill: none; stroke: var(--ink); stroke-width: 3; stroke-dasharray: 1; }
"""


@dataclass(frozen=True)
class Stop:
    """Course of a fall and a stop, shape (N,) each; time 0 is when the rope becomes taut."""

    time: np.ndarray
    """[s]"""
    displacement: np.ndarray
    """Displacement of the mass; negative while the rope is slack [m]."""
    slip: np.ndarray
    """Slip of the sheets [m]."""
    force: np.ndarray
    """Force of the brake [N]."""


def compute() -> Stop:
    """Return the fall and the stop, at the times of the drawn frames."""
    result = lj.drop(BRAKE, mass=MASS, speed=SPEED, rope_stiffness=ROPE, vacuum=VACUUM)
    record = result.require().record
    peak_time = record.time[np.argmax(record.force)]
    even = np.linspace(0.0, record.time[-1], SAMPLES + 1)
    after = np.union1d(even, [peak_time])
    before = np.linspace(-FALL, 0.0, 9)[:-1]
    fall = SPEED * before + record.gravity * before**2 / 2
    columns = (record.displacement, record.slip, record.force)
    moved, slip, force = (np.interp(after, record.time, column) for column in columns)
    rest = np.zeros(len(before))
    return Stop(
        np.append(before, after),
        np.append(fall, moved),
        np.append(rest, slip),
        np.append(rest, force),
    )


def animate(name: str, stop: Stop, states: list[str]) -> str:
    """Return keyframes with one state of a property for each time of the stop."""
    shares = (stop.time + FALL) * SLOWER / CYCLE * 100
    frames = [f"{share:.2f}% {{{state}}}" for share, state in zip(shares, states, strict=True)]
    return f"@keyframes {name} {{ {' '.join(frames)} 100% {{{states[-1]}}} }}"


def appear(name: str, time: float) -> str:
    """Return keyframes of a label that appears at a time."""
    share = (time + FALL) * SLOWER / CYCLE * 100
    steps = f"0% {{opacity:0}} {share:.2f}% {{opacity:0}} {share + 3:.2f}% {{opacity:1}}"
    return f"@keyframes {name} {{ {steps} 100% {{opacity:1}} }}"


def motion(stop: Stop) -> str:
    """Return the CSS that moves the picture."""
    slip, fall = stop.slip * SCALE, stop.displacement * SCALE
    bag, span = bag_length(), PULLEY - brake_end()
    widths = (bag + slip) / (bag + slip[-1])
    # a flat arc of a span and a sag s is longer than the span by 8 s^2 / (3 span)
    sag = np.sqrt(3 * span * np.clip(-fall, 0, None) / 8) / SAG
    x, y = place(stop)
    arc = np.append(0.0, np.cumsum(np.hypot(np.diff(x), np.diff(y))))
    drawn = np.where(stop.time > 0, arc - arc[stop.time <= 0][-1], 0.0)
    peak = float(stop.time[np.argmax(stop.force)])
    rules = [
        animate("slide", stop, [f"transform:translate({s:.1f}px,0)" for s in slip]),
        animate("fall", stop, [f"transform:translate(0,{f:.1f}px)" for f in fall]),
        animate("stretch", stop, [f"transform:scaleX({w:.4f})" for w in widths]),
        animate("measure", stop, [f"transform:scaleX({s:.4f})" for s in slip / slip[-1]]),
        animate("sag", stop, [f"transform:scaleY({max(s, FLAT):.3f})" for s in sag]),
        animate("turn", stop, [f"transform:rotate({max(f, 0) / RADIUS:.3f}rad)" for f in fall]),
        animate(
            "trace", stop, [f"stroke-dashoffset:{1 - d:.4f}" for d in drawn / drawn[-1]]
        ),
        animate(
            "follow", stop,
            [f"transform:translate({a:.1f}px,{b:.1f}px)" for a, b in zip(x, y, strict=True)],
        ),
        appear("late", float(stop.time[-1])),
        appear("early", peak),
    ]  # fmt: skip
    names = ("slide", "fall", "stretch", "measure", "sag", "turn", "trace", "follow", "late",
             "early")  # fmt: skip
    uses = [f".{n} {{ animation: {n} {CYCLE:g}s linear {PLAYS} both }}" for n in names]
    return "\n".join(
        ["@media (prefers-reduced-motion: no-preference) {", *uses, "}", *rules,
         "@media (prefers-reduced-motion: reduce) { * { animation: none !important } }"]
    )  # fmt: skip


def bag_length() -> float:
    """Length of the enclosure at rest, from cap to cap [px]."""
    sheets = load(BRAKE).brake.sheets
    return float(sheets.free_left + sheets.overlap + sheets.free_right) * SCALE


def cap_length() -> float:
    """Length of a cap [px]."""
    return float(load(BRAKE).brake.mount.clamped_length) * SCALE


def brake_end() -> float:
    """Right end of the brake at rest [px]."""
    return WALL + 2 * cap_length() + bag_length()


def place(stop: Stop) -> tuple[np.ndarray, np.ndarray]:
    """Return the curve of force versus time in pixels of the chart."""
    x = np.clip(stop.time, 0, None) / LAST * CHART_WIDTH
    return x, CHART_HEIGHT * (1 - stop.force / HIGHEST)


def draw_sheets(is_held: bool) -> str:
    """Return the sheets of one cap, and the cap."""
    sheets = load(BRAKE).brake.sheets
    length, cap, half = sheets.length * SCALE, cap_length(), PITCH * (sheets.count - 1) / 2
    left = WALL if is_held else brake_end() - length
    rows = range(0 if is_held else 1, sheets.count, 2)
    parts = [
        f'<rect x="{left:.1f}" y="{MIDDLE - half + row * PITCH - SHEET / 2:.1f}" '
        f'width="{length:.1f}" height="{SHEET}"/>'
        for row in rows
    ]
    cap_left = WALL if is_held else brake_end() - cap
    parts.append(
        f'<rect x="{cap_left:.1f}" y="{MIDDLE - half - 8:.1f}" width="{cap:.1f}" '
        f'height="{2 * half + 16:.1f}" rx="3" fill="var(--cap)"/>'
    )
    return "\n  ".join(parts)


def draw_brake(stop: Stop) -> str:
    """Return the brake, its wall, the rope, the pulley and the mass, at the end of the stop."""
    slip, fall = float(stop.slip[-1]) * SCALE, float(stop.displacement[-1]) * SCALE
    bag, cap, end = bag_length(), cap_length(), brake_end()
    count = load(BRAKE).brake.sheets.count
    half = PITCH * (count - 1) / 2 + 5
    top, bottom = MIDDLE - half, MIDDLE + half
    level = MIDDLE
    axle, drop = level + RADIUS, PULLEY + RADIUS
    hatch = "".join(f"M{WALL} {y:.0f} l-10 8 " for y in np.arange(top - 8, bottom + 4, 11))
    arrows = "".join(
        f"M{x:.0f} {top - 15:.0f} v11 m-4 -5 l4 5 l4 -5 "
        f"M{x:.0f} {bottom + 15:.0f} v-11 m-4 5 l4 -5 l4 5 "
        for x in (WALL + cap + bag * share for share in (0.42, 0.54, 0.66))
    )
    mark = bottom + 22
    return f"""<path class="thin" d="M{WALL} {top - 10:.0f} V{bottom + 10:.0f} {hatch}"/>
<g transform="translate({WALL + cap:.1f} 0)">
  <g class="stretch">
    <rect width="{bag + slip:.1f}" y="{top:.1f}" height="{2 * half:.1f}" fill="var(--bag)"/>
    <path class="thin" d="M0 {top:.1f} H{bag + slip:.1f} M0 {bottom:.1f} H{bag + slip:.1f}"/>
  </g>
</g>
<g class="held">
  {draw_sheets(True)}
</g>
<g clip-path="url(#left)">
<g class="slide moving" transform="translate({slip:.1f} 0)">
  <path class="thin" d="M{end:.1f} {mark - 7:.1f} v14"/>
  <g transform="translate({end:.1f} {level:.1f})">
    <g class="sag" transform="scale(1 {FLAT})">
      <path class="rope" d="M0 0 Q{(PULLEY - end) / 2:.1f} {2 * SAG} {PULLEY - end:.1f} 0"/>
    </g>
  </g>
  {draw_sheets(False)}
</g>
</g>
<path class="thin" d="{arrows}"/>
<text x="{WALL + cap + bag * 0.54:.0f}" y="{top - 22:.0f}" text-anchor="middle">vacuum \
{show(VACUUM, "Pa")}</text>
<path class="thin" d="M{end:.1f} {mark - 7:.1f} v14"/>
<g transform="translate({end:.1f} {mark:.1f})">
  <g class="measure"><path class="thin" d="M0 0 H{slip:.1f}"/></g>
</g>
<g class="late"><text class="number" x="{end - 8:.0f}" y="{mark + 5:.0f}" text-anchor="end">\
slip {show(float(stop.slip[-1]), "m", 3)}</text></g>
<text class="small" x="{WALL:.0f}" y="{mark + 5:.0f}">{count} sheets, held at two ends</text>
<g clip-path="url(#below)">
<g class="fall" transform="translate(0 {fall:.1f})">
  <path class="rope" d="M{drop} -100 V{level + 116:.0f}"/>
  <rect class="moving" x="{drop - 26}" y="{level + 114:.0f}" width="52" height="46" rx="4"/>
  <text x="{drop}" y="{level + 142:.0f}" text-anchor="middle" style="fill:#1c2530">\
{show(MASS, "kg")}</text>
</g>
</g>
<circle cx="{PULLEY}" cy="{axle}" r="{RADIUS - 1}" fill="var(--card)" stroke="var(--cap)" \
stroke-width="4"/>
<g transform="translate({PULLEY} {axle})">
  <g class="turn" transform="rotate({np.degrees(fall / RADIUS):.1f})">
    <path d="M-12 0 H12 M0 -12 V12" stroke="var(--cap)" stroke-width="3"/>
  </g>
</g>
<path class="rope" d="M{PULLEY} {level} A{RADIUS} {RADIUS} 0 0 1 {drop} {axle}"/>"""


def draw_chart(stop: Stop) -> str:
    """Return the axes and the curve of force versus time, with its labels."""
    x, y = place(stop)
    top = int(np.argmax(stop.force))
    points = " ".join(f"{a:.1f} {b:.1f}" for a, b, t in zip(x, y, stop.time, strict=True) if t >= 0)
    parts = []
    for force in range(0, int(HIGHEST) + 1, 50):
        line = CHART_HEIGHT * (1 - force / HIGHEST)
        parts.append(f'<path class="grid" d="M0 {line:.1f} H{CHART_WIDTH:.0f}"/>')
        parts.append(f'<text class="small" x="-8" y="{line + 5:.0f}" text-anchor="end">'
                     f"{force}</text>")  # fmt: skip
    for time in (0, 10, 20, 30):
        across = time * 1e-3 / LAST * CHART_WIDTH
        parts.append(f'<text class="small" x="{across:.0f}" y="{CHART_HEIGHT + 19:.0f}" '
                     f'text-anchor="middle">{time}</text>')  # fmt: skip
    middle = int(np.searchsorted(stop.time, 14e-3))
    peak = f"peak force {show(float(stop.force[top]), 'N')}"
    end = f"standstill after {show(float(stop.time[-1]), 's', 3)}"
    return f"""<g transform="translate({CHART_X:.0f} {CHART_Y:.0f})">
  {" ".join(parts)}
  <text class="small" x="-54" y="-12">force [N]</text>
  <text class="small" x="{CHART_WIDTH:.0f}" y="{CHART_HEIGHT + 36:.0f}" text-anchor="end">time \
since the rope is taut [ms]</text>
  <path class="curve trace" pathLength="1" d="M{points}"/>
  <g class="early">
    <circle cx="{x[top]:.1f}" cy="{y[top]:.1f}" r="5" fill="var(--peak)"/>
    <text class="number" x="{x[top] + 12:.0f}" y="{y[top] - 6:.0f}">{peak}: the sheets begin to \
slide</text>
  </g>
  <g class="late">
    <text x="{x[middle] + 8:.0f}" y="{y[middle] - 8:.0f}">less overlap, less force</text>
    <text class="number" x="{x[-1]:.0f}" y="{y[-1] + 26:.0f}" text-anchor="end">{end}</text>
  </g>
  <g class="follow" transform="translate({x[-1]:.1f} {y[-1]:.1f})">
    <circle r="5.5" fill="var(--ink)"/>
  </g>
</g>"""


def draw(stop: Stop) -> str:
    """Return the whole picture as SVG."""
    slip, peak = show(float(stop.slip[-1]), "m", 3), show(float(stop.force.max()), "N")
    weight = show(lj.show(BRAKE).mass, "kg")
    title = f"A brake of {weight} stops {show(MASS, 'kg')} from {show(SPEED, 'm/s')}"
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" \
width="{WIDTH}" height="{HEIGHT}" role="img">
<title>{title}: the sheets slip {slip}, and the force is at most {peak}. Computed.</title>
<style>{STYLE}{motion(stop)}
</style>
<clipPath id="left"><rect width="{PULLEY:.0f}" height="{HEIGHT}"/></clipPath>
<clipPath id="below"><rect y="{MIDDLE + RADIUS:.0f}" width="{WIDTH}" height="{HEIGHT}"/></clipPath>
<rect x="0.5" y="0.5" width="{WIDTH - 1}" height="{HEIGHT - 1}" rx="8" fill="var(--card)" \
stroke="var(--edge)"/>
<text class="title" x="24" y="34">{title}</text>
<text class="small" x="{WIDTH - 24}" y="34" text-anchor="end">computed; {SLOWER} times \
slower</text>
{draw_brake(stop)}
{draw_chart(stop)}
</svg>
"""


if __name__ == "__main__":
    named = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_name("stop.svg")
    Path(named).write_text(draw(compute()), encoding="utf-8")
    print(named)
