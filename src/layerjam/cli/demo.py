"""`demo`: the main job on files, from friction tests to a vacuum, a report and a dataset.

Every step is a command that a user can type, with its usual output.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import json
import shlex
import shutil
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.cli.engine import engine
from layerjam.cli.main import main as layerjam
from layerjam.commands.declare import Help, PythonOnly, command
from layerjam.commands.results import Result, fact, number, result
from layerjam.errors import FileError, LayerjamError, MissingExtraError
from layerjam.units import show

if TYPE_CHECKING:
    from layerjam.device.file import BrakeFile
    from layerjam.report.page import Part
    from layerjam.report.style import Figure

BRAKE = "choi2018-kapton"
ROPE_STIFFNESS = 16.8e3
"""Rope stiffness of the paper's drop test [N/m]."""
BENCH = (
    "bench", "run", "sim:choi2018?speed=0",
    "--procedure", "evacuate to 40 kPa and hold 2 s; vent",
    "--line", "choi2018", "--sensor-range", "103kPa",
    "--safe-state", "release", "--vent-rest", "open",
)  # fmt: skip
TITLE = ("--title", "The demo's campaign", "--licence", "CC0-1.0", "--author", "The demo")
USED = ("ezdxf", "jinja2", "manifold3d", "matplotlib", "pypdfium2", "typst")
"""Packages of the extras that the steps need, checked before the first one."""
MARKER = ".made-by-layerjam-demo"
"""File in the folder that identifies it as the demo's, so that the demo may rebuild it."""


def _clear(out: Path) -> None:
    """Make an empty folder `out` with the demo's marker.

    Removes the files of an earlier demo. Raises FileError, and changes nothing, if another folder
    or file is there.
    """
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise FileError(out, "is not a folder; choose a path that does not exist")
    if out.is_dir() and any(out.iterdir()):
        if not (out / MARKER).is_file():
            raise FileError(
                out,
                "exists and was not made by the demo, which would empty it; name another folder "
                "or remove this one",
            )
        shutil.rmtree(out)
    try:
        out.mkdir(parents=True, exist_ok=True)
        (out / MARKER).write_text("`make demo` empties this folder.\n", encoding="utf-8")
    except OSError as err:
        raise FileError(out, f"cannot be made: {err.strerror}") from None


def _run_command(*words: str) -> None:
    """Print a command and run it."""
    print(f"\n$ layerjam {shlex.join(words)}", flush=True)
    code = layerjam(words)
    if code:
        sys.exit(code)


def _command(*words: str) -> dict[str, Any]:
    """Print a command, run it, and return its answer."""
    _run_command(*words)
    # run it again for the numbers, without writing anything
    words_json = [*words, "--json"]
    for option in ("--out", "--brake"):
        if option in words_json:
            index = words_json.index(option)
            del words_json[index : index + 2]
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        layerjam(words_json)
    return dict(json.loads(output.getvalue()))


def _files(folder: Path) -> tuple[list[Path], list[Path], list[Path]]:
    """Return friction tests, the calibration pull and the validation pulls, synthetic."""
    from layerjam.device.load import load
    from layerjam.studies.choi2018 import lab

    file, validation = load(BRAKE), replace(lab.VALIDATED_ON, repeats=1)
    folder.mkdir(parents=True)
    return (
        lab.friction_files(file, folder),
        lab.pull_files(file, folder, lab.CALIBRATED_ON, "testxpert", "calibration"),
        lab.pull_files(file, folder, validation, "bluehill", "validation"),
    )


@result
class DemoResult(Result):
    """Files of the demo."""

    folder: str = fact("the folder")
    report: str = fact("the page")
    brake: str = fact("the calibrated brake")
    build: str = fact("what a workshop needs to make it")
    run: str = fact("the virtual bench's run")
    dataset: str = fact("the campaign as others can recompute it")
    duration: float = number("s", "time it took")


@command("share", place=5, examples=("layerjam demo",))
def demo(
    *,
    out: Annotated[
        str | Path, Help("Folder to make, or one that an earlier demo made.", metavar="DIR")
    ] = "out/demo",
    typed: Annotated[str, PythonOnly("The command line, if one was typed.", typed=True)] = "",
) -> DemoResult:
    """Show all of it in about a minute: test, calibrate, predict, build, run a bench, publish.

    Rebuilds the folder `out`, prints each command and its answer, and writes a page that compares
    the paper's claims with layerjam. Raises FileError, and writes nothing, if the folder is not the
    demo's own.
    """
    stream = sys.stderr if "--json" in typed.split() else sys.stdout
    with contextlib.redirect_stdout(stream):
        return _demo(Path(out))


