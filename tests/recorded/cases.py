"""Questions whose answers are recorded: {name: (command, arguments)}, and how one is answered."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import layerjam as lj
from law_cases import FAMILIES
from layerjam.brake.device.load import load
from layerjam.laboratory.dataset.campaign_folder import find_brake, read_campaign
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.workshop.commands.build import judge_build
from layerjam.workshop.design.few_numbers import hold, stop
from layerjam.workshop.fabricate.folder import make_files
from layerjam.workshop.fabricate.mesh import make_mesh
from recorded.constants import list_module_numbers
from recorded.counting import find_numbers, sums, sums_said
from recorded.laws import list_law_numbers
from recorded.options import OPTIONS
from recorded.questions import (
    HELD,
    OWN,
    PULL,
    PULLS,
    SAFE,
    STOP,
    WINDOW,
    F,
    K,
    P,
    Question,
    Y,
    ask,
)
from recorded.reading import list_log_numbers, list_read_numbers


def brake_questions() -> dict[str, Question]:
    """Force, stops, pulls and limits of shipped brakes and of brakes with one effect each."""
    made: dict[str, Question] = {}
    for brake in (K, P, F, Y, *OWN):
        speed = {"sliding_speed": "20 mm/s"} if "speed" in brake else {}
        own = "-".join(brake.split(".")[:1])
        made[f"force {own}"] = ask("force", brake, slip=[0, 0.013, 0.04], vacuum="61 kPa", **speed)
        made[f"vacuum {own}"] = ask("vacuum", brake, slip="7 mm", force="40 N", **speed)
        made[f"show {own}"] = ask("show", brake)
        if "speed" not in brake:
            made[f"tune {own}"] = ask("tune", brake, speed="1.4 m/s", **STOP)
            made[f"drop {own}"] = ask("drop", brake, mass="1.3 kg", height="90 mm", vacuum="70 kPa")
            made[f"tensile {own}"] = ask(
                "tensile", brake, vacuum="52 kPa", speed="7 mm/s", elongation="22 mm"
            )
    made |= {
        "force thin air": ask("force", K, slip="9 mm", vacuum="40 kPa", atmosphere="80 kPa"),
        "force mean": ask("force", K, slip="9 mm", vacuum="40 kPa", interval="mean"),
        "tune heights": ask("tune", P, height="120 mm", confidence=0.9, **STOP),
        "tune flat": ask("tune", K, speed="1.1 m/s", horizontal=True, rope_stiffness="9 kN/m",
                         **STOP),
        "drop tuned": ask("drop", K, speed="1.5 m/s", vacuum="tuned", allowed_rise="9 K", **STOP),
        "drop bare": ask("drop", K, speed="1.5 m/s", no_brake=True, mass="1.3 kg",
                         rope_stiffness="5 kN/m"),
        "drop felt": ask("drop", K, speed="2 m/s", vacuum="90 kPa", mass="1.3 kg",
                         accelerometer="adxl193"),
        "tensile shared": ask("tensile", P, elongation="9 mm", **PULL, vacuum_share=0.9),
        "tensile stack": ask("tensile", P, elongation="9 mm", **PULL, model="stack"),
        "tensile scatter": ask("tensile", P, elongation="9 mm", **PULL, model="stack",
                               scatter=0.05, samples=4, seed=3),
        "bend": ask("bend", K, vacuum="60 kPa", angle="40 deg", radius="40 mm"),
        "bend free": ask("bend", P, vacuum="60 kPa", angle="70 deg", slip="12 mm",
                         radius="50 mm", limb_friction=0.3),
        "array": ask("array", K, parallel=3, series=2, vacuum="60 kPa", until="70 mm"),
        "compare": ask("compare", K, P, F, vacuum="70 kPa"),
    }  # fmt: skip
    return made


def motion_questions() -> dict[str, Question]:
    """Motions in time: falling and rising vacuums, ropes, friction that grows with speed, saws."""
    falls = {"mass": "1.3 kg", "speed": "1.5 m/s"}
    saw = {"vacuum": "60 kPa", "mass": "0.7 kg"}
    unload = (
        "evacuate to 50 kPa; pull at 7 mm/s until 18 mm; return at 7 mm/s to 15 mm; "
        "evacuate to 30 kPa and hold 2 s; pull at 7 mm/s until 22 mm"
    )
    return {
        "drop falling": ask("drop", K, vacuum_history="falling.csv", rope_stiffness="30 kN/m",
                            **falls),
        "drop rising": ask("drop", P, vacuum_history="rising.csv", duration="0.4 s", **falls),
        "drop damped": ask("drop", K, vacuum="60 kPa", rope_stiffness="20 kN/m",
                           rope_damping="30 N s/m", duration="0.3 s", **falls),
        "drop leaking": ask("drop", K, vacuum="60 kPa", leak_time="20 s", held="8 s", **falls),
        "drop speed-law": ask("drop", "speed-law.toml", vacuum="60 kPa", **falls),
        "tune speed-law": ask("tune", "speed-law.toml", speed="1.4 m/s", **STOP),
        "tensile unload": ask("tensile", K, procedure=unload),
        "tensile speed-law": ask("tensile", "speed-law.toml", elongation="9 mm", **PULL),
        "tensile rubber": ask("tensile", "rubber.toml", elongation="12 mm", **PULL),
        "force rubber": ask("force", "rubber.toml", slip=[0, 0.013, 0.04], vacuum="61 kPa"),
        "drop rubber": ask("drop", "rubber.toml", vacuum="80 kPa", **falls),
        "tensile one by one": ask("tensile", P, elongation="9 mm", **PULL, model="stack",
                                  static=True, one_by_one=True),
        "saw": ask("stick-slip", K, speed="1 mm/s", slip="3 mm", **saw),
        "saw damped": ask("stick-slip", P, speed="0.4 mm/s", damping="20 N s/m",
                          stribeck_speed="2 mm/s", static=0.3, slip="8 mm", **saw),
    }  # fmt: skip


def bench_questions() -> dict[str, Question]:
    """Evacuation, control and plans on the paper's vacuum line, and logs of chambers."""
    line = "choi2018"
    made = {
        f"rise {fluid}": ask("rise", line, target="70 kPa", fluid=fluid)
        for fluid in ("air", "water")
    }
    made |= {
        f"regulate {kind}": ask("regulate", line, target="55 kPa", kind=kind, duration="6 s",
                                noise="50 Pa", seed=4, **SAFE)
        for kind in ("bang-bang", "pi")
    }  # fmt: skip
    made |= {
        "regulate water": ask("regulate", line, target="40 kPa", fluid="water", duration="8 s",
                              sample_time="20 ms", **SAFE),
        "follow steps": ask("follow", line, P, profile="step", low="10 N", high="40 N",
                            period="4 s", duration="8 s", speed="2 mm/s", seed=2, **SAFE),
        "plan leaking": ask("plan", line, P, mass="0.8 kg", speed="0.9 m/s", warning="2 s",
                            travel="50 mm", mass_sd="0.1 kg", horizontal=True, confidence=0.9),
        "regulate fault": ask("regulate", line, target="40 kPa", fault="leak", fault_at="3 s",
                              duration="8 s", **SAFE),
        "follow": ask("follow", line, K, profile="sine", low="20 N", high="70 N", period="10 s",
                      duration="10 s", speed="1 mm/s", **SAFE),
        "plan": ask("plan", line, K, mass="1 kg", speed="1 m/s", warning="1 s", travel="50 mm",
                    mass_sd="0.1 kg", speed_sd="0.05 m/s"),
        "leak": ask("leak", "leak.csv", volume="0.2 l", temperature="25 degC"),
        "pump-down": ask("pump-down", "alone.csv", with_volume="larger.csv",
                         added_volume="0.1 l"),
        "crash": ask("crash", "crash.csv", filter_class="CFC60", hic="15 ms"),
        "parts": ask("parts"),
        "rise tube": ask("rise", "tube.toml", target="60 kPa"),
        "regulate tube": ask("regulate", "tube.toml", target="60 kPa", duration="20 s", **SAFE),
    }  # fmt: skip
    return made


