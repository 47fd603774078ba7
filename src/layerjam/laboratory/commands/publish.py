"""`publish` and `recompute`: a campaign as a dataset, and a check of its numbers."""

import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.brake.commands.arguments import Accept, AnyBrake, Atmosphere, Overwrite
from layerjam.core.command.declare import Help, Input, Progress, command
from layerjam.core.command.results import Result, fact, number, result
from layerjam.core.errors import MissingExtraError, Notice, QuantityError
from layerjam.core.system import format_command_line
from layerjam.core.units import show
from layerjam.core.verdict import Verdict
from layerjam.laboratory.commands.friction import FrictionTest
from layerjam.laboratory.commands.left_out import LeftOut
from layerjam.laboratory.commands.measurements import Measurements
from layerjam.laboratory.commands.reading import FileOptions, FileVacuum
from layerjam.laboratory.commands.stages import HowTested

if TYPE_CHECKING:
    from layerjam.laboratory.dataset.text_comparison import Difference
    from layerjam.laboratory.figures.brake_report import BrakeReport

CITED = 16
"""Smallest number of digits of a cited fingerprint."""
SHOWN = 6
"""Number of differences per file that the table lists."""
Author = Annotated[
    Sequence[str], Help("Author, with the ORCID iD if known.", metavar="NAME[,ORCID]")
]


def _format_names(files: Sequence[str]) -> str:
    ellipsis = ", ..." if len(files) > 4 else ""
    return f"{len(files)}" + (f": {', '.join(files[:4])}{ellipsis}" if files else "")


@result
class Published(Result):
    """Result of writing a dataset; `record` is the BrakeReport."""

    record: "BrakeReport | None" = None
    folder: str | None = fact("folder of the dataset; null if it was not written")
    files: Sequence[str] = fact("dataset files", shown=lambda files: f"{len(files)} in the folder")
    friction_tests: int = number("1", "friction tests")
    calibrated_on: int = number("1", "pulls used to calibrate the brake")
    validated_on: int = number("1", "pulls used to validate the brake")
    crate: str | None = fact("description of the dataset for repositories")
    checksums: str | None = fact("SHA-256 of every file")
    fingerprint: str | None = fact("digest of the checksums, which changes if any file changes")
    report: str | None = fact("page of the dataset")
    licence: str | None = fact("licence")
    authors: Sequence[Mapping[str, str]] = fact("authors", listed=False)
    refused: Mapping[str, str] = fact("files not used, with reasons", listed=False)

    def lines(self) -> Iterator[str]:
        """Yield the command with which others can check the dataset, and that it is this one."""
        if self.folder is not None:
            cited = (self.fingerprint or "")[:CITED]
            words = ("layerjam", "recompute", self.folder, "--fingerprint", cited)
            yield from ("", "anyone who is given the fingerprint can check it:")
            yield f"  {format_command_line(words)}"


@command("share")
def publish(
    campaign: Annotated[str | Path, Help("Folder with the measurements.", metavar="CAMPAIGN")],
    *,
    out: Annotated[
        str | Path, Help("Folder to write: a new one, or an existing dataset.", metavar="DIR")
    ],
    brake: Annotated[
        AnyBrake | None,
        Input("Brake that was tested, if the folder does not state it.", metavar="BRAKE"),
    ] = None,
    line: Annotated[
        str | Path | None, Help("Vacuum line used in the tests.", metavar="LINE")
    ] = None,
    measurements: Measurements = Measurements(),
    test: FrictionTest = FrictionTest(),
    depth: Annotated[
        Literal["exact", "curves"], Help("Calibrate on peaks, or on whole curves.")
    ] = "exact",
    vacuum: FileVacuum = None,
    atmosphere: Atmosphere = None,
    left_out: LeftOut = LeftOut(),
    accept: Accept = None,
    options: FileOptions = FileOptions(),
    title: Annotated[str | None, Help("Name of the dataset.", metavar="TEXT")] = None,
    licence: Annotated[
        str | None, Help("Licence of the data, such as CC-BY-4.0.", metavar="SPDX")
    ] = None,
    author: Author = (),
    overwrite: Overwrite = False,
    progress: Progress | None = None,
) -> Published:
    """Write one campaign as a self-contained dataset, so that others can recompute its numbers.

    The raw files are copied unchanged, with their sidecars and all other files in the folder
    `campaign`. The dataset adds brake and line, report, results, recipe, checksums, and a
    description that repositories read (RO-Crate 1.1). A measurement that states a normal force is a
    friction test, any other a pull; a calibrated brake in the folder lists its calibration pulls;
    without one, `measurements` does, as in `report`. If a check fails, nothing is written; `accept`
    accepts failed checks by name, {check: reason}, and the dataset states them. Raises FileError if
    neither the folder nor `brake` states which brake was tested, or if `out` exists and is not a
    dataset to be replaced with `overwrite`.
    """
    from layerjam.laboratory.commands.publishing import write_dataset
    from layerjam.laboratory.dataset.people import Details, parse_author

    with MissingExtraError.raise_if_missing("a published dataset (pypdfium2)", "publish"):
        import pypdfium2  # noqa: F401
    settings = HowTested(
        test=test,
        depth=depth,
        vacuum=vacuum,
        atmosphere=atmosphere,
        left_out=left_out,
        accept=accept,
        options=options,
    )
    facts = Details(
        name=title or f"Tests of a layer-jamming brake: {Path(campaign).resolve().name}",
        licence=licence,
        authors=[parse_author(text) for text in ([author] if isinstance(author, str) else author)],
        date=datetime.now(UTC).date().isoformat(),
    )
    tell = progress or (lambda _what, _share: None)
    file, record = write_dataset(
        Path(campaign), Path(out), brake, line, measurements, settings, facts, overwrite, tell
    )
    return Published.create(record["record"].verdict, **record).with_verdicts([file])


