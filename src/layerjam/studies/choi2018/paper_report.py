"""One page with the recomputed paper: every claim with our result, and the figures."""

from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from layerjam._version import __version__
from layerjam.bench.figures import line_pictures
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.figures import fluid_figures, force_figures, impact_figures, stack_figures
from layerjam.core.command.declare import Progress
from layerjam.core.drawing import style
from layerjam.core.drawing.folder import check_folder, figure_files, format_json, write_folder
from layerjam.core.drawing.page import (
    NONE,
    Page,
    Part,
    Picture,
    Table,
    Word,
    draw_all,
    require_extras,
    to_html,
)
from layerjam.core.threads import Workers, cache_threadsafe
from layerjam.laboratory.figures import calibration_figure, friction_figures, pull_figures
from layerjam.laboratory.identify.calibration.result import Calibration
from layerjam.laboratory.identify.friction.reduction import FrictionResult
from layerjam.laboratory.identify.validation.metrics import Validation
from layerjam.laboratory.measure.trace import Trace
from layerjam.studies.choi2018 import figures as paper_figures
from layerjam.studies.choi2018 import impact, model, sensor_figures, speed, speed_figures
from layerjam.studies.choi2018 import lab as laboratory
from layerjam.studies.choi2018.claims import Claim, Verdict, claim, count_verdicts, load_paper
from layerjam.studies.machines import page
from layerjam.studies.machines.registry import load_scenario
from layerjam.studies.machines.verdict import Result
from layerjam.workshop.figures import density_figures

TITLE = "A soft brake on paper, recomputed"
LEAD = (
    "Choi et al.: A Soft, Controllable, High Force Density Linear Brake Utilizing "
    "Layer Jamming (IEEE RA-L 2018, DOI 10.1109/LRA.2017.2761938). Every number, table and figure "
    "that this software can compute, compared with the paper's."
)
BANNER = (
    "Every curve here is computed or comes from files of a virtual test machine; those "
    "are labelled synthetic. No measured curve of the paper is published. Printed values "
    "are quoted from the paper; 'ours' was computed in this run."
)
MEANING = (
    "Two verdicts test the paper: 'reproduced' (a printed number that follows from others, within "
    "half a unit of its last digit unless the row says otherwise) and 'differs'. 'Consistent' is "
    "arithmetic on the paper's own numbers, or a statement that they confirm. 'By construction' "
    "does not test the paper, because the printed number is an input. 'Ours to explain' is a "
    "difference that our reading or our assumptions may cause. 'Not reproducible' needs data that "
    "nobody published. A row in brackets repeats a claim that is already counted."
)
FOOTER = "Verdicts are computed from the numbers and their basis; none is hard-coded."
MARKS = {
    Verdict.REPRODUCED: "✓",
    Verdict.CONSISTENT: "∼",
    Verdict.BY_CONSTRUCTION: "=",
    Verdict.DIFFERS: "≠",
    Verdict.NOT_REPRODUCIBLE: "?",
    Verdict.OURS: "!",
}
LAB_SHARE = 0.2
"""Fraction of the total time required by the procedures on synthetic files."""
Draw = Callable[[], "style.Figure"]
MACHINES = {
    "seat-belt": page.draw_belt_versus_displacement,
    "neck-guard": page.draw_neck_versus_time,
    "ankle-clutch": page.draw_ankle_stride,
    "rehabilitation": page.draw_exercise_versus_time,
}


@cache_threadsafe
def _analyse_machine(name: str) -> Result:
    return load_scenario(name).analyse()


def machine_claims() -> list[Claim]:
    """Return the machines that the paper proposes, with our verdicts."""
    results = {name: _analyse_machine(name) for name in MACHINES}
    words = {True: "feasible", False: "not as built"}
    return [claim(name, words[r.feasible], reason=r.reason) for name, r in results.items()]


def draw_machine(name: str) -> style.Figure:
    """Return the figure of a machine for the paper's page."""
    return MACHINES[name](_analyse_machine(name))


FIGURES: dict[str, Draw] = {
    "eq5": paper_figures.draw_eq5,
    "closing": paper_figures.draw_closing_vacuum,
    "fig4": paper_figures.draw_fig4,
    "fig4-judder": speed_figures.draw_fig4_stick_slip,
    "judder-map": speed_figures.draw_amplitudes,
    "fig5": fluid_figures.draw_fig5,
    "fig6": speed_figures.draw_fig6,
    "fig7-9": paper_figures.draw_fig7_9,
    "fig8": laboratory.draw_fig8,
    "stack-onset": stack_figures.draw_onset,
    "stack-spread": stack_figures.draw_spread,
    "fig11": impact_figures.draw_fig11,
    "accelerometer": sensor_figures.draw_readings,
    "filter-and-rope": sensor_figures.draw_requirements,
    "regulators": line_pictures.draw_regulators,
    "forces": line_pictures.draw_forces,
    "plan": line_pictures.draw_warned_plan,
    "sheets": paper_figures.draw_sheets_and_mass,
    "fig12": density_figures.draw_fig12,
    **{f"machine-{name}": partial(draw_machine, name) for name in MACHINES},
}
"""{picture in paper.toml: function that draws it}."""
CLAIMS: dict[str, Sequence[Callable[[], list[Claim]]]] = {
    "device": [model.claim_structure, model.claim_equations],
    "materials": [model.claim_materials, speed.judder_claims, model.claim_fluids, speed.wet_claims],
    "friction": [laboratory.friction_claims, laboratory.validation_claims],
    "calibration": [laboratory.calibration_claims, model.claim_stiffnesses],
    "damping": [model.claim_damping, impact.claims],
    "density": [model.claim_force_density],
    "machines": [machine_claims],
}
"""{part in paper.toml: functions that compute its claims}."""


