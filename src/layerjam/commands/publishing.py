"""What `publish` writes."""

from __future__ import annotations

import os
import shutil
import tempfile
import uuid
from collections.abc import Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.commands.dataset_stages import STAGES, USES, computed, options_of
from layerjam.commands.declare import Progress
from layerjam.commands.measurements import Measurements
from layerjam.commands.quantities import AnyBrake, brake_file
from layerjam.commands.report import HowTested
from layerjam.dataset import campaign as campaigns
from layerjam.dataset import checksums, crate
from layerjam.dataset.people import Stated
from layerjam.dataset.recipe import RECIPE, Recipe, versions
from layerjam.device.file import BrakeFile
from layerjam.errors import FileError, FitError, Notice
from layerjam.fluid.file import load_line

if TYPE_CHECKING:
    from layerjam.report.brake_report import BrakeReport

RAW, BRAKE, LINE, FITTED = "data", "brake.toml", "line.toml", "brake-calibrated.toml"
REPORT, RESULTS, README = "report", "report/results.json", "README.md"


def write(
    folder: Path,
    out: Path,
    brake: AnyBrake | None,
    line: str | Path | None,
    measurements: Measurements,
    how: HowTested,
    stated: Stated,
    force: bool,
    tell: Progress,
) -> tuple[BrakeFile, dict[str, Any]]:
    """Write a dataset, whole or not at all, unless a check fails.

    Returns the brake that was tested and the values of the result's keys.
    """
    from layerjam.report import page

    crate.require()  # first: its extra brings the page's too
    page.check_extras()
    notices = stated.notices()
    _writable(folder, out, force)
    tell("looking at the files", 0.0)
    found = campaigns.campaign(folder, how.options)
    file, given = _tested(brake, found, how.atmosphere), _given(found, measurements)
    other = None if line is None else load_line(line).text
    staging = out.absolute().parent / f".layerjam-dataset-{uuid.uuid4().hex}"
    try:
        _copy(found, staging)
        texts = {BRAKE: file.text or file.rendered(file.name), LINE: other}
        _write(staging, {name: text for name, text in texts.items() if text is not None})
        try:
            recipe, content = _computed(staging, given, how, stated, tell)
        except FileError as err:
            raise _where_it_lies(err, staging, folder) from None
        stops = bool(content.verdict.failed)
        if not stops:
            _describe(staging, recipe, stated, content)
            _replace(staging, out)
    except OSError as err:
        raise FileError(out, f"cannot be written: {err.strerror or err}") from None
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    return file, dict(
        folder=None if stops else str(out),
        files=[] if stops else checksums.inside(out),
        friction_tests=len(recipe.friction),
        calibrated_on=len(recipe.calibrate),
        validated_on=len(recipe.validate),
        crate=None if stops else str(out / crate.METADATA),
        checksums=None if stops else str(out / checksums.NAME),
        report=None if stops else str(out / REPORT / "report.html"),
        licence=stated.licence,
        authors=[vars(one) for one in stated.authors],
        refused={name: why for name, _, why in content.refused},
        warnings=[*_notices(content), *notices],
        record=content,
    )


def _where_it_lies(error: FileError, staging: Path, folder: Path) -> FileError:
    """The refusal of a copy, of the user's own file."""
    try:
        own = Path(error.path).relative_to(staging / RAW)
    except ValueError:
        return error
    return FileError(folder / own, error.reason, error.line)


def _notices(content: BrakeReport) -> Iterator[Notice]:
    """What whoever publishes should know of the numbers."""
    if content.synthetic:
        yield Notice("synthetic: written by a program, not measured", "synthetic")
    if content.seen:
        yield Notice(
            "validated on pulls that were also calibrated on, which is no test of the model: hold "
            "some back with --holdout or --calibrate-on",
            "calibrated-on",
        )


def _computed(
    staging: Path, given: Measurements, how: HowTested, stated: Stated, tell: Progress
) -> tuple[Recipe, BrakeReport]:
    """Everything that follows from the raw files, written beside them."""
    from layerjam.report import brake_files

    used = _divided(staging, given, how, tell)
    content = computed(staging, BRAKE, used, how, tell)
    for one in content.verdict.failed:
        raise FitError(f"check '{one.name}' failed: {one.sentence}; nothing was written")
    brake_files.write(content, staging / REPORT, say=lambda what: tell(what, 0.8))
    used, unused = _apart(staging, used, content)
    recipe = Recipe(
        versions=versions(),
        brake=BRAKE,
        results=RESULTS,
        options=options_of(how),
        unused=unused,
        **{use: tuple(files) for use, files in used.items()},
    )
    texts = {RECIPE: recipe.text(), README: _readme(stated, recipe, content)}
    if content.calibration is not None or content.friction is not None:
        texts[FITTED] = content.file.text
    _write(staging, texts)
    _write(staging, {checksums.NAME: checksums.written(staging, checksums.inside(staging))})
    return recipe, content


def _apart(
    staging: Path, used: Mapping[str, list[str]], content: BrakeReport
) -> tuple[dict[str, list[str]], dict[str, str]]:
    """The files that served, by their use, and {path: why} of those that were refused."""
    kept: dict[str, list[str]] = {}
    unused: dict[str, str] = {}
    for use, stage in zip(USES, STAGES, strict=True):
        served = {file.sha256 for file in content.files if file.role == stage}
        why = {name: said for name, at, said in content.refused if at == stage}
        kept[use] = []
        for file in used[use]:
            digest, name = checksums.sha256(staging / file), Path(file).name
            if digest in served or name not in why:
                kept[use].append(file)
                served.discard(digest)  # a second file of the same content was refused
            else:
                unused[file] = why[name]
    return kept, unused


