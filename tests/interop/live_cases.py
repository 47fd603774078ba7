"""Random inputs of a page's kernel, the script that answers them there, and Python's answers."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

from brake.kernel.histories import history
from layerjam.bench.control.plan import Arrival, needed_vacuum
from layerjam.brake.device.brake import Brake
from layerjam.brake.figures import live_page
from layerjam.brake.kernel.kernel import Kernel
from layerjam.brake.kernel.parameters import parameters
from layerjam.brake.kernel.web import read_module
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stop.exact import NEVER_SLID, STOPPED, stop
from layerjam.brake.simulate.drop import series_spring
from layerjam.brake.simulate.least_vacuum import GRID, LEVELS, MARGIN, find_least_vacuum
from strategies import KAPTON, one, random_brakes

FIELDS = ("slip", "peak_force", "end_speed", "heat", "stored")
SEARCH = {"levels": LEVELS, "grid": GRID}
SCRIPT = """
const answer = async ({module, cases}) => {
  const said = [];
  const vacuums = (kernel, arrival, site) =>
    [0, site.margin].map(margin => safeVacuum(kernel, arrival, margin, site));
  for (const {numbers, end, full, search, margin, forces, stops, pull, arrivals} of cases) {
    const kernel = await openKernel(module, numbers);
    const stopped = stops.map(case_ => kernel.stop(...case_, end));
    kernel.start(pull[0][1]);
    said.push({
      forces: forces.map(case_ => kernel.force(...case_)),
      stops: stopped.map(s => [s.slip, s.peak, s.endSpeed, s.heat, s.stored]),
      outcomes: stopped.map(s => s.outcome),
      pull: pull.map(case_ => {
        const {force, slip, work, heat} = kernel.move(...case_);
        return [force, slip, work, heat];
      }),
      vacuums: arrivals.map(arrival => vacuums(kernel, arrival, {full, end, search, margin})),
    });
  }
  return said;
};
"""


def safe_vacuum(brake: Brake, case: Arrival) -> float | None:
    """The lowest vacuum [Pa] that suffices if mass, speed and vacuum are off by `MARGIN`."""
    spring = series_spring(brake, case.rope_stiffness)
    mass, speed = case.mass * (1 + MARGIN), case.speed * (1 + MARGIN)

    def stops(vacuums: Any) -> Any:
        end = stop(mass, speed, vacuums * (1 - MARGIN), spring, case.gravity, brake)
        stands = (end.outcome == STOPPED) | (end.outcome == NEVER_SLID)
        return stands & (end.slip <= case.travel)

    return find_least_vacuum(stops, brake.site.atmosphere)


def kernel_script() -> str:
    """The page's own code around the kernel, then the function that answers the cases."""
    folder = Path(live_page.__file__).parent
    return (folder / "live_kernel.js").read_text(encoding="utf-8") + SCRIPT


def brakes() -> list[Brake]:
    """The paper's brake and nine random ones, of which four have a pressure exponent."""
    plain, bent = random_brakes(53, 5), random_brakes(54, 4, exponent=True)
    return [KAPTON, *(one(plain, i) for i in range(5)), *(one(bent, i) for i in range(4))]


def make_case(brake: Brake, seed: int, count: int = 100) -> dict[str, Any]:
    """Inputs for one brake: `count` forces, stops and moves of a pull, and three arrivals."""
    rng = np.random.default_rng(seed)
    full, end = brake.site.atmosphere, brake.sheets.usable_travel
    energy = float(brake_force(end / 2, full, brake)) * end
    speeds = rng.uniform(0, 4, count)
    masses = energy / np.maximum(speeds, 0.3) ** 2 * rng.uniform(0.02, 1.5, count)
    gravity = np.where(rng.random(count) < 0.3, 0.0, brake.site.gravity)
    path, vacuum = history(brake, seed, count)
    vacuums = full * rng.random(count)
    return {
        "numbers": list(parameters(brake)),
        "end": end,
        "full": full,
        "search": SEARCH,
        "margin": MARGIN,
        "forces": np.stack([end * rng.random(count), vacuums], 1).tolist(),
        "stops": np.stack([masses, speeds, vacuums, gravity], 1).tolist(),
        "pull": np.stack([path, vacuum], 1).tolist(),
        "arrivals": [
            {"mass": float(masses[i]), "speed": float(speeds[i]), "travel": end * share,
             "gravity": float(gravity[i])}
            for i, share in enumerate((0.4, 0.7, 0.95))
        ],
    }  # fmt: skip


def make_cases() -> dict[str, Any]:
    """The module and the inputs for every brake, as the script takes them."""
    module = base64.b64encode(read_module()).decode()
    return {"module": module, "cases": [make_case(b, i) for i, b in enumerate(brakes())]}


def near(ours: Any, theirs: Any) -> None:
    """Two arrays are equal to 1e-12 of each number, or of their largest number's last bits."""
    ours, theirs = np.asarray(ours, float), np.asarray(theirs, float)
    scale = np.nanmax(np.abs(theirs), axis=0)
    np.testing.assert_array_less(
        np.abs(ours - theirs), 1e-12 * np.maximum(np.abs(theirs), 1e-3 * scale) + 1e-300
    )


def check_answers(inputs: dict[str, Any], answers: list[dict[str, Any]]) -> None:
    """Compare a page's answers with Python's, which come from the laws and the native kernel."""
    for brake, case, said in zip(brakes(), inputs["cases"], answers, strict=True):
        slip, vacuum = np.array(case["forces"]).T
        near(said["forces"], brake_force(slip, vacuum, brake))
        mass, speed, vacuum, gravity = np.array(case["stops"]).T
        spring = case["numbers"][2]
        result = stop(mass, speed, vacuum, spring, gravity, brake)
        names = ("STOPPED", "NEVER_SLID", "BOTTOMED_OUT", "SNAPS")
        assert said["outcomes"] == [names[int(code)] for code in result.outcome]
        near(said["stops"], np.stack([getattr(result, name) for name in FIELDS], 1))
        kernel, rows = Kernel(brake), []
        kernel.start(case["pull"][0][1])
        for elongation, pressure in case["pull"]:
            kernel.move(elongation, pressure)
            rows.append((kernel.force, kernel.slip, kernel.work, kernel.heat))
        near(said["pull"], rows)
        for arrival, vacuums in zip(case["arrivals"], said["vacuums"], strict=True):
            wanted = Arrival(**arrival, warning=0.0)
            expected = [needed_vacuum(brake, wanted), safe_vacuum(brake, wanted)]
            assert [v is None for v in vacuums] == [v is None for v in expected]
            for ours, theirs in zip(vacuums, expected, strict=True):
                assert ours is None or abs(ours - theirs) <= 1e-12 * case["full"]


def as_program(inputs: dict[str, Any]) -> str:
    """A program for Node that prints the answers as JSON."""
    data = json.dumps(inputs)
    return f"{kernel_script()}\nconsole.log(JSON.stringify(await answer({data})));\n"