def laboratory_questions() -> dict[str, Question]:
    """What files of a virtual laboratory with faults of its machine say."""
    return {
        "pull": ask("pull", list(PULLS)),
        "pull window": ask("pull", list(PULLS[1:2]), end="3 s"),
        "friction": ask("friction", list(HELD[:2]), **WINDOW, brake=K, out="tested.toml"),
        "friction window": ask("friction", list(HELD[2:4]), **WINDOW),
        "ageing": ask("ageing", list(HELD), **WINDOW, brake=K, out="old.toml"),
        "calibrate": ask("calibrate", K, list(PULLS[:3]), out="calibrated.toml"),
        "calibrate alone": ask("calibrate", K, list(PULLS[:1])),
        "calibrate enough": ask("calibrate", K, list(PULLS), within=0.01),
        "calibrate left out": ask("calibrate", K, list(PULLS), exclude=[PULLS[1]], because="t"),
        "calibrate curves": ask("calibrate", K, list(PULLS), depth="curves"),
        "validate": ask("validate", K, list(PULLS[3:])),
        "enclosure": ask("enclosure", ["silicone.csv"], area="20 mm^2", gauge_length="33 mm",
                         brake=K, hyperelastic=True, out="soft.toml"),
        "publish": ask("publish", "lab", out="published", brake=K, friction=list(HELD[:2]),
                       **WINDOW, calibrate_on=list(PULLS[:3]), validate=list(PULLS[3:]),
                       title="t"),
    }  # fmt: skip


