"""The `reproduce` command: recomputes the paper on one page."""

from pathlib import Path
from typing import Annotated

from layerjam.brake.commands.arguments import Overwrite
from layerjam.core.command.declare import Help, Progress, command
from layerjam.core.command.results import Result, fact, result


@result
class Reproduction(Result):
    """Path of the report, and the number of the paper's claims for each verdict."""

    report: str = fact("path of the page")
    results: str = fact("path of the list of claims")
    reproduced: int = fact("printed numbers that follow from other numbers of the paper")
    consistent: int = fact("claims that agree with other statements and numbers in the paper")
    by_construction: int = fact(
        "claims that agree because the printed value is an input", key="by construction"
    )
    differs: int = fact("claims that other statements and numbers in the paper contradict")
    not_reproducible: int = fact("claims that rest on unpublished data", key="not reproducible")
    ours_to_explain: int = fact(
        "differences that our reading or our assumptions may cause", key="ours to explain"
    )


@command("develop")
def reproduce(
    out: Annotated[str | Path, Help("Folder for the report.", metavar="DIR", option="--out")],
    *,
    overwrite: Overwrite = False,
    progress: Progress | None = None,
) -> Reproduction:
    """Recompute the paper and compare every claim with our result.

    Writes report.html, results.json and the figures. Raises FileError if the report exists and
    `overwrite` is not set, or if the folder cannot be created.
    """
    from layerjam.studies.choi2018.claims import Verdict
    from layerjam.studies.choi2018.paper_report import write_report

    folder = Path(out)
    counts = write_report(folder, overwrite=overwrite, progress=progress)
    return Reproduction(
        report=str(folder / "report.html"),
        results=str(folder / "results.json"),
        reproduced=counts[Verdict.REPRODUCED],
        consistent=counts[Verdict.CONSISTENT],
        by_construction=counts[Verdict.BY_CONSTRUCTION],
        differs=counts[Verdict.DIFFERS],
        not_reproducible=counts[Verdict.NOT_REPRODUCIBLE],
        ours_to_explain=counts[Verdict.OURS],
    )
