"""Draw the pictures of README and docs in this folder: python docs/images/make.py [FILE...].

FILE is the name of a picture, such as rise.svg; by default all of them are drawn.
"""

from __future__ import annotations

import contextlib
import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import jax
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from layerjam.bench.figures import line_pictures
from layerjam.bench.figures.wiring_diagram import draw_wiring
from layerjam.bench.rig.circuit import load_circuit
from layerjam.brake.device.load import load
from layerjam.brake.figures.fluid_figures import draw_fig5
from layerjam.brake.mechanics.pull import brake_force, force_at_elongation, vacuum_for_force
from layerjam.core.drawing import style

HERE = Path(__file__).parent
VACUUMS = (94.5e3, 65.5e3, 31.0e3, 0.0)


def kapton() -> Figure:
    """The paper's Kapton brake pulled at the paper's four vacuums, and the vacuum for 100 N."""
    brake = load("choi2018-kapton").brake
    u = np.union1d(np.linspace(0, 4e-3, 400), np.linspace(0, 40e-3, 300))
    with style.apply_style():
        figure, (left, right) = style.make_axes(columns=2, width=8.6, height=3.6)
        ends = []
        for vacuum, color in zip(VACUUMS, style.VACUUMS, strict=True):
            force = np.asarray(force_at_elongation(u, vacuum, brake))
            left.plot(u * 1e3, force, color=color)
            ends.append((float(force[-1]), f"{vacuum / 1e3:.1f} kPa", color))
        left.set(xlabel="elongation [mm]", ylabel="force [N]", xlim=(0, 40), ylim=(0, 200))
        style.add_end_labels(left, 40, ends)
        style.add_title(
            left, "A pull at four vacuums", "computed; the paper's brake, Kapton sheets"
        )

        pressure = np.linspace(0, brake.site.atmosphere, 300)
        force = np.asarray(brake_force(20e-3, pressure, brake))
        need = float(vacuum_for_force(100.0, 20e-3, brake))
        right.plot(pressure / 1e3, force, color=style.BLUE)
        x, y = [0, need / 1e3, need / 1e3], [100, 100, 0]
        right.plot(x, y, color=style.GREY, lw=1, ls=(0, (4, 3)))
        right.plot(need / 1e3, 100, "o", color=style.RED, ms=6)
        style.add_label(
            right, need / 1e3 - 2, 108, f"100 N: {need / 1e3:.1f} kPa", style.RED, ha="right",
            weight="bold",
        )  # fmt: skip
        right.set(xlabel="vacuum [kPa]", xlim=(0, 102), ylim=(0, 200))
        style.add_title(right, "Which vacuum for 100 N?", "computed; after 20 mm of slip")
    return figure


SHAPES = "osD^vP"


def engines() -> Figure:
    """The same drop in six engines, as benchmarks/engines.py measured it: slip, and its error."""
    record = json.loads((HERE / "engines.json").read_text(encoding="utf-8"))
    with style.apply_style():
        figure, (left, right) = style.make_axes(
            columns=2, width=9.6, height=3.9, gridspec_kw={"width_ratios": (1.1, 1)}
        )
        known = list(zip(record["engines"].items(), style.CYCLE, SHAPES, strict=True))
        errors = []
        for row, ((name, found), color, shape) in enumerate(known):
            slip = np.array(found["slip"])
            times = record["step"] * (np.arange(len(slip)) + found["ahead"])
            seen = slice(row, None, len(known))  # one engine after the other along the curve
            left.plot(times[seen] * 1e3, slip[seen] * 1e3, shape, color=color, ms=5)
            error = (slip[-1] - record["exact"]) * 1e6
            right.plot([0, error], [row, row], color=color, lw=1.2)
            right.plot(error, row, shape, color=color, ms=7)
            errors.append((error, row, f"{name} {error:+.1f}".replace("-", "−"), color))
        exact = record["exact"] * 1e3
        style.mark_y(left, exact, f"closed form {exact:.3f} mm", style.INK, share=0.02)
        style.label_axes(
            left, "1 kg falls into the brake at 2.5 m/s", "Kapton, 94.5 kPa, rope 16.8 kN/m",
            xlabel="time [ms]", ylabel="slip [mm]", xlim=(0, 30), ylim=(0, 20),
        )  # fmt: skip
        style.label_axes(
            right, "No engine errs by more than 0.1 mm",
            f"simulated in steps of {record['step'] * 1e3:g} ms on {record['day']}",
            xlabel="error of the slip [µm]", xlim=(-20, 130), ylim=(5.6, -0.6), yticks=(),
        )  # fmt: skip
        right.axvline(0, color=style.GREY, lw=1)
        for error, row, text, color in errors:
            style.add_label(right, error + 5, row, text, color, ha="left", weight="bold")
    return figure


BOXES: dict[str, tuple[float, float, str, str]] = {
    "brake file": (0, 2, "brake file", "TOML, units, sources"),
    "test files": (0, 1, "test files", "CSV, .TRA, workbooks"),
    "device": (1, 2, "brake/device", "Brake: SI floats"),
    "identify": (1, 1, "laboratory", "read, fit, verdict"),
    "laws": (2, 2, "brake/mechanics, fluid", "laws: array functions"),
    "simulate": (2, 1, "brake/simulate", "pulls, stops, records"),
    "commands": (3, 2, "commands/", "one declared function"),
    "faces": (4, 2, "cli, Python, workbench", "table, JSON, page"),
    "interop": (2, 0, "interop", "C kernel, FMI, MuJoCo"),
    "build": (3, 1, "workshop", "design, drawings, parts"),
    "bench": (1, 0, "bench", "controller, firmware"),
    "board": (0, 0, "board, pump, valve", "virtual or emulated"),
    "parts": (4, 1, "cut, printed, cast", "nobody has built one"),
}
"""{box of the overview: (column, row, folder, content)}."""
ARROWS = (
    ("brake file", "device"), ("test files", "identify"), ("identify", "device"),
    ("device", "laws"), ("laws", "simulate"), ("laws", "commands"), ("simulate", "commands"),
    ("commands", "faces"), ("simulate", "interop"), ("commands", "build"), ("build", "parts"),
    ("bench", "board"), ("bench", "identify"),
)  # fmt: skip
UNBUILT = ("board", "parts")
MAIN = ("brake file", "test files", "device", "identify", "laws", "simulate", "commands", "faces")


