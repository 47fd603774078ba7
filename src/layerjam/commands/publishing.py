"""The dataset that `publish` writes."""

import os
import shutil
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.commands.dataset_stages import changed_options, derive_results, describe_dataset
from layerjam.commands.declare import Progress
from layerjam.commands.left_out import SEPARATOR
from layerjam.commands.measurements import Measurements
from layerjam.commands.quantities import AnyBrake, convert_brake
from layerjam.commands.report import HowTested
from layerjam.dataset import campaign as campaigns
from layerjam.dataset import checksums
from layerjam.dataset.crate import BRAKE, LINE, METADATA, RAW, REPORT, RESULTS
from layerjam.dataset.people import Details
from layerjam.dataset.recipe import RECIPE, Recipe, list_program_versions
from layerjam.device.file import BrakeFile
from layerjam.errors import FileError, Notice
from layerjam.fluid.file import load_line
from layerjam.identify.provenance import sha256
from layerjam.system import check_file_name, report_failure
from layerjam.toml_files.folders import make_hidden_folder, replace_folder, write_files

if TYPE_CHECKING:
    from layerjam.report.brake_report import BrakeReport


def write_dataset(
    folder: Path,
    out: Path,
    brake: AnyBrake | None,
    line: str | Path | None,
    measurements: Measurements,
    methods: HowTested,
    details: Details,
    overwrite: bool,
    tell: Progress,
) -> tuple[BrakeFile, dict[str, Any]]:
    """Write a dataset, completely or not at all, unless a check fails.

    Returns the tested brake and {key of the result: value}.
    """
    from layerjam.report import page

    page.require_extras()
    notices = details.notices()
    _check_writable(folder, out, overwrite)
    tell("examining the files", 0.0)
    campaign = campaigns.read_campaign(folder, methods.options)
    file = _find_brake(brake, campaign, methods.atmosphere)
    uses = _group_by_use(campaign, measurements)
    line_text = None if line is None else load_line(line).text
    with (
        report_failure(out, "cannot be written"),
        make_hidden_folder(out.absolute().parent) as hidden,
    ):
        staging = hidden / "dataset"
        _copy_files(campaign, staging)
        texts = {BRAKE: file.text or file.render(file.name), LINE: line_text}
        write_files(staging, {name: text for name, text in texts.items() if text is not None})
        try:
            recipe, content = _write_results(staging, campaign, uses, methods, details, tell)
        except FileError as err:
            raise _relocate_error(err, staging, folder) from None
        stops = bool(content.verdict.failed)
        if not stops:
            replace_folder(staging, out)
    return file, dict(
        folder=None if stops else str(out),
        files=[] if stops else checksums.list_files(out),
        friction_tests=len(recipe.friction),
        calibrated_on=len(recipe.calibrate),
        validated_on=len(recipe.validate),
        crate=None if stops else str(out / METADATA),
        checksums=None if stops else str(out / checksums.NAME),
        fingerprint=None if stops else sha256(out / checksums.NAME),
        report=None if stops else str(out / REPORT / "report.html"),
        licence=details.licence,
        authors=[vars(author) for author in details.authors],
        refused={name: reason for name, _, reason in content.refused},
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
    campaign: campaigns.Campaign,
    uses: Measurements,
    methods: HowTested,
    details: Details,
    tell: Progress,
) -> "tuple[Recipe, BrakeReport]":
    """Compute the results from the raw files, and write them next to the raw files."""
    options = changed_options(methods)
    if "exclude" in options:
        exclusions = options["exclude"].items()
        options["exclude"] = {_dataset_path(campaign, name): reason for name, reason in exclusions}
    friction, calibration_pulls, test_pulls = _find_used_files(staging, uses, methods, tell)
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
    recipe, content = derive_results(staging, recipe, staging, tell)
    description = describe_dataset(staging, checksums.list_files(staging), recipe, details, content)
    write_files(staging, {METADATA: description})
    sums = checksums.format_checksums(staging, checksums.list_files(staging))
    write_files(staging, {checksums.NAME: sums})
    return recipe, content


def _dataset_path(campaign: campaigns.Campaign, name: str) -> str:
    """Return the path of a file or specimen inside the dataset; a bare name is unchanged."""
    path, separator, specimen = name.partition(SEPARATOR)
    try:
        (relative,) = campaigns.relative_paths(campaign.folder, [path])
    except FileError:
        return name
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
    brake: AnyBrake | None, campaign: campaigns.Campaign, atmosphere: float | None
) -> BrakeFile:
    if brake is None:
        brake_name = campaigns.find_brake(campaign)
        inside = campaign.folder / brake_name
        brake = inside if brake_name in campaign.brakes else brake_name
    return convert_brake(brake, atmosphere)


def _group_by_use(campaign: campaigns.Campaign, request: Measurements) -> Measurements:
    """Return the files by use, as paths inside the campaign's folder."""
    lists = {
        f.name: list(
            campaigns.relative_paths(campaign.folder, _make_list(getattr(request, f.name)))
        )
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


def _copy_files(campaign: campaigns.Campaign, staging: Path) -> None:
    for name in campaign.files:
        target = staging / RAW / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(campaign.folder / name, target)


def _find_used_files(
    staging: Path, uses: Measurements, methods: HowTested, tell: Progress
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
    calibration_pulls, test_pulls = request.split_pulls(methods.options, tell)
    return [
        tuple(Path(str(p)).relative_to(staging).as_posix() for p in _make_list(files))
        for files in (request.friction, calibration_pulls, test_pulls)
    ]
