"""Memory of the workbench under files as large as it takes: dropped, used, removed, and again.

Run alone: `python -m benchmarks.uploads [ROUNDS]`. A round takes about eight minutes.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

from benchmarks.first_page import at, started
from benchmarks.timing import Row, table
from benchmarks.workbench import memory, pull_ready
from layerjam.brake.commands.tensile import tensile
from layerjam.workbench.uploads import LARGEST

ROUNDS = 3
VACUUMS = (60, 70, 80, 90, 94)
"""kPa of one file each."""
ROWS = 2_000_000
"""Samples of a file, 27 to 28 bytes each."""
LONG = 600_000
IDLE = 30
"""Seconds after which the server idles, if it computes a while longer than is shown."""


def pulls(folder: Path) -> list[Path]:
    """Pulls over 30 mm with noise, each just below what the page takes."""
    made = []
    for vacuum in VACUUMS:
        record = tensile(
            "choi2018-kapton", vacuum=f"{vacuum} kPa", speed="1 mm/s", travel="30 mm"
        ).record
        x = np.linspace(0.0, 0.03, ROWS)
        force = np.interp(x, record.elongation, record.force)
        force += np.random.default_rng(vacuum).normal(0.0, 0.05, ROWS)
        columns = zip(1e3 * x, 1e3 * x, force, strict=True)  # at 1 mm/s a second is a millimetre
        place = folder / f"pull_{vacuum}kPa.csv"
        lines = "\n".join(f"{t:.6f},{mm:.6f},{newton:.4f}" for t, mm, newton in columns)
        place.write_text(f"Time (s),Extension (mm),Load (N)\n{lines}\n", encoding="utf-8")
        if not 0.85 * LARGEST < place.stat().st_size <= LARGEST:
            raise RuntimeError(f"{place.name} has {place.stat().st_size} bytes")
        made.append(place)
    return made


def used(page: Any, files: list[Path]) -> None:
    """Dropped, accepted, and computed with on both pages that take pulls."""
    page.locator(".files-dropped input[type=file]").first.set_input_files(files)
    all_of_them = f"document.querySelectorAll('{at('dropped-file')}').length === {len(files)}"
    page.wait_for_function(all_of_them, timeout=LONG)
    page.click(at("dropped-use"))
    page.click(at("tab-pull"))
    page.wait_for_selector(at("pull-errors"), timeout=LONG)
    page.click(at("tab-laboratory"))
    page.wait_for_selector(f"{at('laboratory-calibrate')} .figure svg", timeout=LONG)


def removed(page: Any) -> None:
    """One after the other, on the page of pulls."""
    page.click(at("tab-pull"))
    gone = page.locator(at("pull-file-remove"))
    gone.first.wait_for(timeout=LONG)
    for left in reversed(range(gone.count())):
        gone.first.click()
        page.wait_for_function(
            f"document.querySelectorAll('{at('pull-file-remove')}').length === {left}", timeout=LONG
        )


def most(process: int) -> float:
    """GB that a process has held at most since this was asked last."""
    lines = Path(f"/proc/{process}/status").read_text(encoding="utf-8").splitlines()
    found = next(float(line.split()[1]) for line in lines if line.startswith("VmHWM:"))
    Path(f"/proc/{process}/clear_refs").write_text("5", encoding="utf-8")
    return found * 1024 / 1e9


def rows(rounds: int = ROUNDS) -> list[Row]:
    """What the server holds, round by round."""
    out = []
    with (
        tempfile.TemporaryDirectory() as folder,
        sync_playwright() as play,
        started() as (place, process, _),
    ):

        def seen(what: str, size: float, limit: float | None = None) -> None:
            out.append(Row(what, size, limit, unit="GB"))
            print(f"{what}: {size:.2f} GB", file=sys.stderr, flush=True)

        files = pulls(Path(folder))
        chromium = shutil.which("chromium")
        page = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"]).new_page()
        page.goto(place)
        page.click(at("tab-pull"))
        pull_ready(page)
        for k in range(1, rounds + 1):
            used(page, files)
            seen(f"round {k}, at most", most(process))
            page.wait_for_timeout(1e3 * IDLE)
            seen(f"round {k}, idle, the files there", memory(process))
            removed(page)
            page.wait_for_timeout(1e3 * IDLE)
            seen(f"round {k}, idle, the files gone", memory(process))
    return out


if __name__ == "__main__":
    print(table(rows(*map(int, sys.argv[1:]))))
