"""The paper, recomputed: every claim beside ours, and the figures, on one page."""

from __future__ import annotations

import functools
import json
import os
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from layerjam._version import __version__
from layerjam.commands.declare import Progress
from layerjam.device.file import BrakeFile
from layerjam.device.load import write_whole
from layerjam.errors import FileError
from layerjam.identify.calibration.peaks import Calibration
from layerjam.identify.friction.reduction import FrictionResult
from layerjam.identify.validation.metrics import Validation
from layerjam.measure.trace import Trace
from layerjam.mechanics.threads import Workers
from layerjam.report import stack_figures
from layerjam.report.figures import calibration, force_over_vacuum, friction, validation
from layerjam.report.page import Picture, check_extras, drawn
from layerjam.studies.choi2018 import impact as paper_impact
from layerjam.studies.choi2018 import lab as paper_lab
from layerjam.studies.choi2018 import machines as paper_machines
from layerjam.studies.choi2018 import model as paper_model
from layerjam.studies.choi2018 import speed as paper_speed
from layerjam.studies.choi2018.claims import Claim
from layerjam.studies.choi2018.lab import FilmRun
from layerjam.studies.choi2018.page import Part, render_page, tally
from layerjam.studies.choi2018.paper_page import paper_parts

TITLE = "A soft brake on paper, recomputed"
LEAD = (
    "Choi et al.: A Soft, Controllable, High Force Density Linear Brake Utilizing "
    "Layer Jamming (IEEE RA-L 2018, DOI 10.1109/LRA.2017.2761938). Every number, table and figure "
    "that this software can compute, beside what the paper prints."
)
LAB_SHARE = 0.2
"""Share of the time that the procedures on synthetic files take."""
BANNER = (
    "Every curve here is computed or comes from files of a virtual test machine; those are "
    "synthetic and named so. No measured curve of the paper is published. What the paper prints is "
    "quoted as the paper's; 'ours' was computed in this run."
)


@dataclass(frozen=True, kw_only=True)
class PaperReport:
    """Where the report is, and how many claims have each verdict."""

    report: Path
    results: Path
    counts: dict[str, int]


def write_report(
    out: Path,
    *,
    force: bool = False,
    progress: Progress | None = None,
    extra: Sequence[Part] = (),
    numbers: Sequence[tuple[str, str]] = (),
) -> PaperReport:
    """Write report.html, results.json and figures/*.svg into the folder `out`.

    `extra` parts and `numbers` stand first on the page (the demo uses them). Raises FileError where
    the report exists and `force` is not set, or the folder cannot be made.
    """
    tell: Progress = progress or (lambda *_: None)
    check_extras()
    report, results = out / "report.html", out / "results.json"
    for path in (report, results):
        if _there(path) and not force:
            raise FileError(path, "exists already; --force replaces it")
    try:
        (out / "figures").mkdir(parents=True, exist_ok=True)
    except OSError as err:
        raise FileError(out, f"cannot be made: {err.strerror}") from None
    tell("procedures of the paper on synthetic files", 0.01)
    with tempfile.TemporaryDirectory() as folder:
        lab = paper_lab.run_lab(Path(folder), lambda what: tell(what, LAB_SHARE / 2))
    tell("figures and claims", LAB_SHARE)
    pool = Workers(2)
    try:
        claims = _claims(lab, pool)
        parts = [*extra, *paper_parts(lab)]
        planned = [p for part in parts for p in part.pictures]
        pictures = {}
        for index, picture in enumerate(planned):
            share = LAB_SHARE + (0.9 - LAB_SHARE) * index / len(planned)
            tell(f"figure {picture.name}", share)
            pictures[picture.name] = drawn(picture.figure())
        tell("claims", 0.9)
        parts = [replace(part, claims=claims(part.id) or part.claims) for part in parts]
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
    for name, svg in pictures.items():
        write_whole(out / "figures" / f"{name}.svg", functools.partial(_fill, text=svg), True)
    page = render_page(
        title=TITLE,
        lead=LEAD,
        parts=parts,
        pictures=pictures,
        numbers=numbers,
        banner=BANNER,
        footer=f"layerjam {__version__}, {datetime.now(UTC).date().isoformat()}. Verdicts are "
        "computed: 'reproduced' means within half of the last digit printed, unless the row says "
        "otherwise.",
    )
    rows = [claim.row() for part in parts for claim in part.claims]
    text = json.dumps(rows, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_whole(results, lambda p: _fill(p, text), True)
    write_whole(report, lambda p: _fill(p, page), True)
    tell(f"report {os.fspath(report)}", 1.0)
    return PaperReport(report=report, results=results, counts=tally(parts))


def _there(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError) as err:
        reason = getattr(err, "strerror", None) or str(err)
        raise FileError(str(path)[:200], f"cannot be written: {reason}") from None


def _fill(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _claims(lab: dict[str, FilmRun], pool: Workers) -> Callable[[str], list[Claim]]:
    """The claims of each part, worked out while the figures are drawn."""
    pool.submit(stack_figures.warm_up)
    of: dict[str, list[Callable[[], list[Claim]]]] = {
        "device": [paper_model.structure, paper_model.equations],
        "materials": [
            paper_model.materials, paper_speed.judder_claims, paper_model.fluids,
            paper_speed.wet_claims,
        ],
        "friction": [
            functools.partial(paper_lab.friction_claims, lab),
            functools.partial(paper_lab.validation_claims, lab),
        ],
        "calibration": [
            functools.partial(paper_lab.calibration_claims, lab), paper_model.stiffnesses,
        ],
        "damping": [paper_model.damping, paper_impact.claims],
        "density": [paper_model.force_density],
        "machines": [paper_machines.claims],
    }  # fmt: skip
    begun = {part: [pool.submit(claims) for claims in each] for part, each in of.items()}
    return lambda part: [claim for some in begun.get(part, ()) for claim in some.result()]


def main_job(
    file: BrakeFile,
    traces: Sequence[Trace],
    reduced: FrictionResult,
    fitted: Calibration,
    compared: Validation,
    vacuum: tuple[float, float, float],
) -> Part:
    """The part of the page that shows one run from files to a vacuum.

    `vacuum` is (slip [m], force wanted [N], vacuum [Pa]).
    """
    names = ("friction", "calibration", "validation", "vacuum")
    figures = (
        functools.partial(friction, traces, reduced),
        functools.partial(calibration, file, fitted, synthetic=True),
        functools.partial(validation, file, compared, synthetic=True),
        functools.partial(force_over_vacuum, file, *vacuum),
    )
    captions = (
        "Three friction tests read from Bluehill files. Static is the maximum of each, kinetic the "
        "mean over the shaded window.",
        "One pull read from a testXpert file. Stiffness is the slope before onset; the scale "
        "factor follows from the fitted peak.",
        "Pulls at other vacuums and speeds, which the calibration has not seen.",
        "The calibrated brake, asked for the vacuum that gives a force.",
    )
    return Part(
        id="main-job",
        title="This run: from files to a vacuum",
        text=[
            "Friction tests and pulls of the paper's Kapton brake, written by the virtual test "
            "machine from a stated truth and seed, then read, reduced, calibrated, validated and "
            "inverted as measured files would be. The data is synthetic."
        ],
        pictures=[
            Picture(name=f"run-{name}", figure=figure, caption=caption)
            for name, figure, caption in zip(names, figures, captions, strict=True)
        ],
    )
