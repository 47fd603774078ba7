"""Do the tests notice a random change of the code that computes numbers? One change at a time.

Draws a new sample from the present source each time, runs the quick tests that execute the changed
line, and prints the share that is noticed with its 95 % interval (Wilson).

- A mutant is a copy of the tree in a temporary folder; the working tree is never touched.
- Tests that execute the line come first, the nearest and fastest of them first, at most LONGEST
  seconds of processor time by the record. Up to EXTRA of these are for other tests of the file.
- A mutant that passes these counts as unnoticed. A failure counts if the same test passes on an
  unchanged copy; an endless loop, if the same tests end there in a quarter of the limit.
- Files of C that are printed from Python are printed again after a change of Python, and the tests
  that compare them with it are left out: they notice a changed comment as well.

Why no tool of others (looked up in November 2026): mutmut 3 forks a process that has imported the
tested code, after which JAX may have threads, and changes functions of Python only. cosmic-ray 8
writes each mutant into the file in place and runs one and the same command for each, without a
coverage map. Neither draws a sample with an interval, nor changes C.

Usage: python tests/mutants.py [--sample N] [--seed S] [--only TEXT] [--json FILE] [--again FILE]
"""

from __future__ import annotations

import argparse
import collections
import difflib
import json
import math
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from mutant_draw import FOLDERS, ROOT, Mutant, draw, mutate, read_sources
from mutant_farm import Farm, Result
from mutant_map import Map, record

LONGEST, EXTRA = 20.0, 8.0
"""Tests for one mutant, by the processor time of the record [s]."""
NOTICED = ("failed", "endless")
EQUIVALENT = {
    ("energy.py", "return (heat)"): "negative slip or vacuum is NaN by safe_sqrt already",
    (
        "hysteresis.py",
        "slack=(state.force <= (1)) & (target < enclosure.slip),",
    ): "a force above zero means an elongation beyond the slip",
    (
        "hysteresis.py",
        "returns = (0.0) < memory.force - hold",
    ): "the root is clipped to the present slip, so that nothing moves",
    ("hysteresis.py", "returns = (trial) < memory.force - hold"): "as above",
    (
        "workbook.py",
        'f"unpacks to {size / 1e6:.0f} MB; at most {MAX_UNPACKED / (1000001.0):.0f} MB can be "',
    ): "250 000 000 bytes are 250 MB with either divisor, to the digits shown",
    (
        "paced_tune.py",
        "excess = case[0] * result.end_speed**(3) / 2 / force + CLOSE * slip",
    ): "a search for the slip, whose end is the same for any rising measure",
}
"""Mutants that compute the same numbers: {(file, changed line): reason}; they are not drawn."""


def wilson(part: int, whole: int) -> tuple[float, float]:
    """Return the 95 % interval of a share."""
    if not whole:
        return 0.0, 1.0
    z, share = 1.959964, part / whole
    middle = share + z * z / (2 * whole)
    half = z * math.sqrt(share * (1 - share) / whole + z * z / (4 * whole**2))
    return (middle - half) / (1 + z * z / whole), (middle + half) / (1 + z * z / whole)


def difference(mutant: Mutant, source: str) -> str:
    changed = mutant.apply(source).splitlines()
    lines = difflib.unified_diff(source.splitlines(), changed, lineterm="", n=0)
    return "\n".join(line for line in lines if not line.startswith(("---", "+++", "@@")))


def summarize(results: Sequence[Result], sources: dict[str, str]) -> dict[str, Any]:
    """Return the share that was noticed, with its interval and by folder, and the survivors."""
    counts = {folder: [0, 0] for folder in FOLDERS}
    for one in results:
        counts[one.mutant.folder][0] += one.outcome in NOTICED
        counts[one.mutant.folder][1] += 1
    noticed = sum(part for part, _ in counts.values())
    return {
        "noticed": noticed,
        "all": len(results),
        "interval": wilson(noticed, len(results)),
        "folders": counts,
        "outcomes": collections.Counter(one.outcome for one in results),
        "survivors": [
            {
                "file": one.mutant.file,
                "line": one.mutant.line,
                "start": one.mutant.start,
                "text": one.mutant.text,
                "difference": difference(one.mutant, sources[one.mutant.file]),
                "tests": one.tests,
                "outcome": one.outcome,
            }
            for one in sorted(results, key=lambda one: one.mutant)
            if one.outcome not in NOTICED
        ],
    }


