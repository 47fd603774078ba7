"""`array`: one slow pull of identical brakes in parallel and in series."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.brake.commands.arguments import (
    Atmosphere,
    BrakeInput,
    Interval,
    OtherFilm,
    check_vacuum,
)
from layerjam.brake.simulate.quantities import ELONGATION, VACUUM
from layerjam.brake.simulate.record import Outcome
from layerjam.core.command.declare import Help, command
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.results import fact, number, result
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.units import QuantitySpec

if TYPE_CHECKING:
    from layerjam.brake.simulate.prediction import Prediction
    from layerjam.core.drawing.chart import Pane
    from layerjam.workshop.design.arrays import ArrayLoading, Totals

PARALLEL = QuantitySpec("1", "chains of brakes in parallel", lo=1, hi=100, whole=True)
SERIES = QuantitySpec("1", "brakes in series in each chain", lo=1, hi=100, whole=True)
BRAKES_LIMIT = 1000
"""Largest number of brakes in one array; `layerjam.Array` accepts more, also different brakes."""


@result
class ArrayPull(PredictionResult):
    """Totals of an array and the outcome of one slow pull; `record` is an ArrayLoading."""

    record: "ArrayLoading"
    brake: str = fact("name of the brake")
    parallel: int = number("1", "chains in parallel")
    series: int = number("1", "brakes in series in each chain")
    brakes: int = number("1", "total number of brakes")
    vacuum: float = number("Pa", "vacuum in all brakes")
    until: float | None = number("m", "target elongation of the pull")
    peak_force: float = number("N", "maximum force of the pull")
    peak_elongation: float = number("m", "elongation at the maximum force")
    force_at_end: float = number("N", "force at the end of the pull")
    end: float = number("m", "elongation at the end of the pull")
    work: float = number("J", "work done in the pull")
    outcome: str = fact("outcome of the pull")
    travel: float = number("m", "travel from slip alone")
    energy: float = number("J", "work of all brakes slipping through their full travel")
    mass: float = number("kg", "total mass of the brakes")
    stiffness: float = number("N/m", "stiffness before slip")
    force_density: float = number("N/kg", "ratio of maximum force to mass")

    def panes(self) -> "Sequence[Pane]":
        """Return the pane of force versus elongation."""
        from layerjam.brake.figures import force_figures
        from layerjam.brake.figures.titles import pull_title

        name = f"{self.parallel} × {self.series} {self.brake}"
        words = pull_title(name, self.record.outcome, self.end)
        return force_figures.pull_panes(self.record, words, "simulated; an even load is assumed")


@command("design")
def array(
    brake: BrakeInput,
    *,
    parallel: Annotated[int, PARALLEL] = 1,
    series: Annotated[int, SERIES] = 1,
    vacuum: Annotated[
        float | None, VACUUM, Help("Vacuum in all brakes. Default: full vacuum at the site.")
    ] = None,
    until: Annotated[
        float | None, ELONGATION, Help("Target elongation. Default: the end of the travel.")
    ] = None,
    atmosphere: Atmosphere = None,
    film: OtherFilm = None,
    interval: Interval = "next",
) -> ArrayPull:
    """Simulate one slow pull of identical brakes in parallel and in series.

    The default vacuum is the site's full vacuum. The pull ends at the elongation `until`, or at the
    end of the travel. `outcome` is FINISHED, BOTTOMED_OUT, or SNAPS if the force of a slipping
    brake falls faster than the brakes in series with it relax. `travel` and `energy` include only
    slip. Parallel brakes are assumed to share the force evenly. Intervals are those of brakes that
    all deviate alike; if each deviates on its own, the array scatters less.
    """
    import numpy as np

    from layerjam.brake.simulate.prediction import Prediction
    from layerjam.workshop.design import arrays

    rows, row = int(parallel), int(series)
    if rows * row > BRAKES_LIMIT:
        raise QuantityError(
            f"array: {rows} by {row} makes {rows * row} brakes; at most {BRAKES_LIMIT} are allowed"
        )
    device = brake.brake
    pressure = device.site.atmosphere if vacuum is None else check_vacuum(vacuum, device)
    member = arrays.Member(brake=device, vacuum=pressure, name=brake.name)
    grid = arrays.grid(member, series=row, parallel=rows)
    totals, pull_record = arrays.totals(grid), arrays.pull(grid, until)
    top = int(np.argmax(pull_record.force))
    notices = [*brake.warnings(), *pull_record.warnings]
    if totals.brakes > 1:
        text = "identical brakes are assumed to share the load evenly, as real ones nearly do"
        notices.append(Notice(text, "even-share"))
    force = float(pull_record.force[top])
    travel, is_mean = device.sheets.usable_travel, interval == "mean"
    prediction = Prediction(brake, pressure, travel, device=device, of_mean=is_mean)
    has_ended = pull_record.outcome is Outcome.BOTTOMED_OUT
    samples = _spread_totals(prediction, pressure, totals, force / rows, (rows, row), has_ended)
    return ArrayPull.create(
        totals,
        **prediction.state(**samples),
        brake=brake.name,
        parallel=rows,
        series=row,
        vacuum=pressure,
        until=until,
        peak_force=force,
        peak_elongation=float(pull_record.elongation[top]),
        force_at_end=float(pull_record.force[-1]),
        end=float(pull_record.elongation[-1]),
        work=float(pull_record.work[-1]),
        outcome=pull_record.outcome.name,
        force_density=force / totals.mass,
        warnings=[*notices, *prediction.notices()],
        record=pull_record,
    )


def _spread_totals(
    prediction: "Prediction",
    vacuum: float,
    totals: "Totals",
    force: float,
    counts: tuple[int, int],
    has_ended: bool,
) -> dict[str, Any]:
    """Return the samples of an array's numbers; `force` [N] is the largest force of a chain.

    `counts` are the chains in parallel and the brakes in each. The peak is known only if the pull
    reached that of its brakes, the force at the end only if all brakes have used up their travel.
    """
    from layerjam.brake.mechanics.energy import slip_work
    from layerjam.brake.mechanics.pull import brake_force, peak
    from layerjam.brake.mechanics.stiffness import working_stiffness

    device, brakes, (parallel, series) = prediction.file.brake, prediction.brakes, counts
    travel = device.sheets.usable_travel
    samples = {"energy": totals.brakes * slip_work(travel, vacuum, brakes)}
    if has_ended:
        end = parallel * brake_force(travel, vacuum, brakes)
        stretch = series * end / (parallel * working_stiffness(brakes))
        samples |= {"force_at_end": end, "work": samples["energy"] + end * stretch / 2}
    if abs(float(peak(vacuum, travel, device).force) - force) <= 1e-6 * force:
        tops = peak(vacuum, travel, brakes)
        samples |= {
            "peak_force": parallel * tops.force,
            "peak_elongation": series * tops.elongation,
        }
        samples["force_density"] = samples["peak_force"] / totals.mass
    return samples
