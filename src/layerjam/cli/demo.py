"""`demo`: the main workflow on files, from friction tests to a vacuum, a report and a dataset.

Every step is a command that a user can type. Its usual output goes into a log; the terminal shows
one line per step.
"""

import contextlib
import importlib
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from layerjam.bench.rig.stop import Stop
from layerjam.cli.interrupts import handle_interrupts
from layerjam.cli.main import main as layerjam
from layerjam.core.command.declare import Help, PythonOnly, command
from layerjam.core.command.results import STOPPED, Result, fact, number, result
from layerjam.core.errors import FileError, LayerjamError, MissingExtraError
from layerjam.core.system import check_file_name, format_command_line, quote_word, report_failure
from layerjam.core.units import show

if TYPE_CHECKING:
    from layerjam.brake.device.brake_file import BrakeFile
    from layerjam.core.drawing.page import Part
    from layerjam.core.drawing.style import Figure

BRAKE = "choi2018-kapton"
SLIP, FORCE = 0.020, 100.0
"""Slip [m] and force [N] for which the demo finds the vacuum."""
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
"""Packages of the extras that the steps need, checked before the first step."""
LOG, RUN, BUILD, DATASET = "demo.log", "bench.ljrun", "build", "dataset"
Files = tuple[list[Path], list[Path], list[Path]]
MARKER = ".made-by-layerjam-demo"
"""Marker file of a folder that the demo created and may therefore rebuild."""


def _prepare_folder(out: Path) -> None:
    """Make an empty folder `out` with the demo's marker.

    Removes the files of an earlier demo. Raises FileError, and changes nothing, if a different
    folder or file is there.
    """
    check_file_name(out)
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise FileError(out, "is not a folder; choose a path that does not exist")
    if out.is_dir() and any(out.iterdir()):
        if not (out / MARKER).is_file():
            raise FileError(
                out,
                "exists and was not created by the demo, which would delete its "
                "contents; choose a different folder or remove this one",
            )
        shutil.rmtree(out)
    with report_failure(out, "cannot be created"):
        out.mkdir(parents=True, exist_ok=True)
        (out / MARKER).write_text("`make demo` empties this folder.\n", encoding="utf-8")


