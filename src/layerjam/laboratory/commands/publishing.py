"""The dataset that `publish` writes."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.brake.commands.arguments import AnyBrake, convert_brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line_file import load_line
from layerjam.core.command.declare import Progress
from layerjam.core.errors import FileError, Notice
from layerjam.core.system import check_file_name, report_failure
from layerjam.core.toml_files.folders import make_hidden_folder, replace_folder, write_files
from layerjam.laboratory.commands.dataset_stages import (
    changed_options,
    derive_results,
    describe_dataset,
)
from layerjam.laboratory.commands.left_out import SEPARATOR
from layerjam.laboratory.commands.measurements import Measurements
from layerjam.laboratory.commands.stages import HowTested
from layerjam.laboratory.dataset import campaign_folder as campaigns
from layerjam.laboratory.dataset import checksums
from layerjam.laboratory.dataset.crate import BRAKE, LINE, METADATA, RAW, REPORT, RESULTS
from layerjam.laboratory.dataset.people import Details
from layerjam.laboratory.dataset.recipe import RECIPE, Recipe, list_program_versions, read_recipe
from layerjam.laboratory.identify.provenance import rename_files, sha256

if TYPE_CHECKING:
    from layerjam.laboratory.figures.brake_report import BrakeReport


def write_dataset(
    folder: Path,
    out: Path,
    brake: AnyBrake | None,
    line: str | Path | None,
    measurements: Measurements,
    methods: HowTested,
    details: Details,
    overwrite: bool,
    progress: Progress,
) -> tuple[BrakeFile, dict[str, Any]]:
    """Write a dataset, completely or not at all, unless a check fails.

    Returns the tested brake and {key of the result: value}.
    """
    from layerjam.core.drawing import page

    page.require_extras()
    notices = details.notices()
    _check_writable(folder, out, overwrite)
    progress("examining the files", 0.0)
    files = campaigns.map_campaign(folder)
    line_text = None if line is None else load_line(line).text
    with (
        report_failure(out, "cannot be written"),
        make_hidden_folder(out.absolute().parent) as hidden,
    ):
        staging = hidden / "dataset"
        (staging / RAW).mkdir(parents=True)
        checksums.copy_files(files, staging / RAW)
        try:
            campaign = campaigns.read_campaign(staging / RAW, methods.options)
            file = _find_brake(brake, campaign, files, methods.atmosphere)
            texts = {BRAKE: file.text or file.render(file.name), LINE: line_text}
            write_files(staging, {name: text for name, text in texts.items() if text is not None})
            uses = _group_by_use(campaign, folder, measurements)
            options = _name_exclusions(changed_options(methods), folder)
            recipe, content = _write_results(staging, uses, options, methods, details, progress)
        except FileError as err:
            raise _relocate_error(err, staging, folder) from None
        has_failed = bool(content.verdict.failed)
        if not has_failed:
            replace_folder(staging, out)
    names = content.names
    return file, dict(
        folder=None if has_failed else str(out),
        files=[] if has_failed else checksums.list_files(out),
        friction_tests=len(recipe.used("friction")),
        calibrated_on=len(recipe.used("calibrate")),
        validated_on=len(recipe.used("validate")),
        crate=None if has_failed else str(out / METADATA),
        checksums=None if has_failed else str(out / checksums.NAME),
        fingerprint=None if has_failed else sha256(out / checksums.NAME),
        report=None if has_failed else str(out / REPORT / "report.html"),
        licence=details.licence,
        authors=[vars(author) for author in details.authors],
        refused={
            rename_files(path, names).removeprefix(f"{RAW}/"): rename_files(reason, names)
            for path, _, reason in content.refused
        },
        warnings=[*_dataset_notices(content), *notices],
        record=content,
    )


def _relocate_error(error: FileError, staging: Path, folder: Path) -> FileError:
    """Return the error about a copied file, reworded for the user's own file."""
    try:
        relative = Path(error.path).relative_to(staging / RAW)
    except ValueError:
        return error
    return FileError(folder / relative, error.reason, error.line)


def _dataset_notices(content: "BrakeReport") -> Iterator[Notice]:
    """Yield notices about the numbers, for the person who publishes them."""
    if content.synthetic:
        yield Notice("synthetic: written by a program, not measured", "synthetic")
    if content.seen:
        yield Notice(
            "validated on pulls that were also used for calibration, which does not test the "
            "model: reserve some with --holdout or --calibrate-on",
            "calibrated-on",
        )


