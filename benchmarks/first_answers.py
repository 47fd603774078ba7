"""Processor time of first answers: whole processes with empty caches, then again, beside SciPy.

Each is divided by the time of a script that computes the README's lines with SciPy, of the same
round. Run alone: `python -m benchmarks.first_answers`; `--only force` times what has that name.
"""

from __future__ import annotations

import argparse
import re
import statistics
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from benchmarks.comparators import tuned_scipy
from benchmarks.timing import README, Row, cpu, table

ROUNDS = 3
PROGRAM = str(Path(sys.executable).with_name("layerjam"))
SCRIPT = (sys.executable, tuned_scipy.__file__)
BRAKE = "choi2018-kapton"
STOP = (BRAKE, "--mass", "1kg", "--speed", "2.5m/s", "--travel", "40mm")


@dataclass(frozen=True)
class Answer:
    """A process that a user starts; `aim` is the most that it may cost, over the script's time."""

    name: str
    words: tuple[str, ...]
    aim: float = 1.5
    long: bool = False
    """Whether it takes so long that it is run in one round only."""


ANSWERS = (
    Answer("README's lines of Python", (sys.executable, "-c", README), 1.0),
    Answer("force", (PROGRAM, "force", BRAKE, "--slip", "20mm", "--vacuum", "94.5kPa")),
    Answer("vacuum", (PROGRAM, "vacuum", BRAKE, "--slip", "20mm", "--force", "100N")),
    Answer("tune", (PROGRAM, "tune", *STOP)),
    Answer("drop --vacuum tuned", (PROGRAM, "drop", *STOP, "--vacuum", "tuned")),
    Answer("show", (PROGRAM, "show", BRAKE)),
    Answer(
        "build", (PROGRAM, "build", BRAKE, "--coupons", "--overwrite", "--out", "parts"), 8, True
    ),
    # 60 and 80 s where the script took 1.4 and 1.2 s
    Answer("reproduce", (PROGRAM, "reproduce", "--overwrite", "--out", "paper"), 43.0, True),
    Answer("demo", (PROGRAM, "demo"), 65.0, True),
)


def rows(only: str = "") -> list[Row]:
    """Medians of rounds in which the script and every answer take turns."""
    chosen = [answer for answer in ANSWERS if re.search(only, answer.name)]
    script: list[float] = []
    times: dict[tuple[str, str], list[float]] = {}
    for round_ in range(ROUNDS):
        with tempfile.TemporaryDirectory() as folder:
            script.append(cpu(SCRIPT, Path(folder)))
        for answer in chosen:
            if answer.long and round_:
                continue
            with tempfile.TemporaryDirectory() as folder:
                for caches in ("empty caches", "again"):
                    spent = cpu(answer.words, Path(folder))
                    times.setdefault((answer.name, caches), []).append(spent)
    other = statistics.median(script)
    return [
        Row(f"{answer.name}, {caches}", statistics.median(times[answer.name, caches]),
            other=other, other_name="SciPy script", target_ratio=answer.aim)
        for answer in chosen for caches in ("empty caches", "again")
    ]  # fmt: skip


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="only what matches this expression")
    print(table(rows(parser.parse_args().only)))


if __name__ == "__main__":
    main()