def workshop_questions() -> dict[str, Question]:
    """Designs, and the files of a build."""
    return {
        "design": ask("design", "grip.toml", out="grip-brake.toml"),
        "sweep": ask("sweep", "grip.toml", out="sweep"),
        "build": ask("build", K, out="built"),
        "parts laser": ask("drawn parts", K, parallel=2, kerf="0.2 mm", cutter="laser"),
        "parts knife": ask("drawn parts", F, series=3, cutter="knife"),
        "parts bed": ask("drawn parts", Y, print_bed="220x220x250 mm", stock="300x200 mm"),
        "parts elsewhere": ask("drawn parts", P, parallel=3, series=2, workshop="workshop.toml"),
        "requests": ask("requests"),
        "folder": ask("folder", "lab"),
        "build array": ask("build", P, out="two", parallel=2, kerf="0.2 mm", cutter="laser"),
        "scenario": ask("scenario", "neck-guard"),
        "export-c": ask("export-c", K, out="c"),
    }


QUESTIONS = brake_questions() | motion_questions() | bench_questions()
QUESTIONS |= laboratory_questions() | workshop_questions()
QUESTIONS |= {f"laws {family}": ask("laws", family) for family in (*FAMILIES, "marches")}
QUESTIONS |= OPTIONS | {"constants": ask("constants"), "reading": ask("reading")}
OMITTED = ("fingerprint", "made_by", "version", "seconds", "versions", "hash", "digest", "sha256")
"""Keys that change with each version or run."""
SIZES = "ro-crate-metadata.json"
"""File that states the sizes of the others, drawn by whatever versions of libraries are there."""
COUNTED = (".svg", ".csv", ".toml", ".html", ".md", ".txt", ".c", ".h", ".json")


def answer(question: Question) -> dict[str, float | str]:
    """Return {path of a key: number or word} of a result, and of the files it has written."""
    name, subjects, options = question
    if name == "laws":
        return list_law_numbers(*subjects)
    if name == "constants":
        return list_module_numbers()
    if name == "reading":
        return list_read_numbers(Path.cwd()) | list_log_numbers(Path.cwd())
    if name == "requests":
        return list_requests()
    if name == "folder":
        return list_campaign(Path(*subjects))
    if name == "drawn parts":
        built = judge_build(*subjects, **options)
        return list_part_numbers(built.record) | sums_said(str(built).splitlines(), "printed")
    command = lj
    for part in name.replace("-", "_").split():
        command = getattr(command, part)
    try:
        result = command(*subjects, **options)
    except lj.LayerjamError as error:
        return {"error": type(error).__name__}
    values = json.loads(result.json())
    printed = str(result).splitlines()
    made = flatten(values) | sums_said(list_sentences(values), "said")
    made |= sums_said(printed, "printed")
    try:
        table = result.to_frame()
    except (lj.LayerjamError, AttributeError):
        table = {}
    for column in table:
        if getattr(table[column], "dtype", None) == np.float64:
            made |= sums(list(table[column]), f"table {column}")
    for place in [Path(options["out"])] if "out" in options else []:
        for file in sorted(place.rglob("*")) if place.is_dir() else [place]:
            if file.suffix in COUNTED and file.is_file() and file.name != SIZES:
                made |= summary(file, file.relative_to(place).as_posix())
    return made


