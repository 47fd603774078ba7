"""The tables of docs/bench-faults.md, from what the commands printed and from drifts tried here.

    layerjam bench faults --runs 100 --json > faults.json
    layerjam bench soak --hours 24 --kind pi --json > pi.json
    python tests/bench_tables.py faults.json pi.json [--drift RUNS] [--write]

A file is known by its keys. Without `--drift` the table of drifts stays as it is.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from layerjam.bench.rig.address import VIRTUAL
from layerjam.bench.rig.campaign import Bed, run_trial, set_full_speed
from layerjam.bench.rig.kinds import DRIFTS
from layerjam.bench.rig.observer import draw_plan
from layerjam.core.units import show

PAGE = Path(__file__).parent.parent / "docs" / "bench-faults.md"


def between(page: str, name: str, rows: list[str]) -> str:
    """The page with other rows between the two marks of a table."""
    begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->"
    before, rest = page.split(begin)
    return before + begin + "\n" + "\n".join(rows) + "\n\n" + end + rest.split(end)[1]


def seconds(value: float | None) -> str:
    return "–" if value is None else show(value, "s")


def faults(said: dict[str, Any]) -> list[str]:
    """A row for each fault, the run nearest to its deadline."""
    runs = {row["runs"] for row in said["faults"]}
    each = f"{runs.pop()} runs each" if len(runs) == 1 else "the runs as counted"
    ends = "" if said["complete"] else "; stopped before its end"
    rows = [
        f"On the virtual board under {said['board']}, {each}, {said['missed']} missed{ends}. The "
        "run nearest to its deadline:",
        "",
        "| fault | safe after | deadline | vacuum left | named |",
        "|---|---|---|---|---|",
    ]
    for row in said["faults"]:
        named = ", ".join(f"{name} {count}" for name, count in row["named"].items()) or "never"
        safe = seconds(row["safe_after"])
        if row["named_after"] is not None:
            safe += f", named after {seconds(row['named_after'])}"
        promised = "not promised" if row["deadline"] is None else seconds(row["deadline"])
        left = show(max(row["vacuum_after"], 0.1), "Pa") if row["vacuum_after"] >= 0.1 else "none"
        missed = "" if row["met"] else f", **{row['missed']} missed**"
        rows.append(f"| `{row['fault']}` | {safe} | {promised}{missed} | {left} | {named} |")
    return rows


def soaks(said: list[dict[str, Any]]) -> list[str]:
    """A row for each regulator."""
    rows = [
        "| regulator | hours | samples | orders | false faults | gaps | wraps | late samples | "
        "growth of the heap |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for one in said:
        hours = f"{one['hours']:.1f}" + ("" if one["complete"] else " (stopped)")
        grown = "not counted" if one["heap_growth"] is None else f"{one['heap_growth']} B"
        rows.append(
            f"| {one['kind']} | {hours} | {one['ticks']:,} | {one['orders']} | "
            f"{one['false_faults']} | {one['gaps']} | {one['wraps']} | {one['late_ticks']} | "
            f"{grown} |"
        )
    return rows


def spread(values: list[float], runs: int, unit: str = "s") -> str:
    """How many there are, and from where to where."""
    if not values:
        return f"0 of {runs}"
    low, high = show(min(values), unit), show(max(values), unit)
    return f"{len(values)} of {runs}, after {low}" + (f" to {high}" if len(values) > 1 else "")


def drifts(runs: int) -> list[str]:
    """What becomes of a held vacuum while its sensor climbs, with one sensor and with two."""
    rows = [
        f"{runs} runs each, watched for ten minutes:",
        "",
        "| drift | a tenth of the vacuum lost | QUES bit 10 | named | with a second sensor |",
        "|---|---|---|---|---|",
    ]
    with Bed(set_full_speed(VIRTUAL)) as one, Bed(set_full_speed(VIRTUAL + "&second=1")) as two:
        for rate in DRIFTS:
            lost, doubted, named, second = [], [], 0, []
            for n in range(runs):
                trial = run_trial(one, draw_plan(one.behind, "sensor-drift", n, 0, size=rate))
                lost += [] if trial.lost_after is None else [trial.lost_after]
                doubted += [] if trial.doubted_after is None else [trial.doubted_after]
                named += trial.named is not None
                other = run_trial(two, draw_plan(two.behind, "sensor-drift", n, 0, size=rate))
                second += [other.safe_after] if other.is_met and other.safe_after else []
            rows.append(
                f"| {show(rate, 'Pa/s')} | {spread(lost, runs)} | {spread(doubted, runs)} | "
                f"{named} of {runs} | safe: {spread(second, runs)} |"
            )
            print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Print the tables, or write them into the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--drift", type=int, default=0, metavar="RUNS")
    parser.add_argument("--write", action="store_true")
    asked = parser.parse_args()
    said = [json.loads(file.read_text("utf-8")) for file in asked.files]
    tables: dict[str, list[str]] = {}
    campaign: dict[str, Any] = {}
    for one in said:
        if "left_out" in one:  # a fault that was tried again replaces its row
            rows = {row["fault"]: row for row in [*campaign.get("faults", ()), *one["faults"]]}
            whole = campaign.get("complete", True) and one["complete"]
            campaign = {**one, "faults": list(rows.values()), "complete": whole}
            campaign["missed"] = sum(row["missed"] for row in rows.values())
            tables["faults"] = faults(campaign)
    if soaked := [one for one in said if "wraps" in one]:
        tables["soak"] = soaks(soaked)
    if asked.drift:
        tables["drift"] = drifts(asked.drift)
    page = PAGE.read_text("utf-8")
    for name, rows in tables.items():
        print("\n".join(rows))
        page = between(page, name, rows)
    if asked.write:
        PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
