"""`make demo`: the main job on files, from friction tests to a vacuum and a report.

Every step is a command a user can type; what it prints is what they would see.
"""

from __future__ import annotations

import contextlib
import io
import json
import shlex
import shutil
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from layerjam.cli.engine import engine
from layerjam.cli.main import main as layerjam
from layerjam.errors import FileError, LayerjamError
from layerjam.units import show

BRAKE = "choi2018-kapton"
MARKER = ".made-by-layerjam-demo"
"""A file in the folder that says that the demo made it, and so may make it anew."""


def _clear(out: Path) -> None:
    """An empty folder `out` with the demo's marker.

    What an earlier demo left there is removed. Raises FileError where somebody else's folder or
    file stands, and touches nothing of it.
    """
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise FileError(out, "is no folder; name one that the demo may make")
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


def _command(*words: str) -> dict[str, Any]:
    """Show a command, run it, and give its answer."""
    print(f"\n$ layerjam {shlex.join(words)}", flush=True)
    code = layerjam(words)
    if code:
        sys.exit(code)
    # once more for the numbers, without writing anything
    asked = [*words, "--json"]
    for option in ("--out", "--brake"):
        if option in asked:
            at = asked.index(option)
            del asked[at : at + 2]
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown):
        layerjam(asked)
    return dict(json.loads(shown.getvalue()))


def _files(folder: Path) -> tuple[list[Path], list[Path], list[Path]]:
    """Friction tests, the calibration pull and the validation pulls, synthetic."""
    from layerjam.device.load import load
    from layerjam.studies.choi2018 import lab

    file, once = load(BRAKE), replace(lab.VALIDATED_ON, repeats=1)
    folder.mkdir(parents=True)
    return (
        lab.friction_files(file, folder),
        lab.pull_files(file, folder, lab.CALIBRATED_ON, "testxpert", "calibration"),
        lab.pull_files(file, folder, once, "bluehill", "validation"),
    )


def demo(out: Path) -> None:
    """Rebuild the folder `out` and print where the report is and the five numbers that matter.

    Raises FileError, and writes nothing, where the folder is not the demo's own.
    """
    began = time.perf_counter()
    _clear(out)
    engine()
    from layerjam.device.load import load
    from layerjam.identify.calibration.peaks import calibrate
    from layerjam.identify.friction.reduction import reduce_friction
    from layerjam.identify.validation.metrics import validate_pulls
    from layerjam.measure.readers.read import read_trace
    from layerjam.studies.choi2018.lab import NORMAL_FORCE, read_pulls
    from layerjam.studies.choi2018.paper_report import main_job, write_report

    print("layerjam: the paper's brake, tested, calibrated, validated and inverted.")
    print("No raw curve of the paper is published, so the files are synthetic: a virtual test")
    print(f"machine writes them to {out / 'measurements'} with the paper's numbers as truth.")
    tests, pull, others = _files(out / "measurements")
    mine, fitted = out / "my-brake.toml", out / "my-brake-calibrated.toml"
    named = ("--normal-force", f"{NORMAL_FORCE!r}N", "--brake", BRAKE, "--out", str(mine))
    friction = _command("friction", *map(str, tests), *named)
    calibration = _command("calibrate", str(mine), *map(str, pull), "--out", str(fitted))
    validation = _command("validate", str(fitted), *map(str, others))
    answer = _command("vacuum", str(fitted), "--slip", "20mm", "--force", "100N")

    print(f"\n$ layerjam reproduce --out {out}", flush=True)
    brake = load(fitted)
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
    counted = write_report(
        out, progress=lambda what, _: print(f"  {what}"), extra=[run], numbers=numbers
    )
    print("\nThe five numbers that matter (from synthetic files):")
    for value, words in numbers:
        print(f"  {value:>12}  {words}")
    counts = ", ".join(f"{count} {verdict}" for verdict, count in counted.items())
    print(f"\nThe paper's claims: {counts}")
    print(f"Open {out / 'report.html'} (pictures in {out / 'figures'}).")
    print(f"Done in {time.perf_counter() - began:.0f} s.")


if __name__ == "__main__":
    try:
        demo(Path(sys.argv[1] if len(sys.argv) > 1 else "out/demo"))
    except LayerjamError as error:
        sys.exit(f"demo: {error}")
