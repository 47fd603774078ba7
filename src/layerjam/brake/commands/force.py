"""`force` and `vacuum`: the force at a vacuum, and the vacuum for a force."""

from typing import Annotated, Any

from layerjam.brake.commands.arguments import (
    Array,
    Atmosphere,
    BrakeInput,
    Confidence,
    Forces,
    Interval,
    OtherFilm,
    Slips,
    Vacuums,
    check_vacuum,
    slip_notices,
)
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.command.declare import Help, command
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.results import Figure, fact, number, result
from layerjam.core.command.wording import format_share
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import QuantitySpec
from layerjam.core.units import show as in_words

SLIDING_SPEED = QuantitySpec("m/s", "sliding speed of the sheets", hi=100, example="500mm/s")
SlidingSpeed = Annotated[float | None, SLIDING_SPEED, Help("Sliding speed of the sheets.")]


@result
class BrakeForce(PredictionResult):
    """Forces of the sliding brake, numbers or arrays of the broadcast shape.

    `record` is (BrakeFile, vacuum, slip).
    """

    record: tuple[BrakeFile, float | Array, float | Array]
    sheet_friction: float = number("N", "friction of the jammed sheets, eq. 4 and 7")
    enclosure_force: float = number("N", "force of the enclosure, eq. 5")
    force: float = number("N", "total force of the brake")

    def draw(self) -> Figure:
        """Return force versus slip, with the slip marked; for arrays, versus their first axis."""
        from layerjam.brake.figures import force_figures

        if self.grid is not None:
            return self.draw_panes(self.grid.panes("force", self.force, "N"))
        file, *case = self.record
        return force_figures.plot_force_slip(file, *map(float, case))


@command("predict")
def force(
    brake: BrakeInput,
    *,
    slip: Slips,
    vacuum: Vacuums,
    sliding_speed: SlidingSpeed = None,
    atmosphere: Atmosphere = None,
    film: OtherFilm = None,
    interval: Interval = "next",
) -> BrakeForce:
    """Compute the force of the sliding brake at a slip and a vacuum.

    Arrays of slip and vacuum broadcast. Without a `sliding_speed` it is the force at the speed at
    which friction was measured. Raises QuantityError for a slip beyond the overlap or a vacuum
    above atmospheric pressure.
    """
    from layerjam.brake.mechanics.enclosure import enclosure_force
    from layerjam.brake.mechanics.friction import sheet_friction, sheet_friction_at
    from layerjam.brake.simulate.prediction import Prediction
    from layerjam.brake.simulate.speed import list_force_notices

    check_vacuum(vacuum, brake.brake)
    notices = slip_notices(slip, brake.brake)

    def find_forces(device: Any) -> dict[str, Any]:
        sheets = (
            sheet_friction(slip, vacuum, device)
            if sliding_speed is None
            else sheet_friction_at(slip, sliding_speed, vacuum, device)
        )
        enclosure = enclosure_force(slip, vacuum, device)
        return {"sheet_friction": sheets, "enclosure_force": enclosure, "force": sheets + enclosure}

    forces = {name: _convert_to_numbers(value) for name, value in find_forces(brake.brake).items()}
    _check_fitted_strain(forces["enclosure_force"], vacuum, brake.brake)
    prediction = Prediction(brake, vacuum, slip, sliding_speed, of_mean=interval == "mean")
    return BrakeForce(
        **forces,
        **prediction.state(**find_forces(prediction.brakes)),
        warnings=[
            *brake.warnings(),
            *notices,
            *list_force_notices(brake, sliding_speed),
            *prediction.notices(),
        ],
        record=(brake, vacuum, slip),
    )


def _check_fitted_strain(enclosure: Any, vacuum: Any, device: Any) -> None:
    """Raise an error if a hyperelastic enclosure is stretched beyond the fitted strain."""
    import numpy as np

    from layerjam.brake.mechanics.effects import has_single_modulus

    if has_single_modulus(device) or np.isfinite(enclosure).all():
        return
    from layerjam.brake.mechanics.hyperelastic import largest_slip

    greatest = float(np.min(largest_slip(vacuum, device)))
    raise QuantityError.of(
        "slip",
        f"above {in_words(greatest, 'm')} the enclosure is stretched beyond the measured "
        f"{device.hyperelastic.strain:.0%} (hyperelastic.strain)",
    )


def _convert_to_numbers(value: Any) -> Any:
    import numpy as np

    array = np.asarray(value)
    return array if array.shape else float(array)


@result
class VacuumForForce(PredictionResult):
    """Vacuum at which the brake resists with a given force, or why there is none.

    `record` is (BrakeFile, slip, force, vacuum).
    """

    record: tuple[BrakeFile, float | Array, float | Array, float | Array]
    safe_vacuum: float | None = number(
        "Pa", "vacuum that gives at least the force in the stated share of tests", default=None
    )
    confidence: float = number("1", "that share of tests", shown=format_share, default=0.95)
    vacuum: float | None = number(
        "Pa", "vacuum that produces the force on average; null if there is none"
    )
    feasible: bool = fact("for each element, whether there is such a vacuum")
    reason: str | None = fact("reason for the first element without such a vacuum")
    least_force: float = number("N", "force of the enclosure alone at that slip")
    greatest_force: float = number("N", "force at the site's full vacuum at that slip")

    def draw(self) -> Figure:
        """Return force versus vacuum, with the force marked; for arrays, vacuum versus force."""
        from layerjam.brake.figures import force_figures

        if self.grid is not None:
            return self.draw_panes(self.grid.panes("vacuum", self.vacuum, "Pa"))
        file, *case = self.record
        return force_figures.plot_force_vacuum(file, *map(float, case))


