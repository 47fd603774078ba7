"""Files for the records: a run as a bench leaves it, pulls, a brake that was calibrated on them."""

from __future__ import annotations

import contextlib
import io
import json
import sqlite3
from pathlib import Path
from typing import Any

from layerjam.bench.rig.run_file import RunFile
from layerjam.brake.device.load import load
from layerjam.brake.fluid.line_file import load_line
from layerjam.cli.main import main

BRAKE, LINE = load("choi2018-kapton"), load_line("choi2018")


def run_file(path: Path, *, lost: int = 0, **said: str) -> Path:
    """A closed run of 20 samples in two starts of the board, of which `lost` are missing."""
    meta = {
        "run_id": "7e0a0000-0000-4000-8000-000000000001",
        "outcome": "FINISHED",
        "simulated": "0",
        "board": "E661-1",
        "model": "layerjam bench",
        "firmware": "1.0",
        "sensor_calibration": '12.5,1.01,"2026-03"',
        "zero": "0,9.91E37",
        "brake_toml": BRAKE.render(BRAKE.name),
        "line_toml": LINE.render(LINE.name),
        "procedure": "evacuate to 40 kPa; vent",
        "safe_state": "release",
        "settings_hex": "00ff",
        **said,
    }
    outcome = meta.pop("outcome")
    file = RunFile.create(path, meta)
    rows = [
        (boot, seq, 10_000 * seq, 4e4, 4e4, 0, None, 255, 0, 1, 0)
        for boot in (7, 9)
        for seq in range(10)
        if boot == 9 or not 2 < seq <= 2 + lost
    ]
    file.add_samples(rows)
    file.close(outcome)
    return path


def pull_file(path: Path, force: float = 40.0, synthetic: bool = False) -> Path:
    """A pull of a few samples."""
    marked = "# synthetic\n" if synthetic else ""
    rows = "\n".join(f"{i},{i},{force * i / 5}" for i in range(6))
    text = f"# layerjam measurement\n{marked}time [s],elongation [mm],force [N]\n{rows}\n"
    path.write_text(text, encoding="utf-8", newline="\n")
    return path


def tables(db: Path) -> dict[str, list[tuple[Any, ...]]]:
    """Every row of every table and view, as a stranger reads it."""
    with contextlib.closing(sqlite3.connect(db)) as base:
        listed = "SELECT name FROM sqlite_master WHERE type IN ('table', 'view')"
        names = [name for (name,) in base.execute(listed)]
        assert base.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        assert base.execute("PRAGMA foreign_key_check").fetchall() == []
        return {name: sorted(base.execute(f"SELECT * FROM {name}"), key=repr) for name in names}


def said(*words: object) -> tuple[int, dict[str, Any]]:
    """Exit code and JSON of a command."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = main(["records", *map(str, words), "--json"])
    return code, json.loads(out.getvalue()) if out.getvalue() else {}