def write_report(
    out: Path,
    *,
    overwrite: bool = False,
    progress: Progress | None = None,
    extra: Sequence[Part] = (),
    numbers: Sequence[tuple[str, str]] = (),
) -> dict[Verdict, int]:
    """Write report.html, results.json and figures/*.svg to `out`; return the verdict counts.

    `extra` parts and `numbers` come first on the page (the demo uses them). Raises FileError if the
    report exists and `overwrite` is not set, or if the folder cannot be created.
    """
    tell: Progress = progress or (lambda *_: None)
    require_extras()
    check_folder(out, overwrite)
    tell("procedures of the paper on synthetic files", 0.01)
    for film in paper_figures.CALIBRATED:
        tell(f"{paper_figures.NAMES[film]}: {laboratory.TEST_COUNT}", LAB_SHARE / 2)
        laboratory.run_film_study(film)
    tell("figures and claims", LAB_SHARE)
    parts = [part["id"] for part in load_paper()["part"] if part["id"] != "main-job"]
    pool = Workers(2)
    try:
        # the claims are computed while the figures are drawn
        futures = {name: [pool.submit(work) for work in CLAIMS.get(name, ())] for name in parts}
        every = [*extra, *(make_part(name, FIGURES) for name in parts)]
        pictures = [picture for part in every for picture in part.pictures]
        svgs = draw_all(pictures, tell, LAB_SHARE, 0.9)
        tell("claims", 0.9)
        claims = {n: [c for group in futures[n] for c in group.result()] for n in parts}
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
    rows = [claim for group in claims.values() for claim in group]
    counts = count_verdicts(rows)
    page = Page(
        title=TITLE,
        lead=LEAD,
        navigation=True,
        numbers=numbers,
        verdicts=[Word(f"{MARKS[v]} {v}: {count}", _word_kind(v)) for v, count in counts.items()],
        banner=[BANNER, MEANING],
        parts=[*extra, *(make_part(name, FIGURES, claims[name]) for name in parts)],
        footer=f"layerjam {__version__}, {datetime.now(UTC).date().isoformat()}. {FOOTER}",
    )
    results = format_json([claim.row() for claim in rows])
    content = {"report.html": to_html(page.template_data(), svgs), "results.json": results}
    write_folder(out, content | figure_files(svgs))
    tell(f"report {out / 'report.html'}", 1.0)
    return counts


def make_part(name: str, draw: Mapping[str, Draw], claims: Sequence[Claim] = ()) -> Part:
    """Return a part in paper.toml, with its pictures and its computed claims."""
    row = next(part for part in load_paper()["part"] if part["id"] == name)
    pictures = [
        Picture(name=p["name"], figure=draw[p["name"]], caption=p["caption"])
        for p in row["picture"]
    ]
    head = ["claim", "section", "paper", "ours", "verdict", "because", "why"]
    table = Table(id=f"claims-{name}", head=head, rows=[_format_claim(claim) for claim in claims])
    return Part(
        id=name,
        title=row["title"],
        text=row.get("text", ()),
        tables=[table] if claims else [],
        pictures=pictures,
    )


def _format_claim(claim: Claim) -> list[Word]:
    """Return a claim as a table row; brackets mark verdicts that are not counted."""
    verdict = f"{MARKS[claim.verdict]} {claim.verdict}"
    return [
        Word(claim.claim, "claim"),
        Word(claim.section),
        _format_value(claim.paper, claim.unit),
        _format_value(claim.ours, claim.unit),
        Word(f"({verdict})" if claim.again else verdict, f"verdict {_word_kind(claim.verdict)}"),
        Word(claim.because, "because"),
        Word(claim.why, "why"),
    ]


def _word_kind(verdict: Verdict) -> str:
    return verdict.replace(" ", "-")


def _format_value(value: float | str | None, unit: str) -> Word:
    if value is None or isinstance(value, str):
        return Word(value or NONE, "words")
    text = f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
    return Word(text if unit in ("", "1") else f"{text} {unit}", "value")


def make_main_part(
    file: BrakeFile,
    traces: Sequence[Trace],
    friction: FrictionResult,
    calibration: Calibration,
    validation: Validation,
    vacuum: tuple[float, float, float],
) -> Part:
    """Return the part of the page with one analysis, from measured files to a required vacuum.

    `vacuum` is (slip [m], required force [N], vacuum [Pa]).
    """
    draw: dict[str, Draw] = {
        "run-friction": partial(friction_figures.draw_friction, traces, friction),
        "run-calibration": partial(
            calibration_figure.draw_calibration, file, calibration, synthetic=True
        ),
        "run-validation": partial(pull_figures.draw_validation, file, validation, synthetic=True),
        "run-vacuum": partial(force_figures.plot_force_vacuum, file, *vacuum),
    }
    return make_part("main-job", draw)