def list_part_numbers(drawing: Any) -> dict[str, float | str]:
    """Return the numbers of the files for cutting, printing and CAD, and the sizes of the parts."""
    made: dict[str, float | str] = {}
    for name, content in make_files(drawing, with_step=True, coupons=True).items():
        if not name.endswith(".stl"):  # the corners of the meshes tell as much
            made |= sums_said([read_text(name, content)], name)
    for part in drawing.parts:
        mesh = make_mesh(part.solid)
        made |= sums(np.sort(mesh.corners, axis=0).ravel().tolist(), f"{part.name}.corners")
        made[f"{part.name}.volume"] = mesh.volume
    return made


def list_requests() -> dict[str, float | str]:
    """Return the numbers of design requests that are made from a few numbers."""
    made: dict[str, float | str] = {}
    size = {"mass": "60 g", "width": "26 mm", "length": "175 mm"}
    moves = {"mass": "5 kg", "speed": "1.2 m/s", "travel": "50 mm", "force": "900 N"}
    for name in (K, P):
        requests = {
            "hold": hold(load(name), name, force="300 N", **size),
            "slide": hold(load(name), name, force="90 N", **{**size, "length": "290 mm"},
                          travel="12 mm", when="sliding", prefer="energy", vacuum="70 kPa"),
            "stop": stop(load(name), name, **moves),
            "stop small": stop(load(name), name, **moves, own_mass="90 g", width="20 mm",
                               length="300 mm", vacuum="55 kPa", prefer="length"),
        }  # fmt: skip
        for kind, request in requests.items():
            made |= sums_said(request.text().splitlines(), f"{name} {kind}")
    return made


def list_campaign(folder: Path) -> dict[str, float | str]:
    """Return the uses of the files in a folder, and the brake that was tested."""
    found = read_campaign(folder, ReadingOptions())
    uses = {"friction": found.friction, "pulls": found.pulls, "brakes": found.brakes}
    made: dict[str, float | str] = {name: " ".join(files) for name, files in uses.items()}
    return made | {
        "tested": find_brake(found),
        "facts": " ".join(f.brake or "-" for f in found.facts),
    }


def read_text(name: str, content: str | bytes) -> str:
    """Return the text of a file of a build."""
    if isinstance(content, str):
        return content
    if name.endswith(".3mf"):
        with zipfile.ZipFile(io.BytesIO(content)) as package:
            return package.read("3D/3dmodel.model").decode()
    return content.decode()


def flatten(value: Any, path: str = "") -> dict[str, float | str]:
    """Return the numbers and short words of nested JSON; a long list by its sums."""
    if isinstance(value, Mapping):
        parts = {key: flatten(v, f"{path}.{key}") for key, v in value.items() if key not in OMITTED}
        return {key: v for part in parts.values() for key, v in part.items()}
    if isinstance(value, list):
        numbers = [v for v in value if isinstance(v, int | float) and not isinstance(v, bool)]
        if len(numbers) > 8:
            return sums(numbers, path)
        if len(value) > 3 and all(isinstance(one, Mapping) for one in value):
            return sums_of_rows([flatten(one) for one in value], path)
        return {k: v for i, one in enumerate(value) for k, v in flatten(one, f"{path}.{i}").items()}
    if isinstance(value, bool) or value is None:
        return {path: str(value)}
    if isinstance(value, int | float):
        return {path: float(value)}
    return {path: value} if re.fullmatch(r"[\w-]{1,30}", value) else {}


def list_sentences(value: Any) -> list[str]:
    """Return the sentences in nested JSON, which `flatten` leaves out."""
    if isinstance(value, Mapping):
        return [s for key, v in value.items() if key not in OMITTED for s in list_sentences(v)]
    if isinstance(value, list):
        return [s for one in value for s in list_sentences(one)]
    return [value] if isinstance(value, str) and " " in value else []


def sums_of_rows(rows: list[dict[str, float | str]], path: str) -> dict[str, float | str]:
    """Return the sums of each column of some rows."""
    columns: dict[str, list[float]] = {}
    for row in rows:
        for key, value in row.items():
            if isinstance(value, float):
                columns.setdefault(key, []).append(value)
    return {k: v for key, col in columns.items() for k, v in sums(col, path + key).items()}


def summary(file: Path, name: str) -> dict[str, float | str]:
    """Return sums over the numbers in a file of text."""
    text = file.read_text("utf-8", "replace")
    return sums(find_numbers([text]), f"file {name}")