def show(report: dict[str, Any]) -> None:
    for one in report["survivors"]:
        print(f"\n{one['outcome']}, {one['tests']} tests: src/layerjam/{one['file']}:{one['line']}")
        print(one["difference"])
    print()
    for folder, (part, whole) in report["folders"].items():
        print(f"{folder:22} {part:4} of {whole:4} noticed")
    low, high = report["interval"]
    print(", ".join(f"{count} {outcome}" for outcome, count in report["outcomes"].items()))
    print(
        f"{report['noticed']} of {report['all']} mutants noticed, "
        f"{report['noticed'] / max(1, report['all']):.1%} (95 %: {low:.1%} to {high:.1%}), "
        f"seed {report['seed']}, head {report['head']}, {report['seconds']:.0f} s"
    )


def select_mutants(args: argparse.Namespace, sources: dict[str, str]) -> list[Mutant]:
    mutants = [
        one for one in mutate(sources) if any(part in one.file for part in args.only.split(","))
    ]
    if args.again:
        kept = json.loads(Path(args.again).read_text("utf-8"))["survivors"]
        known = {(one["file"], one["difference"]) for one in kept}
        files = {file for file, _ in known}
        return [
            one for one in mutants
            if one.file in files and (one.file, difference(one, sources[one.file])) in known
        ]  # fmt: skip
    names = {name for name, _ in EQUIVALENT}
    mutants = [
        one for one in mutants
        if Path(one.file).name not in names
        or (Path(one.file).name, one.changed_line(sources[one.file])) not in EQUIVALENT
    ]  # fmt: skip
    return draw(mutants, args.sample, args.seed)


def read_map(args: argparse.Namespace) -> Map:
    """Return the coverage map; make it, or the part of new and changed tests, first."""
    if args.map:
        record(["tests"], args.jobs)
    coverage = Map.read()
    new = coverage.new_files()
    if new and not args.stale:
        print(f"recording what {len(new)} new or changed files of tests execute", flush=True)
        record(new, args.jobs)
        coverage = Map.read()
    return coverage


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--sample", type=int, default=200, help="number of mutants")
    parser.add_argument("--seed", type=int, default=random.randrange(10**6))
    parser.add_argument("--only", default="", help="parts of paths: mechanics/pull,fluid/")
    parser.add_argument("--json", help="file for the result")
    parser.add_argument("--again", help="such a file: try its survivors again")
    parser.add_argument("--map", action="store_true", help="record the coverage of all tests again")
    parser.add_argument("--stale", action="store_true", help="record no coverage of new tests")
    parser.add_argument("--jobs", type=int, choices=(1, 2), default=2)
    return parser.parse_args()


def try_all(farm: Farm, mutants: Sequence[Mutant], coverage: Map) -> list[Result]:
    """Return the results so far if Ctrl-C or SIGTERM ends the run."""
    results = []

    def attempt(mutant: Mutant) -> Result | None:
        return None if farm.stopped.is_set() else farm.try_out(mutant, coverage.tests_of(
            mutant, farm.sources[mutant.file], LONGEST, EXTRA))  # fmt: skip

    with ThreadPoolExecutor(farm.jobs) as pool:
        try:
            for done in as_completed([pool.submit(attempt, mutant) for mutant in mutants]):
                one = done.result()
                if one is None or one.outcome == "not compiled":
                    continue
                results.append(one)
                mark = "" if one.outcome in NOTICED else "  " + one.mutant.changed_line(
                    farm.sources[one.mutant.file])  # fmt: skip
                print(f"{len(results):4} {one.outcome:7} {one.seconds:4.0f} s {one.tests:4} tests "
                      f"{one.mutant.file}:{one.mutant.line}{mark}", flush=True)  # fmt: skip
        except KeyboardInterrupt:
            print("stopped", flush=True)
        finally:
            farm.stop()
    return results


def main() -> int:
    args, began = parse(), time.monotonic()
    for number in (signal.SIGTERM, signal.SIGINT):  # a shell lets background jobs ignore Ctrl-C
        signal.signal(number, signal.default_int_handler)
    sources = read_sources()
    mutants = select_mutants(args, sources)
    words = ["git", "describe", "--always", "--dirty", "--exclude=*"]
    head = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    print(f"{len(mutants)} mutants, seed {args.seed}, head {head.stdout.strip()}", flush=True)
    coverage = read_map(args)
    with tempfile.TemporaryDirectory(prefix="layerjam-mutants-") as folder:
        farm = Farm(Path(folder), sources, args.jobs)
        if not farm.is_sound():
            print("a test fails on an unchanged copy, or the copy is not the package it imports")
            return 2
        results = try_all(farm, mutants, coverage)
    report = summarize(results, sources)
    report |= {"seed": args.seed, "head": head.stdout.strip(), "seconds": time.monotonic() - began}
    show(report)
    if args.json:
        Path(args.json).write_text(json.dumps(report, indent=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
