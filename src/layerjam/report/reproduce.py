"""The paper, recomputed: every claim beside ours, and the figures, on one page."""

from __future__ import annotations

import functools
import json
import os
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from layerjam._version import __version__
from layerjam.device.file import BrakeFile
from layerjam.device.load import write_whole
from layerjam.errors import FileError
from layerjam.identify.calibration.peaks import Calibration
from layerjam.identify.friction.reduction import FrictionResult
from layerjam.identify.trace import Trace
from layerjam.identify.validation.metrics import Validation
from layerjam.report import (
    density_figures,
    fluid_figures,
    impact_figures,
    line_pictures,
    paper_figures,
    paper_impact,
    paper_lab,
    paper_machines,
    paper_model,
    paper_speed,
    sensor_figures,
    speed_figures,
    stack_figures,
)
from layerjam.report.claims import Claim
from layerjam.report.figures import calibration, force_over_vacuum, friction, validation
from layerjam.report.page import Part, Picture, check_extras, drawn, render_page, tally
from layerjam.report.paper_lab import FilmRun

TITLE = "A soft brake on paper, recomputed"
LEAD = (
    "Choi et al.: A Soft, Controllable, High Force Density Linear Brake Utilizing "
    "Layer Jamming (IEEE RA-L 2018, DOI 10.1109/LRA.2017.2761938). Every number, table and figure "
    "that this software can compute, beside what the paper prints."
)
BANNER = (
    "Every curve here is computed or comes from files of a virtual test machine; those are "
    "synthetic and named so. No measured curve of the paper is published. What the paper prints is "
    "quoted as the paper's; 'ours' was computed in this run."
)


@dataclass(frozen=True, kw_only=True)
class Reproduction:
    """Where the report is and how the claims fell out."""

    report: Path
    results: Path
    counts: dict[str, int]


def reproduce(
    out: Path,
    *,
    force: bool = False,
    say: Callable[[str], None] | None = None,
    extra: Sequence[Part] = (),
    numbers: Sequence[tuple[str, str]] = (),
    lab: dict[str, FilmRun] | None = None,
) -> Reproduction:
    """Write report.html, results.json and figures/*.svg into the folder `out`.

    `say` is told what is being done; `extra` parts and `numbers` stand first on the page (the demo
    uses them); `lab` takes procedures run before instead of running them. Raises FileError where
    the report exists and `force` is not set, or the folder cannot be made.
    """
    say = say or (lambda _: None)
    check_extras()
    report, results = out / "report.html", out / "results.json"
    for path in (report, results):
        if _there(path) and not force:
            raise FileError(path, "exists already; --force replaces it")
    try:
        (out / "figures").mkdir(parents=True, exist_ok=True)
    except OSError as err:
        raise FileError(out, f"cannot be made: {err.strerror}") from None
    say("procedures of the paper on synthetic files")
    if lab is None:
        with tempfile.TemporaryDirectory() as folder:
            lab = paper_lab.run_lab(Path(folder), say)
    say("figures and claims")
    pool = ThreadPoolExecutor(2)
    try:
        claims = _claims(lab, pool)
        parts = [*extra, *_parts(lab)]
        pictures = {}
        for picture in (p for part in parts for p in part.pictures):
            say(f"  figure {picture.name}")
            pictures[picture.name] = drawn(picture.figure())
        say("  claims")
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
    say(f"report: {os.fspath(report)}")
    return Reproduction(report=report, results=results, counts=tally(parts))


def _there(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError) as err:
        reason = getattr(err, "strerror", None) or str(err)
        raise FileError(str(path)[:200], f"cannot be written: {reason}") from None