@command("predict")
def vacuum(
    brake: BrakeInput,
    *,
    slip: Slips,
    force: Forces,
    sliding_speed: SlidingSpeed = None,
    confidence: Confidence = 0.95,
    atmosphere: Atmosphere = None,
    film: OtherFilm = None,
    interval: Interval = "next",
) -> VacuumForForce:
    """Find the vacuum at which the sliding brake resists with a force at a slip.

    `vacuum` does so on average, `safe_vacuum` in the share `confidence` of tests. `feasible` is
    False, with a `reason`, for a force below the enclosure's own or above that at the site's full
    vacuum. Arrays of slip and force broadcast; the vacuum is NaN for elements without one. Without
    a `sliding_speed` the force is that at the speed at which friction was measured.
    """
    import numpy as np

    from layerjam.brake.mechanics.pull import brake_force, force_limits, vacuum_for_force
    from layerjam.brake.simulate.prediction import Prediction
    from layerjam.brake.simulate.speed import list_force_notices

    notices = [*slip_notices(slip, brake.brake), *list_force_notices(brake, sliding_speed)]
    test_file, brake = brake, _apply_sliding_speed(brake, sliding_speed)
    pressure = _convert_to_numbers(vacuum_for_force(force, slip, brake.brake))
    low, high = (_convert_to_numbers(edge) for edge in force_limits(slip, brake.brake))
    feasible = np.isfinite(pressure)
    none = np.ndim(pressure) == 0 and not feasible
    # the reason why there is no vacuum rests on the force at an end of the possible vacuums
    limit = np.where(force < low, 0.0, brake.brake.site.atmosphere)
    conditions = _convert_to_numbers(np.where(feasible, pressure, limit))
    prediction = Prediction(test_file, conditions, slip, sliding_speed, device=brake.brake)

    def find_vacuums(variant: Prediction) -> Any:
        samples = vacuum_for_force(force, slip, variant.brakes)
        enclosure_suffices = force < brake_force(slip, 0.0, variant.brakes)
        samples = np.where(np.isnan(samples), np.inf, samples)
        # a force that no vacuum gives has no interval
        return np.where(feasible, np.where(enclosure_suffices, 0.0, samples), np.nan)

    samples = find_vacuums(prediction)
    safe = prediction.quantiles(samples, confidence)
    interval_source = evolve(prediction, of_mean=True) if interval == "mean" else prediction
    is_safe = feasible & np.isfinite(safe)
    safe = np.where(is_safe, safe, np.nan)
    if (feasible & ~is_safe).any():
        notices.append(_note_unsafe(feasible & ~is_safe, samples, confidence))
    at_full = evolve(interval_source, vacuum=brake.brake.site.atmosphere)
    least_forces, greatest_forces = force_limits(slip, at_full.brakes)
    return VacuumForForce(
        vacuum=None if none else pressure,
        **interval_source.state(
            **({} if none else {"vacuum": find_vacuums(interval_source)}),
            least_force=least_forces,
            greatest_force=greatest_forces,
        ),
        safe_vacuum=_convert_to_numbers(safe) if np.ndim(safe) or np.isfinite(safe) else None,
        confidence=confidence,
        feasible=feasible if np.ndim(pressure) else bool(feasible),
        reason=None
        if feasible.all()
        else _explain_missing_vacuum(brake.brake, slip, force, pressure, low, high),
        least_force=low,
        greatest_force=high,
        warnings=[*brake.warnings(), *notices, *prediction.notices()],
        record=(brake, slip, force, pressure),
    )


def _note_unsafe(is_unsafe: Any, samples: Any, confidence: float) -> Notice:
    """Return the notice that no vacuum gives the first force so marked in enough tests."""
    import numpy as np

    place = np.flatnonzero(is_unsafe)[0]
    share = float(np.mean(np.isfinite(samples.reshape(len(samples), -1)[:, place])))
    return Notice(
        f"no vacuum gives the force in {format_share(confidence)} of the tests: the site's full "
        f"vacuum gives it in {share:.0%} of them",
        "no-safe-vacuum",
    )


def _apply_sliding_speed(file: BrakeFile, speed: Any) -> BrakeFile:
    """Return the file with the friction at a sliding speed [m/s], if one is given."""
    from layerjam.brake.mechanics.speed_effects import fix_speed

    return file if speed is None else evolve(file, brake=fix_speed(speed, file.brake))


def _explain_missing_vacuum(
    device: Any, slip: Any, force: Any, pressure: Any, low: Any, high: Any
) -> str:
    """Return the reason for the first case in which no vacuum exists."""
    import numpy as np

    missing = np.flatnonzero(~np.isfinite(np.ravel(pressure)))[0]
    cases = np.broadcast_arrays(slip, force, low, high)
    x, target, least, greatest = (float(np.ravel(case)[missing]) for case in cases)
    place = f"at {in_words(x, 'm')}"
    if target < least:
        return (
            f"{place} the enclosure alone resists with {in_words(least, 'N')}; no vacuum "
            "reduces this"
        )
    full = in_words(device.site.atmosphere, "Pa", 6)
    return (
        f"{place} this brake reaches at most {in_words(greatest, 'N')}, at the site's full vacuum "
        f"of {full}"
    )
