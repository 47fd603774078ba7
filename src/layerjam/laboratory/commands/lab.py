"""`lab`: practice files of a whole campaign, with known true values and machine faults."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from layerjam.brake.commands.arguments import Overwrite
from layerjam.brake.simulate.quantities import SEED
from layerjam.core.command.declare import Help, Progress, command
from layerjam.core.command.description import Block, Lines
from layerjam.core.command.results import Result, fact, number, result
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.store import accept_force_option, store_file
from layerjam.core.system import quote_word
from layerjam.laboratory.campaigns.spec import Spec

if TYPE_CHECKING:
    from layerjam.laboratory.campaigns.campaign import Campaign

PRACTICE = "practice"
"""Name of the built-in campaign."""


@result
class PracticeFiles(Result):
    """Files of a campaign, and the file with the true values; `record` is the Campaign.

    For an example to edit, `text` is the example or explains what to do with its file; all other
    fields are None.
    """

    record: "Campaign | None" = None
    folder: str | None = fact("folder created", default=None)
    files: Sequence[str] | None = fact(
        "files created", default=None, shown=lambda files: f"{len(files)}, each with its sidecar"
    )
    friction_tests: int | None = number("1", "friction tests", default=None)
    pulls: int | None = number("1", "pulls", default=None)
    samples: int | None = number("1", "samples in all files", default=None)
    faulty: int | None = number("1", "files with an intentional fault", default=None)
    seed: int | None = number("1", "seed of the campaign", default=None)
    truth: str | None = fact("file with the true values", default=None)
    next: Sequence[str] | None = fact("commands to try", default=None, listed=False)
    stopped: bool | None = fact(
        "always false: an interrupted command writes nothing", default=None, listed=False
    )
    text: str = ""

    def lines(self) -> Iterator[str]:
        """Yield commands to try with the files."""
        yield from ("", "try:", *(f"  {line}" for line in self.next or ()))

    def describe(self) -> Iterator[Block]:
        """Yield the text of the example or, for a campaign, the table."""
        yield from (
            [Lines(self.text.splitlines(), is_fixed=True)] if self.text else super().describe()
        )

    def json(self) -> str:
        """Return the JSON of the contract; for an example, its text."""
        if not self.text:
            return super().json()
        return json.dumps({"example": self.text, "units": {}, "warnings": []}, indent=2)


@accept_force_option
def lab_example(out: str | Path | None = None, *, overwrite: bool = False) -> str:
    """Write the built-in campaign as commented TOML to edit, into the file `out` if it is given.

    Raises FileError if that exists and `overwrite` is not set.
    """
    from layerjam.laboratory.campaigns.text import example_spec, format_spec

    # replace µ, because Windows shells corrupt it after `>`
    text = format_spec(example_spec()).replace("µ", "u")
    if out is not None:
        if Path(out).suffix != ".toml":
            raise QuantityError(f"out: '{out}' does not end in .toml")
        store_file(out, text, overwrite)
    return text


@command("test")
def lab(
    spec: Annotated[
        str | Path | Spec | None,
        Help("TOML file of the campaign, or 'practice' for the built-in one.", metavar="SPEC"),
    ] = None,
    *,
    out: Annotated[
        str | Path | None,
        Help("New or empty folder to write to; with --example, a .toml file.", metavar="DIR"),
    ] = None,
    example: Annotated[
        bool, Help("Print a commented campaign to edit, or write it to --out.")
    ] = False,
    seed: Annotated[int | None, SEED, Help("Random seed, instead of the campaign's own.")] = None,
    overwrite: Overwrite = False,
    progress: Progress | None = None,
) -> PracticeFiles:
    """Write practice files of a virtual laboratory, with known true values and machine faults.

    The files of a campaign and the true values are written into the folder `out`. `spec` is the
    path of a TOML file, a Spec, or "practice", which is built in; `seed` replaces the seed in it.
    Every file states that it is synthetic. Raises FileError if `out` is not empty and `overwrite`
    is not set.
    """
    from layerjam.laboratory.campaigns.campaign import campaign
    from layerjam.laboratory.campaigns.campaign_files import suggest_commands, write_campaign
    from layerjam.laboratory.campaigns.text import example_spec as built_in

    if example:
        if spec is not None or seed is not None:
            raise QuantityError("--example: can be combined only with --out and --overwrite")
        text = lab_example(out, overwrite=overwrite)
        if out is not None:
            text = f"Edit it, then: layerjam lab {quote_word(str(out))} --out DIR"
        return PracticeFiles(text=text)
    if spec is None or out is None:
        raise QuantityError(
            "lab: SPEC and --out are needed; layerjam lab --example --out SPEC.toml writes one to "
            "edit, and layerjam lab practice --out DIR needs none"
        )
    shipped = not isinstance(spec, Spec) and str(spec) == PRACTICE and not Path(spec).is_file()
    campaign_record = campaign(built_in() if shipped else spec, seed)
    record = write_campaign(campaign_record, out, overwrite, progress)
    warnings = [Notice("the files are synthetic: written by a program, not measured", "synthetic")]
    if record.strangers:
        count = record.strangers
        count_text = "1 other file" if count == 1 else f"{count} other files"
        verb, were = ("does", "it was") if count == 1 else ("do", "they were")
        were = f"{verb} not belong to this campaign; {were}"
        sentence = f"{count_text} in {record.folder} {were} there before"
        warnings.append(Notice(sentence, "strangers"))
    return PracticeFiles(
        folder=str(record.folder),
        files=[str(p) for p in record.files],
        friction_tests=sum(1 for t in campaign_record.tests if t.kind == "friction"),
        pulls=sum(1 for t in campaign_record.tests if t.kind == "pull"),
        samples=record.samples,
        faulty=sum(1 for t in campaign_record.tests if t.practice),
        seed=campaign_record.spec.seed,
        truth=str(record.folder / "truth.toml"),
        next=suggest_commands(campaign_record, record.folder),
        stopped=False,
        warnings=warnings,
        record=campaign_record,
    )