def _fill(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _claims(lab: dict[str, FilmRun], pool: ThreadPoolExecutor) -> Callable[[str], list[Claim]]:
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


def _parts(lab: dict[str, FilmRun]) -> list[Part]:
    """The page without its claims."""
    fig = paper_figures
    exact = {
        name: {
            "scale_factor": run.calibration.scale_factor,
            "eq9": run.calibration.stiffness_eq9 or 0.0,
        }
        for name, run in lab.items()
    }
    return [
        Part(
            id="device",
            title="The brake and its equations (II)",
            pictures=[
                Picture(
                    name="eq5", figure=fig.eq5,
                    caption="Left: equation 5 with x inside the root, and as printed. Right: the "
                    "force of the whole Kapton brake at low vacuum; only below 1.06 kPa does it "
                    "rise all the way.",
                ),
                Picture(
                    name="closing", figure=fig.buckling_and_closing,
                    caption="Not in the paper: an unloaded brake is closed again by its own sleeve "
                    "below this vacuum.",
                ),
            ],
        ),
        Part(
            id="materials",
            title="Films, air and water (III-A, III-B)",
            pictures=[
                Picture(
                    name="fig4", figure=fig.fig4,
                    caption="Fig. 4 from the model: 94.5, 65.5, 31.0 and 0 kPa. Quasi-static, "
                    "without stick–slip. Polyester and fibreglass rest on handbook friction.",
                ),
                Picture(
                    name="fig4-judder", figure=speed_figures.fig4_judder,
                    caption="Why Fig. 4 shows the opposite of table I. Left: the saw of a slow "
                    "pull, all interfaces at once and let go one after another. Right: which film "
                    "judders at 1 mm/s over the Stribeck speed and the damping, neither of which "
                    "is measured; the moving mass, half of a brake, is assumed.",
                ),
                Picture(
                    name="judder-map", figure=speed_figures.amplitude,
                    caption="Not in the paper: how fast one must pull. Half of the force's swing "
                    "over pulling speed and vacuum (blank: it slides steadily; the line is the "
                    "closed form, which holds while the spring stays taut), and the critical speed "
                    "over the stiffness of brake and mount.",
                ),
                Picture(
                    name="fig5", figure=fluid_figures.fig5,
                    caption="Fig. 5 from the model of the line. Left: the paper prints no volume "
                    "and no compliance, so that both times are met by construction; the shapes are "
                    "the model's. Right: rise times of other lines.",
                ),
                Picture(
                    name="fig6", figure=speed_figures.fig6,
                    caption="Fig. 6 redrawn: Kapton dry (solid) and wet. The wet parameters are "
                    "illustrative, chosen after the paper's words and fitted to nothing; at "
                    "25 mm/s two sets show the two readings of its sentence.",
                ),
            ],
        ),
        Part(
            id="friction",
            title="Friction and validation before calibration (III-C)",
            text=["Procedures run on synthetic files, three repeats a film, whose truth is the "
                  "paper's table I with its standard deviations."],
            pictures=[
                Picture(
                    name="fig7-9", figure=fig.fig7_9,
                    caption="Fig. 7 and 9 from the model at 80.6, 46.1 and 18.6 kPa: dashed before "
                    "calibration, solid after; the band is what the scale factor changes.",
                ),
            ],
        ),
        Part(
            id="calibration",
            title="Calibration (III-D)",
            pictures=[
                Picture(
                    name="fig8", figure=functools.partial(fig.fig8, exact),
                    caption="Fig. 8 from the model with k of the paper's text. The three dashed "
                    "lines are the stiffness in the text, the one in the caption, and what eq. 9 "
                    "gives on this curve.",
                ),
                Picture(
                    name="stack-onset", figure=stack_figures.onset,
                    caption="Not in the paper, which names it as the reason to leave static "
                    "friction out: the sheets do not slide at once. Each sheet a spring, each "
                    "interface a friction of its own.",
                ),
                Picture(
                    name="stack-spread", figure=stack_figures.spread,
                    caption="Monte Carlo over the interfaces of the same brake in its rig: the "
                    "friction of each is drawn anew, everything else stays. The scatter of 10 % "
                    "is assumed.",
                ),
            ],
        ),
        Part(
            id="damping",
            title="Collisions (III-E)",
            pictures=[
                Picture(
                    name="fig11",
                    figure=impact_figures.fig11,
                    caption="Fig. 11 from the model. Green: the vacuum tuned, gravity and elastic "
                    "parts included, so that the brake slips 40 mm; dashed: the least peak of any "
                    "stop within that way, whatever does the stopping. Red: what the paper reads "
                    "off its figure.",
                ),
                Picture(
                    name="accelerometer", figure=sensor_figures.readings,
                    caption="The stop at 2.5 m/s as accelerometers show it: ideal, with the "
                    "ADXL193's low-pass (400 Hz; its order is assumed), and through the filters of "
                    "SAE J211-1. None hides more than a thirtieth of the peak.",
                ),
                Picture(
                    name="filter-and-rope", figure=sensor_figures.what_it_takes,
                    caption="What it would take to show the paper's peaks. Left: a low-pass of a "
                    "few hertz, behind which the bare drop would not show its 50 g. Right: no rope "
                    "does; on one soft enough the brake never slips.",
                ),
            ],
        ),
        Part(
            id="control",
            title="Not in the paper: the hand on the pump",
            text=["The paper sets a vacuum and waits. Here the same line is regulated, made to "
                  "follow a force, and asked whether it is in time. Sensor (50 Pa of noise), leak "
                  "and valve are examples of ours, not measurements."],
            pictures=[
                Picture(
                    name="regulators", figure=line_pictures.regulators,
                    caption="Left: what each regulator makes of 80 kPa and how often it switches "
                    "the pump for it. Right: a pump that dies. The regulator says so and goes to "
                    "the safe state that its configuration had to declare.",
                ),
                Picture(
                    name="forces", figure=line_pictures.forces,
                    caption="Wanted force and measured slip give the vacuum by the inverse law. "
                    "The true brake rubs 3 % more than the controller knows; the slip is noisy by "
                    "0.1 mm and grows by 0.5 mm a second. The saw on the plateau is the vent, "
                    "which opens when the vacuum is 1 % of the pump's too high.",
                ),
                Picture(
                    name="plan", figure=line_pictures.warned,
                    caption="A collision announced 3 s before: the vacuum that comes in time, and "
                    "the two modes of the paper over an uncertain energy. Tuned, the mass feels "
                    "less and the travel runs out more often.",
                ),
            ],
        ),
        Part(
            id="density",
            title="Force density (III-F)",
            pictures=[
                Picture(
                    name="sheets", figure=fig.sheets_and_mass,
                    caption="Peak force over mass as sheets are added to the Kapton brake.",
                ),
                Picture(
                    name="fig12", figure=density_figures.fig12,
                    caption="Fig. 12 from the mass model, beside devices whose mass and force "
                    "stand in a source that could be read. Classes without one are not drawn.",
                ),
            ],
        ),
        paper_machines.part(),
    ]  # fmt: skip


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
