"""Files for the records: a run as a bench leaves it, pulls, a brake that was calibrated on them."""

from __future__ import annotations

import sqlite3
from pathlib import Path

from layerjam.device.load import load
from layerjam.fluid.file import load_line

BRAKE, LINE = load("choi2018-kapton"), load_line("choi2018")
SCHEMA = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT);
CREATE TABLE samples (
  boot INTEGER, seq INTEGER, board_us INTEGER, vacuum REAL, target REAL, raw INTEGER,
  temperature INTEGER, pump INTEGER, flags INTEGER, state INTEGER, fault INTEGER,
  PRIMARY KEY (boot, seq)
) WITHOUT ROWID;
"""


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
        "brake_toml": BRAKE.rendered(BRAKE.name),
        "line_toml": LINE.rendered(LINE.name),
        "procedure": "evacuate to 40 kPa; vent",
        "safe_state": "release",
        "settings_hex": "00ff",
        **said,
    }
    base = sqlite3.connect(path)
    base.execute(f"PRAGMA application_id = {0x4C4A5255}")
    base.execute("PRAGMA user_version = 1")
    base.executescript(SCHEMA)
    base.executemany("INSERT INTO meta VALUES (?, ?)", meta.items())
    rows = [
        (boot, seq, 10_000 * seq, 4e4, 4e4, 0, None, 255, 0, 1, 0)
        for boot in (7, 9)
        for seq in range(10)
        if boot == 9 or not 2 < seq <= 2 + lost
    ]
    base.executemany(f"INSERT INTO samples VALUES ({', '.join('?' * 11)})", rows)
    base.commit()
    base.close()
    return path


def pull_file(path: Path, force: float = 40.0, synthetic: bool = False) -> Path:
    """A pull of a few samples."""
    marked = "# synthetic\n" if synthetic else ""
    rows = "\n".join(f"{i},{i},{force * i / 5}" for i in range(6))
    path.write_text(f"# layerjam measurement\n{marked}time [s],elongation [mm],force [N]\n{rows}\n")
    return path
