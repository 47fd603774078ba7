"""The same drop in six engines: runs the recipes of docs/simulators.md, for its table and picture.

    python -m benchmarks.engines

Needs all six engines: `.venv/interop/bin/python` after `make interop`. Writes
docs/images/engines.json, which holds the versions and the day, and the table in the page; then
`python docs/images/make.py engines.svg` draws the picture.
"""

from __future__ import annotations

import datetime
import importlib.metadata
import importlib.util
import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "simulators.md"
RECORD = ROOT / "docs" / "images" / "engines.json"
TABLE = re.compile(r"(?<=benchmarks/engines.py -->\n).*?(?=<!-- end of engines -->)", re.DOTALL)
ENGINES = {
    "MuJoCo": ("in_mujoco", 0.0, "mujoco"),
    "MJX": ("in_mjx", 0.0, "mujoco-mjx"),
    "MuJoCo Warp": ("in_warp", 0.0, "mujoco-warp"),
    "Newton": ("in_newton", 0.0, "newton"),
    "Drake": ("in_drake", 0.0, "drake"),
    "OpenSim": ("in_opensim", 0.5, "opensim"),
}
"""{engine: (function of the page, where in the step it asks for the force, package)}."""
FALL = {"mass": 1.0, "place": 0.0, "speed": 2.5, "steps": 80}


def recipes() -> dict[str, Any]:
    """What the page's Python blocks define; each block runs, with its own check."""
    path = ROOT / "tests" / "docs" / "examples.py"
    spec = importlib.util.spec_from_file_location("examples", path)
    if spec is None or spec.loader is None:
        raise FileNotFoundError(path)
    examples = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = examples  # where its dataclasses look
    spec.loader.exec_module(examples)
    names: dict[str, Any] = {"__name__": "simulators"}
    for block in examples.blocks(PAGE.read_text(encoding="utf-8")):
        if block.kind == "python":
            print(f"line {block.line} ...", flush=True)
            exec(compile("\n" * block.line + block.text, str(PAGE), "exec"), names)
    return names


def held(simulate: Callable[..., list[float]], names: dict[str, Any], steps: int) -> bool:
    """Whether 16 kg leave every bit of the slip as it is."""
    stretch = 16 * names["GRAVITY"] / names["STIFFNESS"]
    return len(set(simulate(mass=16.0, place=stretch, speed=0.0, steps=steps))) == 1


def measured() -> dict[str, Any]:
    """Slips [m] of every engine, with versions and the day."""
    names = recipes()
    engines = {}
    for engine, (function, ahead, package) in ENGINES.items():
        simulate = names[function]
        engines[engine] = {
            "version": importlib.metadata.version(package),
            "ahead": ahead,
            "held": held(simulate, names, 500),
            "slip": [round(slip, 12) for slip in simulate(**FALL)],
        }
    start, end = (names["in_opensim"](**FALL, ahead=share)[-1] for share in (0.0, 1.0))
    other = {
        "Newton, SolverMuJoCo": names["in_newton"](**FALL, solver="SolverMuJoCo")[-1],
        "OpenSim, force of the step's start": start,
        "OpenSim, force of the step's end": end,
    }
    return {
        "day": datetime.date.today().isoformat(),
        "step": names["STEP"],
        "exact": names["EXACT"],
        "engines": engines,
        "other": {name: round(slip, 12) for name, slip in other.items()},
    }


def table(record: dict[str, Any]) -> str:
    """The table of the page."""
    rows = [
        "",
        f"Measured on {record['day']} with steps of {1e3 * record['step']:g} ms:",
        "",
        "| engine | version | slip | error | 16 kg held |",
        "|---|---|---|---|---|",
    ]
    for engine, found in record["engines"].items():
        slip = found["slip"][-1]
        error = f"{1e6 * (slip - record['exact']):+.2f}".replace("-", "−")
        still = "every bit the same" if found["held"] else "creeps"
        version = found["version"]
        rows.append(f"| {engine} | {version} | {1e3 * slip:.5f} mm | {error} µm | {still} |")
    return "\n".join(rows) + "\n\n"


def write(record: dict[str, Any]) -> None:
    """The record, and the table in the page."""
    RECORD.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(TABLE.sub(lambda _: table(record), page), encoding="utf-8")


if __name__ == "__main__":
    import jax

    jax.config.update("jax_enable_x64", True)
    made = measured()
    write(made)
    print(table(made))
    for name, slip in made["other"].items():
        print(f"{name}: {1e6 * (slip - made['exact']):+.2f} µm")