def _demo(out: Path) -> DemoResult:
    began = time.perf_counter()
    with MissingExtraError.raise_if_missing("the demo (it draws, builds and publishes)", "all"):
        for name in USED:
            importlib.import_module(name)
    _clear(out)
    engine()
    from layerjam.device.load import load
    from layerjam.studies.choi2018.paper_report import write_report

    print("layerjam: the paper's brake, tested, calibrated, validated and inverted.")
    print("No raw curve of the paper is published, so the files are synthetic: a virtual test")
    print(f"machine writes them to {out / 'measurements'} with the paper's numbers as truth.")
    mine, fit_file = out / "my-brake.toml", out / "my-brake-calibrated.toml"
    run, numbers, pull = _main_job(out, mine, fit_file)
    drawing, build_folder = out / "brake.svg", out / "build"
    _run_command("show", str(fit_file), "--figure", str(drawing))
    _run_command("build", str(fit_file), "--out", str(build_folder), "--no-step")
    run_file, dataset = out / "bench.ljrun", out / "dataset"
    _run_command(*BENCH, "--brake", str(fit_file), "--out", str(run_file))
    campaign = ("--brake", BRAKE, "--calibrate-on", str(pull))
    _run_command("publish", str(out / "measurements"), *campaign, "--out", str(dataset), *TITLE)
    _run_command("recompute", str(dataset))

    print(f"\n$ layerjam reproduce --out {out}", flush=True)
    extra = [_glance(load(fit_file)), run]
    claims = write_report(
        out, progress=lambda what, _: print(f"  {what}"), extra=extra, numbers=numbers
    )
    print("\nThe five numbers that matter (from synthetic files):")
    for value, words in numbers:
        print(f"  {value:>12}  {words}")
    counts = ", ".join(f"{count} {verdict}" for verdict, count in claims.items())
    print(f"\nThe paper's claims: {counts}")
    print(f"Open {out / 'report.html'} (pictures in {out / 'figures'}).")
    took = time.perf_counter() - began
    print(f"Done in {took:.0f} s.")
    return DemoResult(
        folder=str(out),
        report=str(out / "report.html"),
        brake=str(fit_file),
        build=str(build_folder),
        run=str(run_file),
        dataset=str(dataset),
        duration=took,
    )


def _main_job(out: Path, mine: Path, fit_file: Path) -> tuple[Part, list[tuple[str, str]], Path]:
    """Return the page's part about the main job, its five numbers, and the calibration pull."""
    from layerjam.device.load import load
    from layerjam.identify.calibration.peaks import calibrate
    from layerjam.identify.friction.reduction import reduce_friction
    from layerjam.identify.validation.metrics import validate_pulls
    from layerjam.measure.readers.read import read_trace
    from layerjam.studies.choi2018.lab import NORMAL_FORCE, read_pulls
    from layerjam.studies.choi2018.paper_report import main_job

    tests, pull, others = _files(out / "measurements")
    options = ("--normal-force", f"{NORMAL_FORCE!r}N", "--brake", BRAKE, "--out", str(mine))
    friction = _command("friction", *map(str, tests), *options)
    calibration = _command("calibrate", str(mine), *map(str, pull), "--out", str(fit_file))
    validation = _command("validate", str(fit_file), *map(str, others))
    answer = _command("vacuum", str(fit_file), "--slip", "20mm", "--force", "100N")
    brake = load(fit_file)
    traces = [read_trace(p) for p in tests]
    spread = f"± {friction['kinetic_sd']:.4f} SD over three repeats (truth 0.24)"
    numbers = [
        (f"{friction['kinetic']:.4f}", f"kinetic friction, {spread}"),
        (f"{calibration['scale_factor']:.4f}", "scale factor with that friction"),
        (show(calibration["stiffness"], "N/m"), "stiffness of brake and rig (truth 131 kN/m)"),
        (f"{validation['mape']:.2%}", "MAPE on pulls the calibration has not seen"),
        (show(answer["vacuum"], "Pa"), "vacuum for 100 N at 20 mm of slip"),
    ]
    run = main_job(
        brake,
        traces,
        reduce_friction(traces, NORMAL_FORCE),
        calibrate(read_pulls(pull), load(mine).brake),
        validate_pulls(read_pulls(others), brake.brake),
        (0.020, 100.0, float(answer["vacuum"])),
    )
    return run, numbers, pull[0]


def _glance(brake: BrakeFile) -> Part:
    """Return five pictures: the brake, its parts, a pull, a stop, and the pumps."""
    from layerjam.commands.build import verdict
    from layerjam.commands.impact import drop
    from layerjam.commands.tensile import tensile
    from layerjam.commands.vacuum_line import rise
    from layerjam.fluid.file import load_line
    from layerjam.report import build_pictures
    from layerjam.report.build_scene import scene
    from layerjam.report.device_drawing import device
    from layerjam.report.page import Part, Picture

    if (drawing := verdict(brake).record) is None:
        raise LayerjamError(f"{brake.name}: it cannot be drawn")
    stop = drop(
        brake, mass=1.0, speed=2.5, vacuum="tuned", travel=0.04, rope_stiffness=ROPE_STIFFNESS
    )
    pull = tensile(brake, vacuum=94.5e3, speed=0.013, travel=0.04)
    shot = build_pictures.shots(scene(drawing.build, drawing.lengths))["exploded"]
    drawers: dict[str, tuple[Callable[[], Figure], str]] = {
        "device": (partial(device, brake), "The brake at rest, pulled out, and across."),
        "exploded": (partial(build_pictures.labelled, *shot), "Its parts, apart."),
        "pull": (pull.draw, "A pull at 94.5 kPa, computed."),
        "stop": (stop.draw, "1 kg at 2.5 m/s, stopped within 40 mm, computed."),
        "rise": (rise(load_line("choi2018"), target=80e3).draw, "The paper's pumps, computed."),
    }
    pictures = [
        Picture(name=f"glance-{name}", figure=draw, caption=words)
        for name, (draw, words) in drawers.items()
    ]
    return Part(id="glance", title="At a glance", pictures=pictures)


if __name__ == "__main__":
    try:
        demo(out=sys.argv[1] if len(sys.argv) > 1 else "out/demo")
    except LayerjamError as error:
        sys.exit(f"demo: {error}")
