"""One measurement in files that differ in unit, sign, decimal sign and order of the columns."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from recorded.cases import answer, ask
from recorded.files import write_logs

Columns = dict[str, np.ndarray]
Asked = Callable[..., tuple[str, tuple[Any, ...], dict[str, Any]]]
QUESTIONS: dict[str, Asked] = {
    "leak.csv": lambda **how: ask("leak", "leak.csv", volume="0.2 l", temperature="25 degC", **how),
    "alone.csv": lambda **how: ask("pump-down", "alone.csv", volume="0.2 l", **how),
    "crash.csv": lambda **how: ask("crash", "crash.csv", hic="15 ms", **how),
    "silicone.csv": lambda **how: ask(
        "enclosure", ["silicone.csv"], area="20 mm^2", gauge_length="33 mm", **how
    ),
}
UNITS = {
    "time (s)": ("time (ms)", 1e3),
    "pressure (kPa abs)": ("pressure (mbar abs)", 10.0),
    "acceleration (g)": ("acceleration (m/s^2)", 9.80665),
    "extension (mm)": ("extension (um)", 1e3),
    "load (N)": ("load (kN)", 1e-3),
}
OWN = ("resolution", "quantum", "file ", "decimal", "columns", "units", "said.", "printed.")
"""Parts of keys whose values tell how a file is written."""


def read(path: Path) -> Columns:
    header, *rows = path.read_text("utf-8").splitlines()
    values = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    return dict(zip(header.split(","), values.T, strict=True))


def write(path: Path, columns: Columns, separator: str = ",", decimal: str = ".") -> None:
    rows = [separator.join(f"{v:.12g}" for v in row) for row in zip(*columns.values(), strict=True)]
    rows = [row.replace(".", decimal) for row in rows]
    path.write_text("\n".join([separator.join(columns), *rows, ""]), encoding="utf-8")


def in_other_units(path: Path) -> None:
    write(path, {UNITS[name][0]: values * UNITS[name][1] for name, values in read(path).items()})


def with_commas_and_turned_round(path: Path) -> None:
    write(path, dict(reversed(read(path).items())), separator=";", decimal=",")


def with_a_further_column(path: Path) -> None:
    columns = read(path)
    write(path, {"supply (V)": 12 + 0 * next(iter(columns.values())), **columns})


@pytest.mark.parametrize(
    "rewrite", [in_other_units, with_commas_and_turned_round, with_a_further_column]
)
@pytest.mark.parametrize("file", QUESTIONS)
def test_the_answer_is_the_same(
    file: str, rewrite: Callable[[Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_logs(tmp_path)
    plain = answer(QUESTIONS[file]())
    rewrite(tmp_path / file)
    check(answer(QUESTIONS[file]()), plain)


def test_a_machine_that_counts_the_other_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_logs(tmp_path)
    plain = answer(QUESTIONS["silicone.csv"]())
    path = tmp_path / "silicone.csv"
    for negative in (("force",), ("elongation",), ("force", "elongation")):
        names = [{"force": "load (N)", "elongation": "extension (mm)"}[one] for one in negative]
        columns = read(path)
        write(path, {n: -v if n in names else v for n, v in columns.items()})
        check(answer(QUESTIONS["silicone.csv"](negative=negative)), plain)
        write(path, columns)


def check(given: dict[str, Any], due: dict[str, Any]) -> None:
    """Compare two answers, except for what tells how a file is written."""
    assert "error" not in given | due
    numbers = {k: v for k, v in due.items() if not any(part in k for part in OWN)}
    assert len(numbers) > 5
    moved = {
        key: (given.get(key), value)
        for key, value in numbers.items()
        if (given.get(key) != value if isinstance(value, str)
            else given.get(key) != pytest.approx(value, rel=1e-6, abs=1e-12, nan_ok=True))
    }  # fmt: skip
    assert not moved