@result
class Recomputed(Result):
    """Whether a dataset's numbers were reproduced; `record` is the list of differences."""

    record: "list[Difference] | None" = None
    equal: bool | None = fact(
        "whether every number and every file is as published; null if a part was not compared"
    )
    numbers: int = number("1", "numbers compared")
    differs: Sequence[Mapping[str, Any]] = fact(
        "numbers and texts that differ", shown=lambda found: str(len(found))
    )
    changed_files: Sequence[str] = fact("files that are not as published", shown=_format_names)
    added_files: Sequence[str] = fact(
        "files without a checksum", shown=lambda found: _format_names(found) if found else ""
    )
    not_compared: Mapping[str, str] = fact(
        "parts of files not compared, with reasons", listed=False
    )
    fingerprint: str | None = fact("digest of the checksums, which changes if any file changes")
    versions: Mapping[str, Mapping[str, str]] = fact("program versions then and now", listed=False)

    @property
    def exit_code(self) -> int:
        """Exit code: 1 if anything differs or was not compared."""
        return 0 if self.equal else 1

    def rows(self) -> list[tuple[str, str]]:
        """Return (name, text) of each row; the first is the answer."""
        answer = [] if self.equal is not None else [("equal", "not comparable")]
        return [*answer, *super().rows()]

    def lines(self) -> Iterator[str]:
        """Yield the first differences of each file, the parts not compared, and the versions."""
        original, local = self.versions["published"], self.versions["recomputed"]
        for file in dict.fromkeys(row["file"] for row in self.differs):
            rows = [row for row in self.differs if row["file"] == file]
            yield from ("", f"{file}: published, recomputed, relative difference")
            for row in rows[:SHOWN]:
                share = "" if row["share"] is None else f", {show(row['share'], '1', 2)}"
                yield f"  {row['number']}: {_format_number(row['published'])}, " + (
                    f"{_format_number(row['recomputed'])}{share}"
                )
            if len(rows) > SHOWN:
                yield f"  and {len(rows) - SHOWN} more (--json lists all)"
        if self.not_compared:
            yield from ("", "not compared:")
        yield from (f"  {file}: {reason}" for file, reason in self.not_compared.items())
        yield ""
        for name in dict.fromkeys((*original, *local)):
            original_version = original.get(name, "not stated")
            local_version = local.get(name, "not installed here")
            yield f"{name} {original_version}" + (
                "" if original_version == local_version else f", here {local_version}"
            )


def _format_number(value: Any) -> str:
    return "none" if value is None else f"{value:.9g}" if isinstance(value, float) else str(value)


@command("share")
def recompute(
    dataset: Annotated[
        str | Path, Help("Folder or zip file created by `publish`.", metavar="DIR|FILE.zip")
    ],
    *,
    fingerprint: Annotated[
        str | None, Help("Cited fingerprint, or at least its first 16 digits.", metavar="SHA256")
    ] = None,
    progress: Progress | None = None,
) -> Recomputed:
    """Recompute a published dataset from its raw files, and list everything that differs.

    Numbers, tables, page, PDF, figures, calibrated brake and description are recomputed. Numbers
    count as the same up to a relative difference of 1e-6. A file that does not match its checksum,
    has no checksum or is missing is always reported. If different versions of the programs wrote
    the dataset, text and drawings may differ; then only their numbers are compared,
    `not_compared` lists the rest, and `equal` is None. Inputs such as raw files, licence and
    authors cannot be recomputed; give the cited `fingerprint` to detect changes in them. Nothing is
    written. Raises FileError for a folder that is not a dataset.
    """
    from layerjam.laboratory.commands.recomputing import recompute_dataset

    cited = None if fingerprint is None else fingerprint.strip().lower()
    if cited is not None and not re.fullmatch(rf"[0-9a-f]{{{CITED},64}}", cited):
        raise QuantityError.of(
            "fingerprint", f"'{cited[:70]}' is not {CITED} to 64 hexadecimal digits of a SHA-256"
        )
    outcome = recompute_dataset(Path(dataset), cited, progress or (lambda _what, _share: None))
    original, local = outcome["versions"]["published"], outcome["versions"]["recomputed"]
    notices = []
    if outcome["equal"] is False and original != local:
        sentence = "computed with different versions; these, not the data, may explain a "
        notices.append(Notice(f"{sentence}difference", "other-versions"))
    if cited is None:
        sentence = (
            "raw files, notes, the brake before the tests, licence and authors are inputs: only "
            "the fingerprint shows whether they were changed; compare it with the cited one"
        )
        notices.append(Notice(f"{sentence} (--fingerprint)", "fingerprint"))
    verdict = Verdict(decisions=outcome.pop("decisions"))
    return Recomputed.create(verdict, **outcome, warnings=notices)
