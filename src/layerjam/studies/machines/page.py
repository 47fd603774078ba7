"""A machine's result as a folder: report.html, results.json and figures, whole or not at all."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from layerjam._version import __version__
from layerjam.commands.declare import Progress
from layerjam.commands.wording import in_words
from layerjam.report.folder import figures_of, write_folder
from layerjam.report.page import NONE, Page, Part, Table, Word, drawn_all, html
from layerjam.studies.machines.figures import pictures
from layerjam.studies.machines.verdict import Result
from layerjam.units import show

MET = Word("✓ met", "verdict reproduced")
MISSED = Word("≠ missed", "verdict differs")


def write(result: Result, values: str, out: Path, progress: Progress) -> Path:
    """Write the folder; gives the path of the page. `values` is the text of results.json."""
    made = page(result)
    svgs = drawn_all(made.pictures(), progress)
    content = {"report.html": html(made.shown(), svgs), "results.json": values + "\n"}
    write_folder(out, content | figures_of(svgs))
    return out / "report.html"


def page(result: Result) -> Page:
    """What stands on the page of a machine."""
    scenario, met = result.scenario, sum(limit.met for limit in result.limits)
    feasible = Word("✓ feasible", "reproduced"), Word("≠ not feasible", "differs")
    needed = "none does" if result.brakes_needed is None else str(result.brakes_needed)
    return Page(
        title=f"{scenario.name}: {scenario.title}" if scenario.title else scenario.name,
        lead=f"A machine of Choi et al. 2018, Fig. 13, with brakes {scenario.brake.name}, computed "
        "from a model; nothing here was measured.",
        verdicts=[feasible[not result.feasible]],
        banner=[result.verdict],
        numbers=[
            (show(result.mass, "kg"), "mass of the brakes of this scenario"),
            (needed, "brakes it would take"),
            (f"{met} of {len(result.limits)}", "limits met"),
        ],
        parts=_parts(result),
        footer=f"layerjam {__version__}, {datetime.now(UTC).date().isoformat()}",
    )


def _parts(result: Result) -> list[Part]:
    limits = [
        [
            Word(limit.name, "claim"),
            Word(show(limit.value, limit.unit), "value"),
            "at least" if limit.least else "at most",
            Word(show(limit.limit, limit.unit), "value"),
            MET if limit.met else MISSED,
        ]
        for limit in result.limits
    ]
    units = result.own_units
    own = [
        [name.replace("_", " "), NONE if value is None else in_words(value, units.get(name, ""))]
        for name, value in result.own.items()
    ]
    cited = [
        [Word(path, "claim"), Word(value, "words"), Word(source, "why")]
        for path, value, source in result.scenario.cited()
    ]
    head = ["what", "value", "", "allowed", "verdict"]
    sources = Table(id="sources-table", head=["entry", "value", "source"], rows=cited)
    every = Table(id="results-table", head=["quantity", "value"], rows=own)
    said = [*result.warnings, *result.scenario.warnings()]
    return [
        Part(
            id="limits", title="Limits", tables=[Table(id="limits-table", head=head, rows=limits)]
        ),
        Part(id="pictures", title="Pictures", pictures=pictures(result)),
        Part(id="results", title="All results", tables=[every]),
        Part(id="notes", title="What must be said", text=list(dict.fromkeys(said))),
        Part(id="sources", title="Where every number comes from", tables=[sources]),
    ]