def _write(folder: Path, texts: Mapping[str, str]) -> None:
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")


def _writable(folder: Path, out: Path, force: bool) -> None:
    """Raise FileError where the dataset could not stand at `out`."""
    if os.path.lexists(out):
        if not out.is_dir():
            raise FileError(out, "is a file, not a folder")
        if any(out.iterdir()):
            if not (out / RECIPE).is_file():
                raise FileError(out, "is not empty and no dataset; name another folder")
            if not force:
                raise FileError(out, "exists already; --force replaces it")
    if out.resolve().is_relative_to(folder.resolve()):
        raise FileError(out, f"lies in the campaign's own folder {folder}; name one beside it")


def _tested(
    brake: AnyBrake | None, found: campaigns.Campaign, atmosphere: float | None
) -> BrakeFile:
    """The brake that was tested."""
    if brake is None:
        said = campaigns.brake_of(found)
        inside = found.folder / said
        brake = inside if said in found.brakes else said
    return brake_file(brake, atmosphere)


def _given(found: campaigns.Campaign, asked: Measurements) -> Measurements:
    """The files by their use, as paths inside the campaign's folder."""
    lists = {
        f.name: list(campaigns.within(found.folder, _listed(getattr(asked, f.name))))
        for f in fields(asked)
        if f.name != "holdout"
    }
    if any(lists[use] for use in ("friction", "pulls", "validate")):
        return Measurements(**lists, holdout=asked.holdout)
    lists |= {"friction": list(found.friction), "pulls": list(found.pulls)}
    if not (asked.holdout or lists["calibrate_on"]):
        fitted, others = campaigns.apart(found)
        lists |= {"pulls": fitted or others, "validate": others if fitted else []}
    return Measurements(**lists, holdout=asked.holdout)


def _listed(given: Any) -> list[Any]:
    return [given] if isinstance(given, str | Path) else list(given)


def _copy(found: campaigns.Campaign, staging: Path) -> None:
    for name in found.files:
        target = staging / RAW / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(found.folder / name, target)


def _divided(
    staging: Path, given: Measurements, how: HowTested, tell: Progress
) -> dict[str, list[str]]:
    """{use: paths inside the dataset}."""

    def there(names: Any) -> list[str]:
        return [str(staging / RAW / name) for name in names]

    asked = Measurements(
        friction=there(given.friction),
        pulls=there(given.pulls),
        validate=there(given.validate),
        calibrate_on=there(given.calibrate_on),
        holdout=given.holdout,
    )
    fitted, tested = asked.divided(how.options, tell)
    parts = dict(zip(USES, (asked.friction, fitted, tested), strict=True))
    return {
        use: [Path(str(p)).relative_to(staging).as_posix() for p in _listed(files)]
        for use, files in parts.items()
    }


def _readme(stated: Stated, recipe: Recipe, content: BrakeReport) -> str:
    """What a stranger reads first."""
    lines = [f"# {stated.name}", ""]
    if content.synthetic:
        lines += ["**Synthetic**: files here were written by a program, not measured.", ""]
    for one in content.accepted:
        lines += [f"**Accepted**: {one.notice()}", ""]
    lines += [
        f"Brake: {content.file.name}. {len(recipe.friction)} friction tests, "
        f"{len(recipe.calibrate)} pulls to calibrate on, {len(recipe.validate)} to validate on.",
        *(f"Not used: `{name}`, {why}" for name, why in recipe.unused.items()),
        "",
        f"- `{RAW}/`: the files as they came from the machine, with their sidecars",
        f"- `{BRAKE}`: the brake before, `{FITTED}`: after friction tests and calibration",
        f"- `{REPORT}/report.html`: the page; `{RESULTS}`: every number",
        f"- `{RECIPE}`: which file was used for what, and how",
        f"- `{checksums.NAME}`: `sha256sum --check {checksums.NAME}` finds changed files",
        "",
        "To compute every number again:",
        "",
        f'    pip install "layerjam[report]=={recipe.versions["layerjam"]}"',
        "    layerjam recompute .",
        "",
        f"Licence: {stated.licence or crate.NO_LICENCE}",
        "",
    ]
    return "\n".join(lines)


def _describe(staging: Path, recipe: Recipe, stated: Stated, content: BrakeReport) -> None:
    names = checksums.inside(staging)
    kind = "Synthetic tests" if content.synthetic else "Tests"
    about = crate.About(
        name=stated.name,
        description=f"{kind} of the layer-jamming brake {content.file.name}: "
        f"{len(recipe.friction)} friction tests and {len(recipe.calibrate)} + "
        f"{len(recipe.validate)} pulls (calibration + validation), with all that was computed "
        "from them.",
        date=stated.date,
        licence=stated.licence,
        authors=stated.authors,
        versions=recipe.versions,
        made_from=[recipe.brake, *recipe.friction, *recipe.calibrate, *recipe.validate],
        numbers=[name for name in names if name == FITTED or name.startswith(f"{REPORT}/")],
    )
    digests = {name: checksums.sha256(staging / name) for name in names}
    crate.write_metadata(staging, digests, about)


def _replace(staging: Path, out: Path) -> None:
    """Put the finished folder in its place; the one before is there until the new one is."""
    old = None
    if out.exists():
        old = Path(tempfile.mkdtemp(prefix=".layerjam-old-", dir=out.parent)) / "dataset"
        os.replace(out, old)
    try:
        os.replace(staging, out)
    except OSError:
        if old is not None:
            os.replace(old, out)
        raise
    if old is not None:
        shutil.rmtree(old.parent, ignore_errors=True)
