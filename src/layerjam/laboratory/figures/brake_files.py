"""A brake's report as files: HTML, PDF, figures, numbers.csv, results.json."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from layerjam._version import __version__
from layerjam.brake.figures.live_page import make_live
from layerjam.core.drawing import folder
from layerjam.core.drawing.folder import figure_files, format_json, to_json, write_folder
from layerjam.core.drawing.page import draw_all, to_html, typeset_pdf
from layerjam.core.errors import MissingExtraError
from layerjam.core.toml_files.table_text import format_rows
from layerjam.core.verdict import accepted_rows
from layerjam.laboratory.figures.brake_numbers import COLUMNS, Number
from layerjam.laboratory.figures.brake_report import (
    STAGES,
    BrakeReport,
    list_excluded,
    list_numbers,
    make_page,
)
from layerjam.laboratory.identify.provenance import rename_files
from layerjam.laboratory.identify.validation.metrics import WINDOW

FIGURES = ("friction", "calibration", "scale-factors", "validation", "residuals")
NAMES = ("results.json", "numbers.csv", "report.pdf", "report.html")


def format_numbers(numbers: Sequence[Number], names: Mapping[str, str] | None = None) -> str:
    """Return numbers.csv with SI values in full precision; `names` as in a BrakeReport."""
    rows = ([rename_files(to_json(v), names or {}) for v in n.row().values()] for n in numbers)
    return format_rows([COLUMNS, *rows])


def make_results(report: BrakeReport, numbers: Sequence[Number]) -> dict[str, Any]:
    """Return the content of results.json."""
    return {
        "brake": report.file.name,
        "date": report.date,
        "identity": report.identity,
        "verdict": "accepted" if report.accepted else report.verdict.verdict,
        "accepted": accepted_rows(report.accepted),
        "program": f"layerjam {__version__}",
        "command": report.command,
        "synthetic": report.synthetic,
        "window": WINDOW,
        "calibrated_on_the_same": list(report.seen),
        **{stage: report.stages.get(stage) for stage in STAGES},
        "numbers": [n.row() for n in numbers],
        "files": [vars(f) for f in report.files],
        "refused": _list_unused(report.refused, "reason"),
        "excluded": list_excluded(report.excluded),
        "warnings": report.warnings,
    }


def _list_unused(rows: Sequence[tuple[str, str, str]], word: str) -> list[dict[str, str]]:
    return [{"file": Path(path).name, "stage": stage, word: reason} for path, stage, reason in rows]


@dataclass(frozen=True, kw_only=True)
class ReportFiles:
    """Paths of the report; `pdf` is None if typst is not installed."""

    report: str
    pdf: str | None
    numbers: str
    results: str
    figures: Sequence[str]
    warnings: Sequence[str]


def check_folder(out: Path, overwrite: bool) -> None:
    """Raise FileError if a report cannot be written into `out`, before any work is done."""
    folder.check_folder(out, overwrite, NAMES)


def write_report(
    report: BrakeReport,
    out: Path,
    overwrite: bool = False,
    progress: Callable[[str], None] | None = None,
    *,
    live: bool = False,
) -> ReportFiles:
    """Write the report into the folder `out`, completely or not at all.

    With `live`, the HTML has a part that computes the brake of the report. Without the `pdf` extra
    there is no PDF, and a warning says so. Raises FileError if a report exists and `overwrite` is
    not set.
    """
    progress = progress or (lambda _: None)
    check_folder(out, overwrite)
    names, document = report.names, make_page(report)
    numbers = list_numbers(document.parts)
    pictures = draw_all(document.pictures(), lambda what, _: progress(what))
    data = rename_files(document.template_data(), names)
    content: dict[str, str | bytes] = {
        "results.json": format_json(rename_files(to_json(make_results(report, numbers)), names)),
        "numbers.csv": format_numbers(numbers, names),
        "report.html": to_html(data, pictures, make_live(report.file) if live else None),
        **figure_files(pictures),
    }
    warnings = []
    try:
        progress("page report.pdf")
        content["report.pdf"] = typeset_pdf(data, pictures)
    except MissingExtraError as error:
        warnings.append(f"no PDF was written: {error}")
    write_folder(out, content, old=(*NAMES, *(f"figures/{name}.svg" for name in FIGURES)))
    return ReportFiles(
        report=str(out / "report.html"),
        pdf=str(out / "report.pdf") if "report.pdf" in content else None,
        numbers=str(out / "numbers.csv"),
        results=str(out / "results.json"),
        figures=[str(path) for path in sorted((out / "figures").glob("*.svg"))],
        warnings=warnings,
    )
