"""Check 15: DuckDB and sqlite3 count the same samples of a run, and read the same values."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from bench.rig.checks.served import answered

pytestmark = pytest.mark.slow
COUNTS = "count(*), count(*) - (max(seq) - min(seq) + 1), min(seq), max(seq), min(boot), max(boot)"


def test_15_duckdb_counts_what_sqlite3_counts(
    tmp_path: Path, tool: Callable[[str], str], figure: Callable[[str], None]
) -> None:
    """DuckDB reads SQLite only with an extension that it fetches, so it reads the export."""
    duckdb = pytest.importorskip(
        "duckdb", reason="DuckDB is not installed: `make bench-checks` installs it"
    )
    run, table = tmp_path / "x.ljrun", tmp_path / "x.parquet"
    made = answered(
        *("bench", "log", "sim:choi2018?speed=20&noise=50Pa"),
        *("--duration", "60s", "--out", str(run), "--json"),
    )
    answered("bench", "export", str(run), "--out", str(table), "--json")
    text = subprocess.run(
        [tool("sqlite3"), "-readonly", str(run), f"select {COUNTS} from samples"],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    [theirs] = duckdb.sql(f"select {COUNTS} from '{table}'").fetchall()
    assert "|".join(map(str, theirs)) == text.strip()
    assert theirs[0] == made["samples"] >= 6000 and theirs[1] == 0
    values = subprocess.run(
        [tool("sqlite3"), "-readonly", str(run),
         "select seq, printf('%.9g', vacuum), raw, fault from samples order by seq"],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    columns = "seq, printf('%.9g', vacuum), raw, fault"
    rows = duckdb.sql(f"select {columns} from '{table}' order by seq").fetchall()
    assert ["|".join(map(str, row)) for row in rows] == values.split()
    figure(f"15  DuckDB and sqlite3 on {theirs[0]} samples: equal counts and values, 0 missing")
