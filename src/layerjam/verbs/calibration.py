"""`calibrate`: scale factor and stiffness from measured pulls."""

from __future__ import annotations

from pathlib import Path

from layerjam.identify.columns import Choices
from layerjam.identify.fit import calibrate as fit
from layerjam.identify.fit import calibrated_text, fit_pull
from layerjam.verbs.answer import Answer, AnyBrake, Quantity, brake_at
from layerjam.verbs.files import Paths, pulls, write_brake


def calibrate(
    brake: AnyBrake,
    files: Paths,
    *,
    vacuum: Quantity | None = None,
    out: str | Path | None = None,
    partial: bool = False,
    atmosphere: Quantity | None = None,
    choices: Choices | None = None,
    force: bool = False,
) -> Answer:
    """Scale factor and stiffness of a brake from one or several pulls.

    `vacuum` serves files without a sidecar that states it. With `out` the calibrated brake is
    written. `record` is the Calibration.
    """
    file = brake_at(brake, atmosphere)
    used, refused, odd = pulls(files, file, vacuum, choices, fit_pull)
    result = fit([(pull, pressure) for _, pull, pressure in used], file.brake)
    traces = [trace for trace, _, _ in used]
    written, said = write_brake(
        out, lambda name: calibrated_text(file, result, name), force, bool(refused), partial
    )
    errors = {"scale_factor": result.scale_factor_se, "stiffness": result.stiffness_se}
    return Answer(
        values={
            "scale_factor": result.scale_factor,
            "stiffness": result.stiffness,
            "scale_factor_eq8": result.scale_factor_eq8,
            "stiffness_eq9": result.stiffness_eq9,
            "peak_force": result.peak_force,
            "peak_elongation": result.peak_elongation,
            "standard_errors": {**errors, "rests_on": result.errors_rest_on},
            "checks": [
                {"name": c.name, "passed": c.passed, "sentence": c.sentence} for c in result.checks
            ],
            "understood": {t.path: list(t.understood) for t in traces},
            "refused": refused,
            "file": written,
        },
        units={
            "scale_factor": "1",
            "stiffness": "N/m",
            "scale_factor_eq8": "1",
            "stiffness_eq9": "N/m",
            "peak_force": "N",
            "peak_elongation": "m",
        },
        warnings=[
            *file.warnings(without=("scale_factor", "stiffness_measured")),
            *odd,
            *said,
        ],
        refused=refused,
        record=(file, result),
    )
