"""`stick-slip` at the command line: keys, files, bad input."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Run

PULL = ("stick-slip", "choi2018-kapton", "--vacuum", "94.5kPa", "--json")
KEYS = {
    "amplitude": "N", "relative_amplitude": "1", "force_high": "N", "force_low": "N",
    "slip_per_event": "m", "period": "s", "critical_speed": "m/s",
}  # fmt: skip


def test_kapton_judders_at_a_millimetre_a_second(run: Run) -> None:
    ran = run(*PULL, "--speed", "1mm/s", "--elongation", "4mm")
    found = ran.json
    assert (ran.code, ran.err, found["outcome"]) == (0, "", "JUDDERS")
    for key, unit in KEYS.items():
        assert found["units"][key] == unit and key in found
    assert found["amplitude"] > 50 and found["critical_speed"] is None
    assert len(found["warnings"]) >= 3


def test_files(run: Run, tmp_path: Path) -> None:
    out, figure = tmp_path / "run.csv", tmp_path / "run.svg"
    words = (
        *PULL, "--speed", "1mm/s", "--elongation", "3mm", "--damping", "5 N s/m",
        "--mount-stiffness", "200kN/m", "--mass", "30 g", "--slip", "10mm", "--static", "0.3",
        "--out", str(out), "--figure", str(figure),
    )  # fmt: skip
    assert run(*words).code == 0
    text = out.read_text()
    assert "# static friction: 0.3" in text and "synthetic" in text
    assert figure.read_text().lstrip().startswith("<?xml")
    again = run(*words)
    assert again.code == 2 and "already exists" in again.err


@pytest.mark.parametrize(
    "words",
    [
        ("--speed", "1"),
        ("--speed", "1mm/s", "--damping", ""),
        ("--speed", "1mm/s", "--damping", "5"),
        ("--speed", "1mm/s", "--static", "0.1"),
        ("--speed", "1mm/s", "--static", "much"),
        ("--speed", "1mm/s", "--slip", "68mm"),
        ("--speed", "1mm/s", "--mass", "0 g"),
        ("--speed", "1mm/s", "--out", "run.txt"),
    ],
)
def test_bad_input(refuses: Callable[..., str], words: tuple[str, ...]) -> None:
    refuses(*PULL, *words)
