"""Faulty logs and files in other layouts: found, asked about or read right; into docs/coverage.md.

The files are those of tests/independent/chamber.py and field_files.py, which share no code with the
product. Each campaign has its own random numbers.

    python tests/log_faults.py [--campaigns N] [--seed S] [--only WORD] [--write]
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import layerjam as lj
from independent import field_files as made
from independent.chamber import ATMOSPHERE, Chamber, draw
from layerjam.core.errors import FileError, QuantityError

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
MARKS = ("<!-- faulty logs: begin -->", "<!-- faulty logs: end -->")
CAMPAIGNS, SEED = 300, 48
ALARMS, FINDS = 0.025, 0.95
Random = np.random.Generator
OUTCOMES = ("right", "named", "warned", "failed", "asked", "wrong")


@dataclass(frozen=True, kw_only=True)
class Row:
    """A kind of file: how it is written, the command, its right answer, and how it may end.

    `write` returns the right answer {key: (value, relative tolerance)}; `ends` are the outcomes
    that count as found. A healthy file must be right.
    """

    name: str
    command: Callable[..., Any]
    write: Callable[[Path, Random, int], Mapping[str, tuple[float, float]]]
    ends: tuple[str, ...] = ("right",)
    options: Mapping[str, Any] | None = None
    word: str = ""
    """Part of how the file was read that names the fault."""

    @property
    def healthy(self) -> bool:
        return self.name.startswith("healthy")


def log(
    command: str,
    share: float = 0.0,
    kind: str | None = None,
    keep: Callable[[Random, Any], Any] | None = None,
    turn: float = 1.0,
    head: str | None = None,
) -> Callable[[Path, Random, int], Mapping[str, tuple[float, float]]]:
    """Return a writer of pressure logs; `share` is a zero error relative to the vacuum."""

    def write(path: Path, random: Random, number: int) -> Mapping[str, tuple[float, float]]:
        given: dict[str, Any] = {} if kind is None else {"kind": kind}
        if command == "pump_down":
            pump = random.uniform(2, 6)
            given |= {"pump": pump, "pumped": 8 * pump, "held": 0.0}
        chamber: Chamber = draw(random, leak=random.uniform(100, 600), **given)
        vacuum = ATMOSPHERE - chamber.ultimate
        chamber = replace(chamber, zero=share * vacuum * (1 if chamber.kind == "vacuum" else -1))
        time, reading = chamber.record(number)
        mask = slice(None) if keep is None else keep(random, time - chamber.vented)
        chamber.write(path, number, mask)
        if head is not None:
            made.csv(path, head, time[mask], turn * reading[mask], form="%.5f")
        if command == "leak":
            return {"time_constant": (chamber.leak, 0.05)}
        return {"time_constant": (chamber.pump, 0.05), "ultimate_vacuum": (1e3 * vacuum, 0.02)}

    return write


def lose(random: Random, time: Any) -> Any:
    """Return the samples of a log of which a tenth is missing in one piece, after 8 s."""
    kept = np.ones(len(time), bool)
    first = int(np.searchsorted(time, 8.0)) + int(random.integers(1, len(time) // 3))
    kept[first : first + len(time) // 10] = False
    return kept


def impact(
    lost: int = 0,
    jitter: float = 0.0,
    rest: float = 0.0,
    head: str = "Time (s),Acceleration (g)",
    factor: float = 1.0,
) -> Callable[[Path, Random, int], Mapping[str, tuple[float, float]]]:
    """Return a writer of impacts of which `lost` samples of the pulse are missing."""

    def write(path: Path, random: Random, number: int) -> Mapping[str, tuple[float, float]]:
        height = random.uniform(10, 80)
        time, value = made.impact(height=height, seed=number)
        shaken = time + jitter * 1e-4 * random.uniform(-1, 1, len(time))
        inside = (shaken >= 0.02) & (shaken <= 0.04)
        value += np.where(inside, height * np.sin(np.pi * (shaken - 0.02) / 0.02), 0.0)
        inside = (time >= 0.02) & (time <= 0.04)
        value -= np.where(inside, height * np.sin(np.pi * (time - 0.02) / 0.02), 0.0)
        kept = np.ones(len(time), bool)
        first = int(random.integers(230, 370))
        kept[first : first + lost] = False
        form = "%.8g" if jitter else "%.7g"
        made.csv(path, head, shaken[kept], factor * (value + rest)[kept], form=form)
        change = 2 / np.pi * 0.02 * height * made.G
        return {"peak": (height * made.G, 0.01), "velocity_change": (change, 0.02)}

    return write


def silicone(head: str, change: Callable[[Any], Any]) -> Any:
    def write(path: Path, random: Random, number: int) -> Mapping[str, tuple[float, float]]:
        scale = random.uniform(0.5, 3)
        strain, stress = made.specimen(to=random.uniform(3.05, 5))
        stress = scale * stress + 0.05 * random.standard_normal(len(stress))
        made.csv(path, head, change(strain), stress, form="%.6f")
        return {"modulus_100": (scale * 87.5e3, 0.02)}

    return write


def cycles(path: Path, random: Random, number: int) -> Mapping[str, tuple[float, float]]:
    columns = made.load_cycles(int(random.integers(2, 12)), random.uniform(0.1, 0.5))
    made.csv(path, "Time (s),Extension (mm),Load (N)", *columns, form="%.4f")
    return {"stick_slip": (0.0, 0.0), "stiffness": (50e3, 0.01)}


def enclosure(path: Path, **options: Any) -> Any:
    return lj.enclosure(path, **options)


G_AS_GIVEN = {"options": {"columns": "time:s=Time,acceleration:g=Acceleration"}}
ROWS = (
    Row(name="healthy leak", command=lj.leak, write=log("leak")),
    Row(name="healthy pump-down", command=lj.pump_down, write=log("pump_down")),
    Row(name="healthy impact", command=lj.crash, write=impact()),
    Row(name="healthy specimen of silicone", command=enclosure,
        write=silicone("Strain [-],Stress [kPa]", lambda e: e)),
    Row(name="leak: vacuum counted negative", command=lj.leak, ends=("right", "asked"),
        write=log("leak", kind="vacuum", turn=-1.0, head="Time (s),Vacuum (kPa)")),
    Row(name="leak: absolute pressure called vacuum", command=lj.leak, ends=("failed", "asked"),
        write=log("leak", kind="absolute", head="Time (s),Vacuum (kPa)")),
    Row(name="pump-down: absolute pressure called vacuum", command=lj.pump_down,
        ends=("right", "asked"),
        write=log("pump_down", kind="absolute", head="Time (s),Vacuum (kPa)")),
    *(
        Row(name=f"{name}: zero of the gauge {share:+.0%} of the vacuum", command=command,
            write=log(made_as, share, kind="gauge"), ends=ends)
        for name, command, made_as in (
            ("leak", lj.leak, "leak"), ("pump-down", lj.pump_down, "pump_down"),
        )
        for share, ends in (
            (0.04, ("warned",)), (-0.04, ("warned",)), (0.14, ("failed", "asked")),
            (-0.14, ("failed", "asked")),
        )
    ),
    Row(name="leak: a tenth of the samples missing", command=lj.leak, write=log("leak", keep=lose),
        ends=("named",), word="missing after"),
    Row(name="impact: one sample of the pulse missing", command=lj.crash, write=impact(lost=1),
        ends=("warned",)),
    Row(name="impact: ten samples of the pulse missing", command=lj.crash, write=impact(lost=10),
        ends=("failed",)),
    Row(name="impact: ten samples missing, one rate stated", command=lj.crash,
        write=impact(lost=10), options={"sampling": 10e3}, ends=("asked",)),
    Row(name="impact: stamps with 4 % of jitter", command=lj.crash, write=impact(jitter=0.04)),
    Row(name="impact: at rest, but said to fall", command=lj.crash, write=impact(rest=1.0),
        options={"falling": True}, ends=("warned", "failed")),
    Row(name="impact: mG, said to be g", command=lj.crash, ends=("right", "asked"),
        write=impact(head="Time (s),Acceleration (mG)", factor=1e3), options=G_AS_GIVEN),
    Row(name="pull: load cycles of the crosshead", command=lj.pull, write=cycles),
    Row(name="silicone: stretch ratio", command=enclosure, ends=("right", "asked"),
        write=silicone("Stretch [-],Stress [kPa]", lambda e: 1 + e)),
    Row(name="silicone: strain that starts at 1", command=enclosure, ends=("right", "asked"),
        write=silicone("Strain [-],Stress [kPa]", lambda e: 1 + e)),
)  # fmt: skip


def find_outcome(row: Row, path: Path, right: Mapping[str, tuple[float, float]]) -> str:
    """Return how a command ends, one of OUTCOMES."""
    try:
        found = row.command(path, **(row.options or {}))
    except (FileError, QuantityError):
        return "asked"
    levels = {check["level"] for check in getattr(found, "checks", ())}
    if "failed" in levels or found.exit_code == 4:
        return "failed"
    if row.word and any(row.word in line for line in found.understood):
        return "named"
    values = found.pulls[0] if row.command is lj.pull else found.values
    close = all(
        abs(float(values[key]) - value) <= within * abs(value)
        for key, (value, within) in right.items()
    )
    if "warning" in levels and ("warned" in row.ends or not close):
        return "warned"
    return "right" if close else "wrong"


def measure(row: Row, campaigns: int, seed: int, folder: Path) -> Counter[str]:
    """Return the number of campaigns with each outcome."""
    found: Counter[str] = Counter()
    for number in range(campaigns):
        random = np.random.Generator(np.random.PCG64([seed, number, *row.name.encode()]))
        path = folder / "file.csv"
        found[find_outcome(row, path, row.write(path, random, number))] += 1
    return found


def is_right(row: Row, found: Counter[str]) -> bool:
    """Whether the shares are those required, within the chance of three standard errors."""
    count, least = found.total(), 1 - ALARMS if row.healthy else FINDS
    share = sum(found[end] for end in row.ends) / count
    return share >= least - 3 * (least * (1 - least) / count) ** 0.5


def line(row: Row, found: Counter[str]) -> str:
    count = found.total()
    shares = (f"{found[end] / count:.1%}" if found[end] else "–" for end in OUTCOMES)
    return f"| {row.name} | {count} | {' | '.join(shares)} |"


def write(lines: list[str], campaigns: int, seed: int) -> None:
    """Write the section into docs/coverage.md."""
    before, rest = PAGE.read_text(encoding="utf-8").split(MARKS[0])
    made_text = f"""{MARKS[0]}

`python tests/log_faults.py --campaigns {campaigns} --seed {seed} --write` writes this table:

| file | number | {" | ".join(OUTCOMES)} |
|---|---|{"---|" * len(OUTCOMES)}
{chr(10).join(lines)}

{MARKS[1]}"""
    PAGE.write_text(before + made_text + rest.split(MARKS[1])[1], encoding="utf-8")


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", default="", help="word in the name of a row")
    parser.add_argument("--write", action="store_true", help="write docs/coverage.md")
    given = parser.parse_args()
    lines, wrong = [], []
    with tempfile.TemporaryDirectory() as folder:
        for row in ROWS:
            if given.only in row.name:
                count = given.campaigns if row.healthy else -(-given.campaigns // 3)
                found = measure(row, count, given.seed, Path(folder))
                lines.append(line(row, found))
                print(lines[-1], flush=True)
                wrong += [row.name] * (not is_right(row, found))
    if given.write:
        write(lines, given.campaigns, given.seed)
    if wrong:
        sys.exit(f"not as required: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
