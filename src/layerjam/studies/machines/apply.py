"""The `scenario` command: checks whether a machine with brakes, from a scenario file, can work."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.brake.commands.arguments import Overwrite
from layerjam.core.command.declare import Help, Input, Progress, command
from layerjam.core.command.results import Result, fact, number, result
from layerjam.core.command.wording import format_words
from layerjam.core.errors import QuantityError, make_notices
from layerjam.core.evolve import evolve

if TYPE_CHECKING:
    from layerjam.studies.machines.verdict import Result as Machine


@result
class MachineResult(Result):
    """A machine's requirements on its brakes, and whether the brakes meet them.

    `record` is the machine's own result, with its scenario.
    """

    record: "Machine | None" = None
    machine: str | None = fact("kind of machine", default=None)
    scenario: str | None = fact("name of the scenario", default=None)
    feasible: bool | None = fact("whether every limit is met", default=None)
    reason: str | None = fact("the deciding limit", default=None, listed=False)
    conclusion: str | None = fact(
        ("the conclusion, with the requirements"), default=None, listed=False
    )
    brakes_needed: int | None = fact("brakes required; null if no number is enough", default=None)
    mass: float | None = number("kg", "mass of all brakes in the scenario", default=None)
    limits: Sequence[Mapping[str, Any]] | None = fact(
        "every limit: actual value, allowed value, whether it is met", default=None, listed=False
    )
    page: str | None = fact("path of the page that was written", default=None)
    results: Mapping[str, Any] | None = fact(
        "results specific to the machine", default=None, listed=False
    )
    scenarios: Sequence[str] | None = fact("built-in scenarios", default=None, listed=False)
    titles: Mapping[str, str] | None = None
    """{scenario: title} of the listed scenarios."""

    @property
    def units(self) -> dict[str, str]:
        """Return {key: SI unit}, including the machine's own results."""
        return {**super().units, **({} if self.record is None else self.record.own_units)}

    def rows(self) -> list[tuple[str, str]]:
        """Return the rows, including the machine's own results."""
        units = self.units
        machine_rows = [
            (name.replace("_", " "), format_words(value, units.get(name, "")))
            for name, value in (self.results or {}).items()
            if value is not None
        ]
        return [*super().rows(), *machine_rows]

    def pictures(self, progress: Progress) -> list[tuple[str, str]]:
        """Return (SVG text, caption) of each drawing on the machine's page, in order."""
        from layerjam.core.drawing.style import format_svg
        from layerjam.studies.machines.page import draw_pictures

        drawings = []
        for picture in draw_pictures(self.record) if self.record else ():
            progress(f"figure {picture.name}", 0.0)
            drawings.append((format_svg(picture.figure(), words=True), picture.caption))
        return drawings

    def lines(self) -> Iterator[str]:
        """Yield every limit and the verdict, or the names of the scenarios."""
        yield from self.scenarios or ()
        if self.record is None:
            return
        yield from ("", "limits")
        for limit in self.record.limits:
            yield f"  {'met' if limit.is_met else 'MISSED'}: {limit.sentence()}"
        yield from ("", str(self.conclusion))


@command("develop")
def scenario(
    scenario: Annotated[
        str | Path | None,
        Input("Name of a scenario, or path of its TOML file.", metavar="SCENARIO"),
    ] = None,
    *,
    out: Annotated[
        str | Path | None, Help("Folder for a page with figures.", metavar="DIR")
    ] = None,
    names: Annotated[bool, Help("List the built-in scenarios.", option="--list")] = False,
    overwrite: Overwrite = False,
    progress: Progress | None = None,
) -> MachineResult:
    """Check a machine of the paper's Fig. 13 against its limits.

    Machines are a seat belt, neck guard, ankle clutch and rehabilitation orthosis; a scenario
    contains loads and limits. With `out`, a page with figures is written to that folder (`page`).
    `feasible` states whether all `limits` are met, `reason` names the decisive one, and
    `conclusion` summarises the requirements. `brakes_needed` is None if no number of brakes is
    enough. `results` has the machine's own keys, `units` the unit of each. Raises FileError for an
    invalid file, QuantityError for values out of bounds.
    """
    from layerjam.core.drawing.folder import check_folder
    from layerjam.core.drawing.page import require_extras
    from layerjam.studies.machines import page
    from layerjam.studies.machines.registry import load_scenario

    if names:
        titles = {name: load_scenario(name).title for name in machines()}
        return MachineResult(scenarios=list(titles), titles=titles)
    if scenario is None:
        raise QuantityError(f"choose a scenario: {', '.join(machines())}, or a TOML file")
    machine = load_scenario(scenario)
    if out is not None:
        require_extras()
        check_folder(Path(out), overwrite)
    tell: Progress = progress or (lambda *_: None)
    tell(f"machine {machine.machine}", 0.0)
    analysis = machine.analyse()
    summary = MachineResult(
        machine=machine.machine,
        scenario=machine.name,
        feasible=analysis.feasible,
        reason=analysis.reason,
        conclusion=analysis.verdict,
        brakes_needed=analysis.brakes_needed,
        mass=analysis.mass,
        limits=[limit.row() for limit in analysis.limits],
        results=analysis.own,
        warnings=make_notices(dict.fromkeys([*analysis.warnings, *machine.warnings()])),
        record=analysis,
    )
    if out is None:
        return summary
    return evolve(summary, page=str(page.write_page(analysis, summary.json(), Path(out), tell)))


def machines() -> list[str]:
    """Names of the scenarios that come with the program."""
    from layerjam.studies.machines.registry import scenarios

    return scenarios()
