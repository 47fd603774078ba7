"""The stages of a dataset, from its own files: what `publish` and `recompute` have in common."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.commands.declare import Progress, taken
from layerjam.commands.friction import FrictionTest
from layerjam.commands.left_out import LeftOut
from layerjam.commands.measurements import Measurements
from layerjam.commands.reading import FileOptions
from layerjam.commands.report import HowTested, stages
from layerjam.dataset.recipe import RECIPE, Recipe
from layerjam.device.load import load
from layerjam.errors import FileError, LayerjamError
from layerjam.identify.provenance import renamed
from layerjam.report.folder import plain
from layerjam.verdict import read_acceptances

if TYPE_CHECKING:
    from layerjam.report.brake_report import BrakeReport

USES = ("friction", "calibrate", "validate")
STAGES = ("friction", "calibration", "validation")


def computed(
    root: Path, brake: str, used: Mapping[str, Sequence[str]], how: HowTested, tell: Progress
) -> BrakeReport:
    """The stages of a dataset, from its own files."""
    there = {use: [str(root / name) for name in files] for use, files in used.items()}
    measured = Measurements(
        friction=there["friction"], pulls=there["calibrate"], validate=there["validate"]
    )
    names = {str(root / name): name for files in used.values() for name in files}
    said = "layerjam publish; `layerjam recompute` computes it again"
    return stages(load(root / brake), measured, how, tell, command=said, names=names)


def values_of(content: BrakeReport, root: Path, used: Mapping[str, Sequence[str]]) -> Any:
    """The stages' values as JSON has them, files called by their paths inside the dataset."""
    values = plain({stage: content.stages.get(stage) for stage in STAGES})
    return renamed(values, {str(root / name): name for files in used.values() for name in files})


def options_of(how: HowTested) -> dict[str, Any]:
    """{name in Python: value} of what is not usual."""
    made = {
        f.name: getattr(record, f.name)
        for record in (how.test, how.options)
        for f in fields(record)
        if getattr(record, f.name) != f.default
    }
    for name in ("depth", "vacuum"):
        if getattr(how, name) != getattr(HowTested(), name):
            made[name] = getattr(how, name)
    reasons = how.left_out.reasons()
    if reasons:
        made["exclude"] = reasons
    if how.accept:
        made["accept"] = how.accept
    return dict(plain(made))


def how_of(recipe: Recipe, root: Path) -> HowTested:
    """How the files of a dataset were read and fitted; raises FileError for what cannot be."""
    said = dict(recipe.options)
    own = {f.name for f in fields(HowTested)} | {"exclude"}
    try:
        test = {f.name: said.pop(f.name) for f in fields(FrictionTest) if f.name in said}
        reading = {f.name: said.pop(f.name) for f in fields(FileOptions) if f.name in said}
        unknown = [name for name in said if name not in own]
        if unknown:
            raise FileError(root / RECIPE, f"option {unknown[0][:60]!r} is not known here")
        return HowTested(
            test=taken(FrictionTest, test),
            options=taken(FileOptions, reading),
            depth=said.get("depth", "exact"),
            vacuum=said.get("vacuum"),
            left_out=LeftOut(exclude=said.get("exclude", ())),
            accept=read_acceptances(said.get("accept", {})),
        )
    except (LayerjamError, TypeError, ValueError) as err:
        raise FileError(root / RECIPE, f"options: {err}") from None