def _write_results(
    staging: Path,
    uses: Measurements,
    options: dict[str, Any],
    methods: HowTested,
    details: Details,
    progress: Progress,
) -> "tuple[Recipe, BrakeReport]":
    """Compute the results from the raw files, and write them next to the raw files."""
    friction, calibration_pulls, test_pulls = _find_used_files(staging, uses, methods, progress)
    recipe = Recipe(
        versions=list_program_versions(),
        brake=BRAKE,
        results=RESULTS,
        options=options,
        stated=details,
        friction=friction,
        calibrate=calibration_pulls,
        validate=test_pulls,
    )
    write_files(staging, {RECIPE: recipe.text()})
    recipe, content = derive_results(staging, read_recipe(staging), staging, progress)
    description = describe_dataset(staging, checksums.list_files(staging), recipe, details, content)
    write_files(staging, {METADATA: description})
    sums = checksums.format_checksums(staging, checksums.list_files(staging))
    write_files(staging, {checksums.NAME: sums})
    return recipe, content


def _name_exclusions(options: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the options with the excluded files named as in the dataset."""
    if "exclude" not in options:
        return options
    exclusions = options["exclude"].items()
    return {**options, "exclude": {_dataset_path(folder, f): reason for f, reason in exclusions}}


def _dataset_path(folder: Path, name: str) -> str:
    """Return the path of a file or specimen inside the dataset; a bare name is unchanged."""
    path, separator, specimen = name.partition(SEPARATOR)
    try:
        (relative,) = campaigns.relative_paths(folder, [path])
    except FileError:
        return checksums.compose_name(name)
    return f"{RAW}/{relative}{separator}{specimen}"


def _check_writable(folder: Path, out: Path, overwrite: bool) -> None:
    """Raise FileError if the dataset cannot be written to `out`."""
    check_file_name(out)
    if os.path.lexists(out):
        if not out.is_dir():
            raise FileError(out, "is a file, not a folder")
        if any(out.iterdir()):
            if not (out / RECIPE).is_file():
                raise FileError(out, "is not empty and is not a dataset; choose a different folder")
            if not overwrite:
                raise FileError(out, "already exists; --overwrite replaces it")
    if out.resolve().is_relative_to(folder.resolve()):
        raise FileError(out, f"is inside the campaign's own folder {folder}; choose one outside it")


def _find_brake(
    brake: AnyBrake | None,
    campaign: campaigns.Campaign,
    files: Mapping[str, Path],
    atmosphere: float | None,
) -> BrakeFile:
    """Return the tested brake, loaded from the user's own file."""
    if brake is None:
        brake_name = campaigns.find_brake(campaign)
        brake = files[brake_name] if brake_name in campaign.brakes else brake_name
    return convert_brake(brake, atmosphere)


def _group_by_use(
    campaign: campaigns.Campaign, folder: Path, request: Measurements
) -> Measurements:
    """Return the names of the files by use; `folder` is the user's own."""
    lists = {
        f.name: list(campaigns.relative_paths(folder, _make_list(getattr(request, f.name))))
        for f in fields(request)
        if f.name != "holdout"
    }
    if any(lists[use] for use in ("friction", "pulls", "validate")):
        return Measurements(**lists, holdout=request.holdout)
    lists |= {"friction": list(campaign.friction), "pulls": list(campaign.pulls)}
    if not (request.holdout or lists["calibrate_on"]):
        calibration_pulls, others = campaigns.split_calibration_pulls(campaign)
        lists |= {
            "pulls": calibration_pulls or others,
            "validate": others if calibration_pulls else [],
        }
    return Measurements(**lists, holdout=request.holdout)


def _make_list(files: Any) -> list[Any]:
    return [files] if isinstance(files, str | Path) else list(files)


def _find_used_files(
    staging: Path, uses: Measurements, methods: HowTested, progress: Progress
) -> list[tuple[str, ...]]:
    """Return the paths inside the dataset for each of USES."""

    def staged_paths(names: Any) -> list[str]:
        return [str(staging / RAW / name) for name in names]

    request = Measurements(
        friction=staged_paths(uses.friction),
        pulls=staged_paths(uses.pulls),
        validate=staged_paths(uses.validate),
        calibrate_on=staged_paths(uses.calibrate_on),
        holdout=uses.holdout,
    )
    calibration_pulls, test_pulls = request.split_pulls(methods.options, progress)
    return [
        tuple(Path(str(p)).relative_to(staging).as_posix() for p in _make_list(files))
        for files in (request.friction, calibration_pulls, test_pulls)
    ]
