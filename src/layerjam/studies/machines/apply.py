"""`apply`: a machine with brakes, from a scenario file, and whether it can work."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.commands.declare import Help, Input, Progress, command
from layerjam.commands.quantities import Overwrite
from layerjam.commands.results import Result, fact, number, result
from layerjam.commands.wording import in_words
from layerjam.errors import QuantityError

if TYPE_CHECKING:
    from layerjam.studies.machines.verdict import Result as Machine


@result
class MachineResult(Result):
    """What a machine needs of its brakes and whether they give it.

    `record` is the machine's own result with its scenario.
    """

    record: Machine | None = None
    machine: str | None = fact("kind of machine", default=None)
    scenario: str | None = fact("name of the scenario", default=None)
    feasible: bool | None = fact("whether every limit is met", default=None)
    reason: str | None = fact("the limit that decides", default=None, listed=False)
    conclusion: str | None = fact("the conclusion, with what is needed", default=None, listed=False)
    brakes_needed: int | None = fact(
        "brakes it would take; null where no number does", default=None
    )
    mass: float | None = number("kg", "mass of all brakes of the scenario", default=None)
    limits: Sequence[Mapping[str, Any]] | None = fact(
        "every limit: its value, what is allowed, whether it is met", default=None, listed=False
    )
    page: str | None = fact("path of the page that was written", default=None)
    results: Mapping[str, Any] | None = fact(
        "the machine's own numbers", default=None, listed=False
    )
    scenarios: Sequence[str] | None = fact(
        "scenarios that come with the program", default=None, listed=False
    )
    titles: Mapping[str, str] | None = None
    """What each of these scenarios is, by name."""

    @property
    def units(self) -> dict[str, str]:
        """{key: SI unit}, those of the machine's own numbers among them."""
        return {**super().units, **({} if self.record is None else self.record.own_units)}

    def rows(self) -> list[tuple[str, str]]:
        """With the machine's own numbers."""
        units = self.units
        own = [
            (name.replace("_", " "), in_words(value, units.get(name, "")))
            for name, value in (self.results or {}).items()
            if value is not None
        ]
        return [*super().rows(), *own]

    def pictures(self, progress: Progress) -> list[tuple[str, str]]:
        """(SVG text, caption) of each drawing of the machine's page, in order; words are text."""
        from layerjam.report.svg import drawn
        from layerjam.studies.machines.page import pictures

        made = []
        for picture in pictures(self.record) if self.record else ():
            progress(f"figure {picture.name}", 0.0)
            made.append((drawn(picture.figure(), words=True), picture.caption))
        return made

    def lines(self) -> Iterator[str]:
        """Every limit and the verdict; or the scenarios' names."""
        yield from self.scenarios or ()
        if self.record is None:
            return
        yield from ("", "limits")
        for limit in self.record.limits:
            yield f"  {'met' if limit.met else 'MISSED'}: {limit.sentence()}"
        yield from ("", str(self.conclusion))


@command(
    "design",
    place=30,
    examples=(
        "layerjam apply seat-belt --out page",
        "layerjam apply --list",
    ),
)
def apply(
    scenario: Annotated[
        str | Path | None,
        Input("Name of a scenario, or path of its TOML file.", metavar="SCENARIO"),
    ] = None,
    *,
    out: Annotated[
        str | Path | None, Help("Folder for a page with pictures.", metavar="DIR")
    ] = None,
    names: Annotated[
        bool, Help("Name the scenarios that come with the program.", option="--list")
    ] = False,
    force: Overwrite = False,
    progress: Progress | None = None,
) -> MachineResult:
    """Check a machine of the paper's Fig. 13 against its limits.

    Seat belt, neck guard, ankle clutch or rehabilitation: its loads, its limits and the honest
    verdict. With `out` a page with pictures is written there (`page`). `feasible` says whether
    every one of `limits` is met, `reason` names the one that decides, `conclusion` says it in a
    sentence or two, with what would be needed; `brakes_needed` is None where no number of brakes
    does. `results` holds the machine's own keys; `units` names the unit of each. Raises FileError
    for a file that is none, QuantityError for values out of bounds.
    """
    from layerjam.report.folder import check_folder
    from layerjam.report.page import check_extras
    from layerjam.studies.machines import page
    from layerjam.studies.machines.registry import load_scenario

    if names:
        titles = {name: load_scenario(name).title for name in machines()}
        return MachineResult(scenarios=list(titles), titles=titles)
    if scenario is None:
        raise QuantityError(f"say which scenario: {', '.join(machines())}, or a TOML file")
    given = load_scenario(scenario)
    if out is not None:
        check_extras()
        check_folder(Path(out), force)
    tell: Progress = progress or (lambda *_: None)
    tell(f"machine {given.machine}", 0.0)
    found = given.analyse()
    made = MachineResult(
        machine=given.machine,
        scenario=given.name,
        feasible=found.feasible,
        reason=found.reason,
        conclusion=found.verdict,
        brakes_needed=found.brakes_needed,
        mass=found.mass,
        limits=[limit.row() for limit in found.limits],
        results=found.own,
        warnings=list(dict.fromkeys([*found.warnings, *given.warnings()])),
        record=found,
    )
    if out is None:
        return made
    return replace(made, page=str(page.write(found, made.json(), Path(out), tell)))


def machines() -> list[str]:
    """Names of the scenarios that come with the program."""
    from layerjam.studies.machines.registry import scenarios

    return scenarios()
