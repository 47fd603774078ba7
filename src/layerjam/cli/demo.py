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

from layerjam.cli.main import main as layerjam
from layerjam.cli.options import engine
from layerjam.units import show

BRAKE = "choi2018-kapton"


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
    """Rebuild the folder `out` and print where the report is and the five numbers that matter."""
    began = time.perf_counter()
    engine()
    from layerjam.device.load import load
    from layerjam.identify.calibration.peaks import calibrate
    from layerjam.identify.friction.reduction import reduce_friction
    from layerjam.identify.validation.metrics import validate_pulls
    from layerjam.measure.readers.read import read_trace
    from layerjam.studies.choi2018.lab import NORMAL_FORCE, read_pulls
    from layerjam.studies.choi2018.reproduce import main_job, reproduce

    shutil.rmtree(out, ignore_errors=True)
    print("layerjam: the paper's brake, tested, calibrated, validated and inverted.")
    print("No raw curve of the paper is published, so the files are synthetic: a virtual test")
    print(f"machine writes them to {out / 'measurements'} with the paper's numbers as truth.")
    tests, pull, others = _files(out / "measurements")
    mine, fitted = out / "my-brake.toml", out / "my-brake-calibrated.toml"
    friction = _command(
        "friction", *map(str, tests), "--normal-force", f"{NORMAL_FORCE!r}N", "--brake", BRAKE,
        "--out", str(mine),
    )  # fmt: skip
    calibration = _command("calibrate", str(mine), *map(str, pull), "--out", str(fitted))
    validation = _command("validate", str(fitted), *map(str, others))
    answer = _command("vacuum", str(fitted), "--slip", "20mm", "--force", "100N")

    print(f"\n$ layerjam reproduce --out {out}", flush=True)
    brake = load(fitted)
    traces = [read_trace(p) for p in tests]
    numbers = [
        (f"{friction['kinetic']:.4f}", f"kinetic friction, ± {friction['kinetic_sd']:.4f} SD over "
         "three repeats (truth 0.24)"),
        (f"{calibration['scale_factor']:.4f}", "scale factor with that friction"),
        (show(calibration["stiffness"], "N/m"), "stiffness of brake and rig (truth 131 kN/m)"),
        (f"{validation['mape']:.2%}", "MAPE on pulls the calibration has not seen"),
        (show(answer["vacuum"], "Pa"), "vacuum for 100 N at 20 mm of slip"),
    ]  # fmt: skip
    run = main_job(
        brake,
        traces,
        reduce_friction(traces, NORMAL_FORCE),
        calibrate(read_pulls(pull), load(mine).brake),
        validate_pulls(read_pulls(others), brake.brake),
        (0.020, 100.0, float(answer["vacuum"])),
    )
    result = reproduce(out, force=True, say=print, extra=[run], numbers=numbers)
    print("\nThe five numbers that matter (from synthetic files):")
    for value, words in numbers:
        print(f"  {value:>12}  {words}")
    counts = ", ".join(f"{count} {verdict}" for verdict, count in result.counts.items())
    print(f"\nThe paper's claims: {counts}")
    print(f"Open {result.report} (pictures in {out / 'figures'}).")
    print(f"Done in {time.perf_counter() - began:.0f} s.")


if __name__ == "__main__":
    demo(Path(sys.argv[1] if len(sys.argv) > 1 else "out/demo"))
