"""Zeros of gauges and gaps in logs: `leak` and `pump-down` against a chamber of the tests' own."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from independent.chamber import ATMOSPHERE, Chamber, draw
from layerjam.cli.main import main
from layerjam.core.errors import FileError

COMMANDS = {"leak": lj.leak, "pump-down": lj.pump_down}


def healthy(command: str, number: int) -> Chamber:
    random = np.random.default_rng([48, number])
    if command == "leak":
        return draw(random)
    pump = random.uniform(2, 6)
    return draw(random, pump=pump, pumped=8 * pump, held=0.0)


def gap(chamber: Chamber) -> float:
    """Reading [kPa] per kPa of vacuum at the ultimate pressure."""
    return (ATMOSPHERE - chamber.ultimate) * (1 if chamber.kind == "vacuum" else -1)


def find_row(found: Any, name: str = "zero") -> Any:
    [row] = [row for row in found.checks if row["name"] == name]
    return row


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    ("share", "level"), [(0.0, "passed"), (0.05, "warning"), (-0.05, "warning"), (-0.2, "failed")]
)
def test_zero_of_a_gauge_is_found_and_the_remedy_works(
    tmp_path: Path, command: str, share: float, level: str
) -> None:
    for number in range(6):
        chamber = healthy(command, number)
        chamber = replace(chamber, zero=share * gap(chamber))
        path = chamber.write(tmp_path / f"{number}.csv", number)
        if chamber.kind == "vacuum" and chamber.record(number)[1].min() < -5:
            with pytest.raises(FileError, match=r"check the sensor's zero[^(]*$"):
                COMMANDS[command](path)
            continue
        found = COMMANDS[command](path)
        row = find_row(found)
        assert row["level"] == level, row
        assert found.exit_code == (4 if level == "failed" else 0)
        if level == "passed":
            continue
        [(option, value)] = re.findall(r"(--zero|--atmosphere) (-?\d+Pa)", row["sentence"])
        assert (option == "--atmosphere") == (chamber.kind == "absolute")
        assert main([command, str(path), option, value]) == 0
        again = COMMANDS[command](path, **{option[2:]: value})
        assert find_row(again)["passed"]
        if command == "leak":
            assert again.time_constant_low < chamber.leak < again.time_constant_high
            error = abs(found.time_constant / chamber.leak - 1)
            assert error > abs(again.time_constant / chamber.leak - 1)
        else:
            vacuum = 1e3 * (ATMOSPHERE - chamber.ultimate)
            assert again.ultimate_vacuum == pytest.approx(vacuum, rel=0.01)


@pytest.mark.parametrize("command", COMMANDS)
def test_log_that_does_not_begin_vented_shows_no_zero(tmp_path: Path, command: str) -> None:
    for number in range(6):
        chamber = healthy(command, number)
        start = chamber.vented + (chamber.pumped if command == "leak" else 0.1 * chamber.pump)
        keep = chamber.record(number)[0] >= start
        found = COMMANDS[command](chamber.write(tmp_path / "log.csv", number, keep))
        assert "zero" not in {row["name"] for row in found.checks}


@pytest.mark.parametrize("command", COMMANDS)
def test_gaps_are_named_and_do_not_change_the_result(tmp_path: Path, command: str) -> None:
    for number in range(4):
        chamber = replace(healthy(command, number), rate=10.0)
        whole = COMMANDS[command](chamber.write(tmp_path / "whole.csv", number))
        assert not [line for line in whole.understood if "missing" in line]
        time, _ = chamber.record(number)
        keep = np.ones(len(time), bool)
        first = int(np.flatnonzero(time > chamber.vented + chamber.pumped / 2)[0])
        keep[first : first + 7] = keep[-12] = False
        found = COMMANDS[command](chamber.write(tmp_path / "gaps.csv", number, keep))
        lines = [line for line in found.understood if "missing" in line]
        assert lines == [
            f"7 samples are missing after {time[first - 1]:.6g} s",
            f"1 sample is missing after {time[-13]:.6g} s",
        ]
        assert all(line in " ".join(str(found).split()) for line in lines)
        assert found.rate_low < whole.rate < found.rate_high
    keep[1::5] = False
    found = COMMANDS[command](chamber.write(tmp_path / "many.csv", number, keep))
    assert re.fullmatch(r"\d+ more gaps", found.understood[-1])