class _Steps:
    """Steps of the demo: prints one line with the duration of each, and logs all output."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @contextlib.contextmanager
    def log_step(self, content: str) -> Iterator[Callable[[str, float], None]]:
        """Print the name and the duration of a step; append its output to the log.

        The progress of a long step goes into the log, and its percentage also to a terminal.
        """
        terminal, began = sys.stdout, time.perf_counter()
        line = f"\r  {content:<62}" if terminal.isatty() else ""
        print(f"  {content:<62}", end="", flush=True)

        def show_progress(phase: str, share: float) -> None:
            print(f"  {phase}")
            if line:
                print(f"{line}{share:6.0%}", end="", file=terminal, flush=True)

        try:
            with (
                self.path.open("a", encoding="utf-8") as log,
                contextlib.redirect_stdout(log),
                contextlib.redirect_stderr(log),
            ):
                yield show_progress
        except BaseException:
            print("stopped")
            raise
        print(f"{line}{time.perf_counter() - began:6.1f} s")

    def run_step(self, content: str, *words: str) -> None:
        """Run a command as one step. Raises LayerjamError if its exit code is not 0."""
        line = format_command_line(("layerjam", *words))
        with self.log_step(content):
            print(f"\n$ {line}", flush=True)
            Stop.signalled = False
            code = layerjam(words)
            if code == STOPPED or (code and Stop.signalled):
                raise KeyboardInterrupt
            if code:
                raise LayerjamError(f"'{line}' ended with exit code {code}; see {self.path}")


def _write_test_files(folder: Path) -> Files:
    """Return friction tests, the calibration pull and the validation pulls, all synthetic."""
    from layerjam.brake.device.load import load
    from layerjam.studies.choi2018 import lab

    file, validation = load(BRAKE), replace(lab.VALIDATED_ON, repeats=1)
    folder.mkdir(parents=True)
    return (
        lab.write_friction_files(file, folder),
        lab.write_pulls(file, folder, lab.CALIBRATED_ON, "testxpert", "calibration"),
        lab.write_pulls(file, folder, validation, "bluehill", "validation"),
    )


@result
class DemoResult(Result):
    """Files of the demo."""

    folder: str = fact("folder of the demo")
    report: str = fact("report page")
    pictures: str = fact("folder with the pictures of the page")
    log: str = fact("log with the output of each step")
    brake: str = fact("the calibrated brake")
    build: str = fact("files with which a workshop can build the brake")
    run: str = fact("run of the virtual bench")
    dataset: str = fact("dataset of the campaign that others can recompute")
    duration: float = number("s", "duration of the demo")


@command("share")
def demo(
    *,
    out: Annotated[
        str | Path, Help("Folder to create, or one that an earlier demo created.", metavar="DIR")
    ] = "out/demo",
    typed: Annotated[str, PythonOnly("Command line, if one was typed.", typed=True)] = "",
) -> DemoResult:
    """Show everything in about a minute: test, calibrate, predict, build, run a bench, publish.

    Rebuilds the folder `out`, prints one line with its time for each step, and writes a page that
    compares the paper's claims with layerjam. Each command with its output is in `demo.log` next to
    the page. Raises FileError, and writes nothing, if the folder is not the demo's own, and
    LayerjamError if a step fails.
    """
    stream = sys.stderr if "--json" in typed.split() else sys.stdout
    with contextlib.redirect_stdout(stream):
        return _run_demo(Path(out))


def _run_demo(out: Path) -> DemoResult:
    began = time.perf_counter()
    with MissingExtraError.raise_if_missing("the demo (it draws, builds and publishes)", "all"):
        for name in USED:
            importlib.import_module(name)
    _prepare_folder(out)
    handle_interrupts()
    from layerjam.brake.device.load import load
    from layerjam.studies.choi2018.paper_report import write_report

    print("The brake of Choi et al. (2018), from test files to a report, in 11 steps. The files")
    print("are synthetic: the paper has no raw curves, so a virtual test machine generates them.\n")
    steps = _Steps(out / LOG)
    brake_path, calibrated_path = out / "my-brake.toml", out / "my-brake-calibrated.toml"
    with steps.log_step("measure: generate the files of a virtual test machine"):
        files = _write_test_files(out / "measurements")
    for content, words in _plan_commands(out, brake_path, calibrated_path, files).items():
        steps.run_step(content, *map(str, words))
    with steps.log_step("reproduce: the paper's claims and figures on one page") as tell:
        print(f"\n$ layerjam reproduce --out {quote_word(str(out))}", flush=True)
        run, numbers = _describe_main_job(load(brake_path), load(calibrated_path), files)
        pictures = [_draw_glance(load(calibrated_path)), run]
        claims = write_report(out, progress=tell, extra=pictures, numbers=numbers)
    print("\nThe five key numbers (from synthetic files):")
    for value, meaning in numbers:
        print(f"  {value:>12}  {meaning}")
    counts = ", ".join(f"{verdict} {count}" for verdict, count in claims.items())
    print(f"\nThe paper's claims: {counts}")
    print(f"Open {out / 'report.html'} in a browser.\n", flush=True)
    return DemoResult(
        folder=str(out),
        report=str(out / "report.html"),
        pictures=str(out / "figures"),
        log=str(steps.path),
        brake=str(calibrated_path),
        build=str(out / BUILD),
        run=str(out / RUN),
        dataset=str(out / DATASET),
        duration=time.perf_counter() - began,
    )


def _plan_commands(
    out: Path, brake_path: Path, calibrated_path: Path, files: Files
) -> dict[str, tuple[object, ...]]:
    """Return {step: command line} of the steps that are commands."""
    from layerjam.studies.choi2018.lab import NORMAL_FORCE

    tests, (pull,), others = files
    return {
        "friction: friction coefficients from 3 tests of two films": (
            *("friction", *tests, "--normal-force", f"{NORMAL_FORCE!r}N"),
            *("--brake", BRAKE, "--out", brake_path),
        ),
        "calibrate: scale factor and stiffness from one pull": (
            *("calibrate", brake_path, pull),
            *("--out", calibrated_path),
        ),
        "validate: the model against 6 other pulls": ("validate", calibrated_path, *others),
        "vacuum: the vacuum that resists 100 N at a slip of 20 mm": (
            *("vacuum", calibrated_path),
            *("--slip", show(SLIP, "m"), "--force", show(FORCE, "N")),
        ),
        "show: draw the brake": ("show", calibrated_path, "--figure", out / "brake.svg"),
        "build: film patterns, printed parts, instructions": (
            *("build", calibrated_path),
            *("--out", out / BUILD, "--no-step"),
        ),
        "bench run: evacuate to 40 kPa and vent on a virtual bench": (
            *BENCH,
            *("--brake", calibrated_path, "--out", out / RUN),
        ),
        "publish: the test files as a dataset": (
            *("publish", out / "measurements", "--brake", BRAKE, "--calibrate-on", pull),
            *("--out", out / DATASET, *TITLE),
        ),
        "recompute: every number of the dataset again": ("recompute", out / DATASET),
    }


def _describe_main_job(
    brake: "BrakeFile", calibrated_brake: "BrakeFile", files: Files
) -> "tuple[Part, list[tuple[str, str]]]":
    """Return the page's part about the main workflow, and its five numbers.

    `brake` contains the measured friction, `calibrated_brake` also the calibration. `files` are
    friction tests, calibration pulls and validation pulls.
    """
    from layerjam.brake.commands.force import vacuum
    from layerjam.laboratory.identify.calibration.peaks import calibrate
    from layerjam.laboratory.identify.friction.reduction import reduce_friction
    from layerjam.laboratory.identify.validation.metrics import validate_pulls
    from layerjam.laboratory.measure.readers.read import read_trace
    from layerjam.studies.choi2018.lab import NORMAL_FORCE, read_pulls
    from layerjam.studies.choi2018.paper_report import make_main_part

    tests, pulls, others = files
    traces = [read_trace(test) for test in tests]
    friction = reduce_friction(traces, NORMAL_FORCE)
    calibration = calibrate(read_pulls(pulls), brake.brake)
    validation = validate_pulls(read_pulls(others), calibrated_brake.brake)
    needed_vacuum = float(vacuum(calibrated_brake, slip=SLIP, force=FORCE).record[-1])
    scatter = f"± {friction.kinetic_sd:.4f} SD between three repeats (true: 0.24)"
    numbers = [
        (f"{friction.kinetic:.4f}", f"kinetic friction, {scatter}"),
        (f"{calibration.scale_factor:.4f}", "scale factor with that friction"),
        (show(calibration.stiffness, "N/m"), "stiffness of the brake and rig (true: 131 kN/m)"),
        (f"{validation.mape:.2%}", "MAPE on pulls not used in the calibration"),
        (show(needed_vacuum, "Pa"), "vacuum for 100 N at a slip of 20 mm"),
    ]
    part = make_main_part(
        calibrated_brake, traces, friction, calibration, validation, (SLIP, FORCE, needed_vacuum)
    )
    return part, numbers


def _draw_glance(brake: "BrakeFile") -> "Part":
    """Return five pictures: the brake, its parts, a pull, a stop, and the pumps."""
    from layerjam.brake.commands.drop import drop
    from layerjam.brake.commands.tensile import tensile
    from layerjam.brake.commands.vacuum_line import rise
    from layerjam.brake.figures.device_drawing import draw_device
    from layerjam.brake.fluid.line_file import load_line
    from layerjam.core.drawing.page import Part, Picture
    from layerjam.workshop.commands.build import judge_build
    from layerjam.workshop.figures import build_pictures
    from layerjam.workshop.figures.build_scene import make_scene

    if (drawing := judge_build(brake).record) is None:
        raise LayerjamError(f"{brake.name}: the brake cannot be drawn")
    stop = drop(
        brake, mass=1.0, speed=2.5, vacuum="tuned", travel=0.04, rope_stiffness=ROPE_STIFFNESS
    )
    pull = tensile(brake, vacuum=94.5e3, speed=0.013, elongation=0.04)
    shot = build_pictures.make_shots(make_scene(drawing.build, drawing.lengths))["exploded"]
    device, rising = partial(draw_device, brake), rise(load_line("choi2018"), target=80e3)
    drawers: dict[str, tuple[Callable[[], Figure], str]] = {
        "device": (device, "The brake at rest, extended, and in cross-section."),
        "exploded": (partial(build_pictures.add_labels, *shot), "Its parts, separated."),
        "pull": (pull.draw, "Computed pull at 94.5 kPa."),
        "stop": (stop.draw, "Computed stop of 1 kg from 2.5 m/s within 40 mm."),
        "rise": (rising.draw, "Computed rise with the paper's pumps."),
    }
    pictures = [
        Picture(name=f"glance-{name}", figure=draw, caption=words)
        for name, (draw, words) in drawers.items()
    ]
    return Part(id="glance", title="At a glance", pictures=pictures)
