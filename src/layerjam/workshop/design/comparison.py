"""Force per mass of brakes, compared with published devices (paper III-F, Fig. 12)."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

from layerjam.brake.device.brake import mass, sheet_mass
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.pull import peak
from layerjam.brake.simulate.prediction import Prediction
from layerjam.core.units import show
from layerjam.workshop.design.force_density import (
    SheetLine,
    added_sheet_effect,
    make_sheet_line,
    peak_force,
)
from layerjam.workshop.design.published import PublishedDevice, PublishedDevices, published_devices

KIND = "layer-jamming brake"
PAPER_VACUUM = 94.5e3
"""Vacuum of the paper's tests [Pa], for which the paper states 17.5 N per sheet."""
LOWER = (PAPER_VACUUM, 50e3, 20e3)
STACKED = (2, 5, 10)
OF_SOME = {
    "vacuum": None,
    "sheets": None,
    "brakes": 1,
    "torque": None,
    "lever": None,
    "calibrated": None,
    "intervals": None,
    "basis": None,
    "basis_reason": "",
}
"""Fields that are known only for the brakes computed here, or only for rotary devices."""


def compare_devices(
    brakes: Sequence[BrakeFile], vacuums: Sequence[float], of_mean: bool = False
) -> tuple[list[dict[str, Any]], dict[str, Any], list[SheetLine], PublishedDevices]:
    """Return (rows, effect of one more sheet, lines of sheet counts, published devices).

    `vacuums` [Pa] has one value per brake. The first brake also has rows at lower vacuums, and for
    several such brakes in parallel. With `of_mean`, intervals are those of the mean of many tests.
    """
    others = published_devices()
    first, full_vacuum = brakes[0], vacuums[0]
    cases = [
        *((file, p, 1) for file, p in zip(brakes, vacuums, strict=True)),
        *((first, p, 1) for p in LOWER if p < full_vacuum),
        *((first, full_vacuum, count) for count in STACKED),
    ]
    rows = [_make_brake_row(Prediction(f, p, of_mean=of_mean), p, n) for f, p, n in cases]
    rows += [
        _device_row(
            d.name, d.kind, d.mass, d.force, d.source(), d.note, torque=d.torque, lever=d.lever
        )
        for d in others.devices
    ]
    lines = [make_sheet_line(f.name, f.brake, p) for f, p in zip(brakes, vacuums, strict=True)]
    return rows, _sheet_effect(first, others.sheet), lines, others


def _device_row(
    name: str, kind: str, mass: float, force: float, source: str, note: str, **more: Any
) -> dict[str, Any]:
    """Return the row of a device: mass [kg], force [N], and fields known only for some devices."""
    row = {"name": name, "kind": kind, "mass": mass, "max_force": force}
    row |= {"force_density": force / mass, "source": source, "note": note, "computed": False}
    return {**row, **OF_SOME, **more}


def _make_brake_row(prediction: Prediction, vacuum: float, brakes: int) -> dict[str, Any]:
    """Return the row of some brakes in parallel, from the prediction for one at a vacuum [Pa]."""
    file, brake = prediction.file, prediction.file.brake
    arrangement = f", {brakes} in parallel" if brakes > 1 else ""
    mass_basis = "a balance" if brake.weighed_mass is not None else "sheets, enclosure and fittings"
    factor = file.sources.get("scale_factor")
    forces = brakes * peak(vacuum, brake.sheets.usable_travel, prediction.brakes).force
    factor_note = f"; scale factor {brake.scale_factor:g}, {factor.sentence()}" if factor else ""
    return _device_row(
        f"{file.name}{arrangement}, {show(vacuum, 'Pa', 4)}",
        KIND,
        brakes * mass(brake),
        brakes * peak_force(brake, vacuum),
        f"computed: peak of a pull; mass from {mass_basis}{factor_note}",
        _friction_note(file),
        computed=True,
        vacuum=vacuum,
        sheets=brake.sheets.count,
        brakes=brakes,
        calibrated=file.is_calibrated,
        intervals={
            "max_force": prediction.interval(forces),
            "force_density": prediction.interval(forces / (brakes * mass(brake))),
        },
        basis=prediction.basis.word,
        basis_reason=prediction.basis.reason,
    )


def describe_overlaps(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return which of these brakes may have a different order in tests, or an empty text.

    `rows` are those of different brakes; two neighbours in the order of maximum force are named if
    their 95 % intervals overlap.
    """
    rows_by_force = sorted(rows, key=lambda row: -row["max_force"])
    pairs = []
    for strong, weak in itertools.pairwise(rows_by_force):
        low, high = (
            row["intervals"]["max_force"][end] for row, end in ((strong, "low"), (weak, "high"))
        )
        if low is None or high is None or low <= high:
            pairs.append(f"{strong['name']} and {weak['name']}")
    if not pairs:
        return ""
    return (
        f"the 95 % intervals of the maximum force overlap for {'; '.join(pairs)}: "
        "a test may show the other order"
    )


def _friction_note(file: BrakeFile) -> str:
    source = file.sources.get("film.kinetic")
    if source is None or source.kind not in ("handbook", "assumed", "unstated"):
        return ""
    conflict = f": {source.conflict}" if source.conflict else ""
    return f"friction not measured on this brake ({source.kind}){conflict}"


def _sheet_effect(file: BrakeFile, paper: PublishedDevice) -> dict[str, Any]:
    """Return the effect of one more sheet at the paper's vacuum, and the paper's values for it."""
    vacuum = min(PAPER_VACUUM, file.brake.site.atmosphere)
    force, weight = added_sheet_effect(file.brake, vacuum)
    return {
        "brake": file.name,
        "vacuum": vacuum,
        "force_per_sheet": force,
        "mass_per_sheet": weight,
        "density_per_sheet": force / weight,
        "sheet_mass": sheet_mass(file.brake),
        "paper_force": paper.force,
        "paper_mass": paper.mass,
        "paper_density": paper.density,
        "paper_words": paper.words,
        "why": "layerjam includes the enclosure that grows around the sheet; the paper's mass "
        "is that of the bare sheet",
    }
