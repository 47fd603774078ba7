"""The stages of a dataset, computed from its own files for `publish` and `recompute`."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.commands.declare import Progress
from layerjam.commands.friction import FrictionTest
from layerjam.commands.left_out import LeftOut
from layerjam.commands.measurements import Measurements
from layerjam.commands.quantities import convert_brake, parse_options
from layerjam.commands.reading import FileOptions
from layerjam.commands.report import HowTested, compute_stages
from layerjam.dataset import crate
from layerjam.dataset.campaign import read_campaign
from layerjam.dataset.people import Details
from layerjam.dataset.recipe import RECIPE, Recipe
from layerjam.device.load import load
from layerjam.errors import FileError, LayerjamError
from layerjam.identify.provenance import sha256
from layerjam.report.folder import format_json, to_json
from layerjam.toml_files.folders import write_files
from layerjam.verdict import read_acceptances

if TYPE_CHECKING:
    from layerjam.report.brake_report import BrakeReport

USES = ("friction", "calibrate", "validate")
STAGES = ("friction", "calibration", "validation")


def derive_results(
    root: Path, recipe: Recipe, out: Path, tell: Progress
) -> "tuple[Recipe, BrakeReport]":
    """Write the results of a dataset in `root` to the folder `out`.

    These are the report, calibrated brake, recipe and README. Returns the recipe, including
    rejected files and measurements that no stage uses, and the report. Raises LayerjamError for
    inputs without a result.
    """
    from layerjam.report import brake_files

    settings, facts = read_settings(recipe, root), recipe.stated
    refusals = [(name, entry.get("use")) for name, entry in recipe.unused.items()]
    files = {
        use: [*getattr(recipe, use), *(name for name, stage in refusals if stage == use)]
        for use in USES
    }
    paths = {use: [str(root / name) for name in names] for use, names in files.items()}
    content = compute_stages(
        convert_brake(load(root / recipe.brake), settings.atmosphere),
        Measurements(
            friction=paths["friction"], pulls=paths["calibrate"], validate=paths["validate"]
        ),
        settings,
        tell,
        command="layerjam publish; `layerjam recompute` computes it again",
        date=facts.date if facts else None,
        names={str(root / name): name for names in files.values() for name in names},
    )
    brake_files.write_report(content, out / crate.REPORT, say=lambda what: tell(what, 0.8))
    (friction, pulls, tests), unused = _group_used_files(root, files, content)
    used_names = {name for names in files.values() for name in names}
    for name in read_campaign(root / crate.RAW, settings.options).measurements:
        if f"{crate.RAW}/{name}" not in used_names:
            unused[f"{crate.RAW}/{name}"] = {"use": "", "why": "no stage uses this file"}
    recipe = replace(recipe, friction=friction, calibrate=pulls, validate=tests, unused=unused)
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


def _group_used_files(
    root: Path, files: Mapping[str, Sequence[str]], content: "BrakeReport"
) -> tuple[list[tuple[str, ...]], dict[str, dict[str, str]]]:
    """Return the files used for each use in USES, and {path: use and reason} of rejected files."""
    groups: dict[str, tuple[str, ...]] = {}
    unused: dict[str, dict[str, str]] = {}
    for use, stage in zip(USES, STAGES, strict=True):
        hashes = {file.sha256 for file in content.files if file.role == stage}
        reasons = {name: reason for name, place, reason in content.refused if place == stage}
        for file in files[use]:
            path, name = root / file, Path(file).name
            digest = sha256(path) if path.is_file() else ""
            if digest in hashes or name not in reasons:
                groups[use] = (*groups.get(use, ()), file)
                hashes.discard(digest)  # only one of the files with this content was rejected
            else:
                unused[file] = {"use": use, "why": reasons[name]}
    return [groups.get(use, ()) for use in USES], unused


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
