"""The stages of a dataset, computed from its own files for `publish` and `recompute`."""

from collections.abc import Iterable
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.brake.commands.arguments import convert_brake, parse_options
from layerjam.brake.device.load import load
from layerjam.core.command.declare import Progress
from layerjam.core.drawing.folder import format_json, to_json
from layerjam.core.errors import FileError, LayerjamError
from layerjam.core.toml_files.folders import write_files
from layerjam.core.verdict import read_acceptances
from layerjam.laboratory.commands.friction import FrictionTest
from layerjam.laboratory.commands.left_out import LeftOut
from layerjam.laboratory.commands.measurements import Measurements
from layerjam.laboratory.commands.reading import FileOptions
from layerjam.laboratory.commands.stages import HowTested, compute_stages
from layerjam.laboratory.dataset import crate
from layerjam.laboratory.dataset.campaign_folder import read_campaign
from layerjam.laboratory.dataset.people import Details
from layerjam.laboratory.dataset.recipe import FORMAT, RECIPE, USES, Recipe, Unused
from layerjam.laboratory.identify.provenance import rename_files

if TYPE_CHECKING:
    from layerjam.laboratory.figures.brake_report import BrakeReport

STAGES = ("friction", "calibration", "validation")


def derive_results(
    root: Path, recipe: Recipe, out: Path, progress: Progress
) -> "tuple[Recipe, BrakeReport]":
    """Write the results of a dataset in `root` to the folder `out`.

    These are the report, calibrated brake, recipe and README. Returns the recipe, including
    the files that a stage left out and measurements that no stage uses, and the report. Raises
    LayerjamError for inputs without a result.
    """
    from layerjam.laboratory.figures import brake_files

    settings, facts = read_settings(recipe, root), recipe.stated
    paths = {use: [str(root / name) for name in getattr(recipe, use)] for use in USES}
    sources = dict.fromkeys(name for use in USES for name in getattr(recipe, use))
    names = {str(root / name): name for name in sources}
    content = compute_stages(
        convert_brake(load(root / recipe.brake), settings.atmosphere),
        Measurements(
            friction=paths["friction"], pulls=paths["calibrate"], validate=paths["validate"]
        ),
        settings,
        progress,
        command="layerjam publish; `layerjam recompute` computes it again",
        date=facts.date if facts else None,
        names=names,
    )
    brake_files.write_report(content, out / crate.REPORT, progress=lambda what: progress(what, 0.8))
    measurements = read_campaign(root / crate.RAW, settings.options).measurements
    idle = (name for name in (f"{crate.RAW}/{m}" for m in measurements) if name not in sources)
    recipe = replace(
        recipe,
        format=FORMAT,
        unused=(
            *_list_unused(content),
            *(Unused(file=name, use="", why="no stage uses this file") for name in idle),
        ),
    )
    texts = {RECIPE: recipe.text()}
    if facts is not None:
        texts[crate.README] = crate.format_readme(
            recipe, facts, content.file.name, content.synthetic, content.accepted
        )
    if content.calibration is not None or content.friction is not None:
        texts[crate.FITTED] = content.file.text
    write_files(out, texts)
    return recipe, content


def describe_dataset(
    root: Path, files: Iterable[str], recipe: Recipe, details: Details, content: "BrakeReport"
) -> str:
    """Return the text of ro-crate-metadata.json for these files of a dataset in `root`."""
    brake, synthetic = content.file.name, content.synthetic
    return format_json(crate.make_crate_metadata(root, files, recipe, details, brake, synthetic))


def _list_unused(content: "BrakeReport") -> list[Unused]:
    """Return the files and specimens that a stage rejected or excluded, with the reasons."""
    use_of, names = dict(zip(STAGES, USES, strict=True)), content.names
    return [
        Unused(file=rename_files(path, names), use=use_of[stage], why=rename_files(reason, names))
        for path, stage, reason in (
            *content.refused,
            *((row["file"], row["stage"], row["because"]) for row in content.excluded),
        )
    ]


def changed_options(methods: HowTested) -> dict[str, Any]:
    """Return {name in Python: value} of the options that differ from their defaults."""
    options = {
        f.name: getattr(record, f.name)
        for record in (methods.test, methods.options)
        for f in fields(record)
        if getattr(record, f.name) != f.default
    }
    for name in ("depth", "vacuum", "atmosphere"):
        if getattr(methods, name) != getattr(HowTested(), name):
            options[name] = getattr(methods, name)
    reasons = methods.left_out.reasons()
    if reasons:
        options["exclude"] = reasons
    if methods.accept:
        options["accept"] = methods.accept
    return dict(to_json(options))


def read_settings(recipe: Recipe, root: Path) -> HowTested:
    """Return the settings with which a dataset's files were read and fitted.

    Raises FileError for invalid settings.
    """
    options = dict(recipe.options)
    own_names = {f.name for f in fields(HowTested)} | {"exclude"}
    try:
        test = {f.name: options.pop(f.name) for f in fields(FrictionTest) if f.name in options}
        reading = {f.name: options.pop(f.name) for f in fields(FileOptions) if f.name in options}
        unknown = [name for name in options if name not in own_names]
        if unknown:
            raise FileError(root / RECIPE, f"unknown option {unknown[0][:60]!r}")
        raw = f"{crate.RAW}/"
        exclude = {
            str(root / name) if name.startswith(raw) else name: reason
            for name, reason in dict(options.get("exclude", {})).items()
        }
        return HowTested(
            test=parse_options(FrictionTest, test),
            options=parse_options(FileOptions, reading),
            depth=options.get("depth", "exact"),
            vacuum=options.get("vacuum"),
            atmosphere=options.get("atmosphere"),
            left_out=LeftOut(exclude=exclude),
            accept=read_acceptances(options.get("accept", {})),
        )
    except (LayerjamError, TypeError, ValueError) as err:
        raise FileError(root / RECIPE, f"options: {err}") from None