def overview() -> Figure:
    """The way from a brake file and test files to a result, with its side branches."""
    wide, high, step_x, step_y = 1.72, 0.62, 1.96, 1.0
    with style.apply_style():
        figure, (axes,) = style.make_axes(width=9.6, height=3.3)
        axes.set(xlim=(-0.05, 4 * step_x + wide + 0.05), ylim=(-0.1, 2 * step_y + high + 0.1))
        style.hide_axes(axes)
        for name, (column, line, folder, content) in BOXES.items():
            x, y, ink = column * step_x, line * step_y, style.BLUE if name in MAIN else style.GREY
            axes.add_patch(
                FancyBboxPatch(
                    (x, y), wide, high, boxstyle="round,pad=0,rounding_size=0.08", fill=False,
                    edgecolor=style.RED if name in UNBUILT else ink, lw=1.4,
                    ls="--" if name in UNBUILT else "-",
                )
            )  # fmt: skip
            middle = x + wide / 2
            props = {"ha": "center", "va": "center"}
            style.add_label(axes, middle, y + 0.41, folder, style.INK, weight="bold", **props)
            style.add_label(axes, middle, y + 0.18, content, style.GREY, **props)
        for start, end in ARROWS:
            (a, b, *_), (c, d, *_) = BOXES[start], BOXES[end]
            across, up = np.sign(c - a), np.sign(d - b)
            source = (a * step_x + wide * (1 + across) / 2, b * step_y + high / 2)
            sink = (c * step_x + wide * (1 - across) / 2, d * step_y + high / 2)
            if not across:
                source = (source[0], b * step_y + high * (1 + up) / 2)
                sink = (sink[0], d * step_y + high * (1 - up) / 2)
            axes.annotate("", sink, source, arrowprops={"arrowstyle": "->", "color": style.INK})
    return figure


def draw_gallery(folder: Path) -> None:
    """Draw the pictures of docs/gallery.md by the code of that page."""
    page = (HERE.parent / "gallery.md").read_text(encoding="utf-8")
    for name in list_gallery():
        (folder / name).unlink(missing_ok=True)
    with contextlib.chdir(folder):
        exec("\n".join(re.findall(r"(?<!-->\n)```python\n(.*?)```", page, re.DOTALL)), {})


def list_gallery() -> list[str]:
    """Return the names of the pictures that the code of docs/gallery.md draws."""
    page = (HERE.parent / "gallery.md").read_text(encoding="utf-8")
    return re.findall(r'^result\.plot\("([\w-]+\.svg)"\)', page, re.MULTILINE)


FIGURES: dict[str, Callable[[], Figure]] = {
    "kapton.svg": kapton,
    "engines.svg": engines,
    "overview.svg": overview,
    "rise.svg": draw_fig5,
    "regulators.svg": line_pictures.draw_regulators,
    "forces.svg": line_pictures.draw_forces,
    "warned.svg": line_pictures.draw_warned_plan,
    "coupling.svg": line_pictures.draw_coupling,
}
COMMANDS: dict[str, tuple[str, ...]] = {
    "stop.svg": ("docs/images/stop_animation.py",),
    "bending.svg": ("-m", "benchmarks.bending", "--figure"),
    "held.svg": ("-m", "benchmarks.creep", "--figure"),
    "elbow.svg": ("examples/elbow_train.py", "--seconds", "60", "--figure"),
    "elbow-animation.svg": ("examples/elbow_animation.py",),
    "workbench.png": ("docs/images/workbench.py",),
}
"""{picture: program that draws it, before the path of the picture}."""
SIMULATORS = HERE.parents[1] / ".venv" / "interop" / "bin" / "python"
"""Python with MuJoCo and others, as `make interop` installs it."""
SIMULATED = ("held.svg", "elbow.svg", "elbow-animation.svg")
WIRING = "wiring-pico.svg"
NAMES = (*FIGURES, *COMMANDS, WIRING, *list_gallery())


def draw(name: str, folder: Path) -> Path:
    """Draw one picture into a folder, those of the gallery all together; return its path."""
    jax.config.update("jax_enable_x64", True)
    path = folder / name
    if name in FIGURES:
        return style.save(FIGURES[name](), path, overwrite=True)
    if name in COMMANDS:
        python = str(SIMULATORS) if name in SIMULATED else sys.executable
        words = [python, *COMMANDS[name], str(path.resolve())]
        subprocess.run(words, cwd=HERE.parents[1], check=True)
    elif name == WIRING:
        path.write_text(draw_wiring(load_circuit("pico")), encoding="utf-8")
    else:
        draw_gallery(folder)
    return path


def main(names: list[str]) -> None:
    """Draw pictures by name, and report those whose simulator is not installed."""
    for name in names or (*FIGURES, *COMMANDS, WIRING, list_gallery()[0]):
        if name in SIMULATED and not SIMULATORS.exists():
            print(f"{name} is not drawn: it needs MuJoCo, which `make interop` installs")
        else:
            print(draw(name, HERE))


if __name__ == "__main__":
    main(sys.argv[1:])
