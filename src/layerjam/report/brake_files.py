"""A brake's report as files: HTML, PDF, figures, numbers.csv, results.json; whole or not at all."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files as resources
from pathlib import Path
from typing import Any

from layerjam._version import __version__
from layerjam.errors import FileError, MissingExtraError
from layerjam.identify.provenance import renamed
from layerjam.identify.validation.metrics import WINDOW
from layerjam.report.brake_numbers import COLUMNS, Number
from layerjam.report.brake_report import BrakeReport, all_numbers, context, drawings
from layerjam.report.page import check_extras, drawn, svg_of

FIGURES = ("friction", "calibration", "validation", "residuals")
NAMES = ("results.json", "numbers.csv", "report.pdf", "report.html")


def csv_text(numbers: Sequence[Number], names: Mapping[str, str] | None = None) -> str:
    """numbers.csv: SI values, every digit; `names` as in a BrakeReport."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for number in numbers:
        cells = (renamed(plain(v), names or {}) for v in number.row().values())
        writer.writerow(
            ["" if v is None else repr(v) if isinstance(v, float) else v for v in cells]
        )
    return out.getvalue()


def plain(value: Any) -> Any:
    """For JSON: what is not finite is not known."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, bool | int | str) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None


def results(report: BrakeReport) -> dict[str, Any]:
    """results.json."""
    return {
        "brake": report.file.name,
        "date": report.date,
        "program": f"layerjam {__version__}",
        "command": report.command,
        "synthetic": report.synthetic,
        "window": WINDOW,
        "calibrated_on_the_same": list(report.seen),
        **{stage: report.stages.get(stage) for stage in ("friction", "calibration", "validation")},
        "numbers": [n.row() for n in all_numbers(report)],
        "files": [vars(f) for f in report.files],
        "refused": [
            {"file": name, "stage": stage, "reason": why} for name, stage, why in report.refused
        ],
        "warnings": report.warnings,
    }


def html(shown: Mapping[str, Any], pictures: Mapping[str, str]) -> str:
    """The page: no script, no outside address, figures inside."""
    template = (resources("layerjam.report") / "brake_report.html.j2").read_text(encoding="utf-8")
    inside = {name: themed(svg_of(svg, name)) for name, svg in pictures.items()}
    check_extras()
    import jinja2

    env = jinja2.Environment(autoescape=True, trim_blocks=True, undefined=jinja2.StrictUndefined)
    return env.from_string(template).render(**shown, pictures=inside)


def themed(svg: str) -> str:
    """An inline figure whose colours follow the page, so that it reads on a dark one too."""
    svg = re.sub(r' xmlns(:\w+)?="[^"]*"', "", svg)
    for color, name in THEME.items():
        svg = re.sub(rf"{color}\b", f"var(--{name})", svg, flags=re.IGNORECASE)
    return svg


THEME = {
    "#ffffff": "ground", "#1c2530": "ink", "#66717d": "grey", "#e7ebee": "grid",
    "#c9d0d6": "line", "#f1f4f6": "shade", "#08306b": "v1", "#2171b5": "v2", "#4f9bcb": "v3",
    "#8c96a0": "v4", "#0072b2": "blue", "#e69f00": "orange", "#8a5f00": "brown",
    "#d55e00": "red", "#56b4e9": "sky", "#009e73": "green", "#cc79a7": "purple",
}  # fmt: skip
"""Colours of the figures and the page's names for them."""


@dataclass(frozen=True, kw_only=True)
class Written:
    """Where the report is; `pdf` is None where typst is not installed."""

    report: Path
    pdf: Path | None
    numbers: Path
    results: Path
    figures: Sequence[Path]
    warnings: Sequence[str]


def check_folder(out: Path, force: bool) -> None:
    """Raise FileError where a report could not be written into `out`, before anything is done."""
    try:
        if os.path.lexists(out) and not out.is_dir():
            raise FileError(out, "is a file, not a folder")
        for name in NAMES:
            if os.path.lexists(out / name) and not force:
                raise FileError(out / name, "exists already; --force replaces it")
        there = _nearest(out)
        if not os.access(there, os.W_OK):
            raise FileError(out, f"cannot be made: the folder {there} is read-only")
    except (OSError, ValueError) as err:
        reason = getattr(err, "strerror", None) or str(err)
        raise FileError(str(out)[:200], f"cannot be made: {reason}") from None


def _nearest(out: Path) -> Path:
    """The folder itself, or the first above it that exists."""
    for folder in (out.absolute(), *out.absolute().parents):
        if folder.is_dir():
            return folder
        if os.path.lexists(folder):
            raise FileError(out, f"cannot be made: {folder} is no folder")
    raise FileError(out, "cannot be made")


def write(
    report: BrakeReport, out: Path, force: bool = False, say: Callable[[str], None] | None = None
) -> Written:
    """Write the report into the folder `out`, whole or not at all.

    Everything is made in a folder beside it first. Without the extra `pdf` there is no PDF and a
    warning says so. Raises FileError where a report exists and `force` is not set.
    """
    say = say or (lambda _: None)
    check_folder(out, force)
    staging = Path(tempfile.mkdtemp(prefix=".layerjam-report-", dir=_nearest(out.parent)))
    try:
        warnings = _fill(report, staging, say)
        _install(staging, out)
    except OSError as err:
        raise FileError(out, f"cannot be written: {err.strerror or err}") from None
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    pdf = out / "report.pdf"
    return Written(
        report=out / "report.html",
        pdf=pdf if not warnings else None,
        numbers=out / "numbers.csv",
        results=out / "results.json",
        figures=sorted((out / "figures").glob("*.svg")),
        warnings=warnings,
    )


def _fill(report: BrakeReport, folder: Path, say: Callable[[str], None]) -> list[str]:
    """All files of the report; what could not be made, as sentences."""
    (folder / "figures").mkdir()
    pictures = {}
    for drawing in drawings(report):
        say(f"figure {drawing.name}")
        pictures[drawing.name] = drawn(drawing.figure())
        path = folder / "figures" / f"{drawing.name}.svg"
        path.write_text(pictures[drawing.name], encoding="utf-8")
    names = report.names
    shown = renamed(context(report), names)
    whole = renamed(plain(results(report)), names)
    text = json.dumps(whole, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "results.json").write_text(text + "\n", encoding="utf-8")
    (folder / "numbers.csv").write_text(csv_text(all_numbers(report), names), encoding="utf-8")
    say("page report.html")
    (folder / "report.html").write_text(html(shown, pictures), encoding="utf-8")
    try:
        from layerjam.report.typeset import pdf

        say("page report.pdf")
        (folder / "report.pdf").write_bytes(pdf(shown, pictures))
    except MissingExtraError as error:
        return [f"no PDF was written: {error}"]
    return []


def _install(staging: Path, out: Path) -> None:
    """Move the finished files to their place; what an older report left there goes."""
    umask = os.umask(0)
    os.umask(umask)
    os.chmod(staging, 0o777 & ~umask)
    if not out.exists():
        out.parent.mkdir(parents=True, exist_ok=True)
        os.replace(staging, out)
        return
    (out / "figures").mkdir(exist_ok=True)
    made = sorted(p.name for p in (staging / "figures").iterdir())
    for name in made:
        os.replace(staging / "figures" / name, out / "figures" / name)
    for name in NAMES:
        if (staging / name).exists():
            os.replace(staging / name, out / name)
        else:
            (out / name).unlink(missing_ok=True)
    for name in FIGURES:
        if f"{name}.svg" not in made:
            (out / "figures" / f"{name}.svg").unlink(missing_ok=True)
