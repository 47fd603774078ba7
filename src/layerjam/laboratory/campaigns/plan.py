"""The tests of a campaign before simulation: conditions and scatter."""

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import catalogue, load
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.laboratory.campaigns import faults
from layerjam.laboratory.campaigns.faults import Faults, LoadCell
from layerjam.laboratory.campaigns.spec import MOST_SAMPLES, Spec, Truth
from layerjam.laboratory.identify.shape import change_shape


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A brake in the campaign, with its true values."""

    label: str
    """Label in its file names; it contains no "_", which separates the parts of a name."""
    name: str
    """Name in the catalogue, or of the file that is copied into the campaign's folder."""
    file_text: str
    """Text of that file, or "" for a catalogue brake."""
    known: Brake
    """Brake as stated in its file."""
    true: Brake
    """True brake with its stiffness, without scatter, speed law or machine compliance."""
    truth: Truth


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One pull or friction test, with its readings and true values in SI units.

    `kind` is "pull" or "friction"; `name` is the file name without its suffix. `vacuum` is the
    gauge reading and `true_vacuum` its true value, both None in a friction test. `friction`,
    `static`, `stiffness` and `enclosure` are multipliers for the values of the brake or the film.
    `overshoot` is the relative initial excess of the friction, `seating` [m] the settling of grips
    and caps. `speed` is the stated speed, `true_speed` its true value. `warmer` is the temperature
    rise since the first test [K], `practice` the fault in its file, or empty. `odd` marks an
    outlier, and `hold` is the time under load before a friction test [s].
    """

    number: int = 0
    kind: str
    name: str
    subject: Subject
    repeat: int
    speed: float
    vacuum: float | None = None
    true_vacuum: float | None = None
    friction: float = 1.0
    static: float = 1.0
    stiffness: float = 1.0
    enclosure: float = 1.0
    overshoot: float = 0.0
    seating: float = 0.0
    true_speed: float = 0.0
    warmer: float = 0.0
    practice: str = ""
    odd: bool = False
    hold: float | None = None


def plan_tests(spec: Spec) -> tuple[tuple[Subject, ...], tuple[Trial, ...]]:
    """Return the brakes and tests of a checked spec; raises QuantityError for impossible tests."""
    subjects = tuple(_build_subject(truth) for truth in spec.brakes)
    labels = [s.label for s in subjects]
    if len(set(labels)) < len(labels):
        twice = next(label for label in labels if labels.count(label) > 1)
        raise QuantityError.of(
            "brakes.label", f"two brakes have the label '{twice}'; use different labels"
        )
    for subject, vacuum in itertools.product(subjects, spec.pulls.vacuums):
        _check_vacuum(subject, vacuum, spec.machine)
    for speed in spec.pulls.speeds if spec.pulls.vacuums else ():
        sample_count(pull_duration(spec, speed), spec.machine)
    if spec.friction.repeats:
        sample_count(spec.friction.travel / spec.friction.speed, make_sled_machine(spec))
    regular_tests = [*_plan_friction_tests(spec, subjects), *_plan_pulls(spec, subjects)]
    if len({t.name for t in regular_tests}) < len(regular_tests):
        raise QuantityError.of("pulls", "two vacuums or speeds agree to five digits")
    last = max(1, len(regular_tests) - 1)
    tests = [
        _add_scatter(spec, evolve(t, number=n, warmer=spec.machine.warming * n / last))
        for n, t in enumerate(regular_tests)
    ]
    return subjects, _add_outliers(spec, _add_practice_faults(spec, tests))


def _build_subject(truth: Truth) -> Subject:
    from layerjam.brake.mechanics.stiffness import working_stiffness

    file = truth.brake if isinstance(truth.brake, BrakeFile) else load(truth.brake)
    brake = file.brake
    kinetic = truth.kinetic if truth.kinetic is not None else brake.film.kinetic
    static = truth.static if truth.static is not None else brake.film.static
    if kinetic > static:
        raise QuantityError.of(
            "brakes.kinetic",
            f"{kinetic:g} exceeds the static friction, {static:g}; kinetic "
            "friction cannot exceed static friction",
        )
    stiffness = truth.stiffness or float(working_stiffness(brake))
    factor = truth.scale_factor or brake.scale_factor
    true = change_shape(brake, factor, stiffness, truth.enclosure_factor)
    true = evolve(true, film=evolve(true.film, static=static, kinetic=kinetic))
    if truth.ageing is not None:
        aged = evolve(true.film, ageing=truth.ageing, static_hold=truth.static_hold)
        true = evolve(true, film=aged)
    if truth.pressure_exponent is not None:
        true = evolve(
            true, pressure_exponent=truth.pressure_exponent, test_pressure=truth.test_pressure
        )
    label = re.sub(r"[^\w.+-]+|_", "-", truth.label or file.name)
    known_name = isinstance(truth.brake, str) and truth.brake in catalogue()
    return Subject(
        label=label,
        name=file.name,
        file_text="" if known_name else file.text,
        known=brake,
        true=true,
        truth=truth,
    )


def _check_vacuum(subject: Subject, vacuum: float, machine: Faults) -> None:
    atmosphere = subject.true.site.atmosphere
    true = vacuum + machine.vacuum_error
    if not 0 <= true <= atmosphere or vacuum > atmosphere:
        raise QuantityError.of(
            "pulls.vacuums",
            f"a gauge reading of {show(vacuum, 'Pa', 6)} means {show(true, 'Pa', 6)} in "
            f"{subject.label}; it must be between zero and atmospheric pressure, "
            f"{show(atmosphere, 'Pa', 6)}",
        )


def pull_duration(spec: Spec, speed: float) -> float:
    """Return the duration of a pull [s]."""
    return (spec.machine.slack + spec.pulls.travel + spec.pulls.unload) / speed


def sample_count(lasts: float, machine: Faults) -> int:
    """Return the number of samples of one test."""
    count = int(np.floor(lasts * machine.sampling_rate * (1 + 1e-12))) + 1
    if not 10 <= count <= MOST_SAMPLES:
        raise QuantityError.of(
            "sampling_rate",
            f"a test of {show(lasts, 's')} at {machine.sampling_rate:g} Hz has "
            f"{count} samples; 10 to {MOST_SAMPLES} are allowed",
        )
    return count


def make_sled_machine(spec: Spec) -> Faults:
    """Return the machine with the load cell of the friction tests."""
    cell = {f.name: getattr(spec.friction, f.name) for f in fields(LoadCell)}
    steady = {"force_drift": 0.0, "zero_per_kelvin": 0.0}
    jitter = min(spec.machine.jitter, 0.2 / spec.friction.sampling_rate)
    return evolve(spec.machine, **cell, **steady, jitter=jitter)


def _plan_pulls(spec: Spec, subjects: Sequence[Subject]) -> Iterator[Trial]:
    numbers = _pad_numbers(spec.pulls.repeats)
    loops = (subjects, spec.pulls.vacuums, spec.pulls.speeds, numbers)
    for subject, vacuum, speed, number in itertools.product(*loops):
        yield Trial(
            kind="pull",
            name=f"pull_{subject.label}_{vacuum / 1e3:.5g}kPa_{speed * 1e3:.5g}mms_{number}",
            subject=subject,
            repeat=int(number),
            speed=speed,
            true_speed=speed,
            vacuum=vacuum,
            true_vacuum=vacuum + spec.machine.vacuum_error,
            overshoot=spec.machine.overshoot,
            seating=spec.machine.seating,
        )


def _plan_friction_tests(spec: Spec, subjects: Sequence[Subject]) -> Iterator[Trial]:
    tests = spec.friction
    hold_times: Sequence[float | None] = tests.holds or (None,)
    for subject, hold, number in itertools.product(
        subjects, hold_times, _pad_numbers(tests.repeats)
    ):
        ending = number if hold is None else f"hold{hold:.5g}s_{number}"
        yield Trial(
            kind="friction",
            name=f"friction_{subject.label}_{ending}",
            subject=subject,
            repeat=int(number),
            speed=tests.speed,
            hold=hold,
        )


def _pad_numbers(repeats: int) -> list[str]:
    """Return 1, 2, 3 and so on as texts of equal length, so that file names sort correctly."""
    return [f"{n:0{len(str(repeats))}d}" for n in range(1, repeats + 1)]


def _add_scatter(spec: Spec, test: Trial) -> Trial:
    shared = test.kind == "pull" and spec.scatter.per == "repeat"
    # tests of a brake with the same repeat number share the draws of an unused test number
    brake = next(n for n, t in enumerate(spec.brakes) if t is test.subject.truth)
    place = 10**6 * (brake + 1) + test.repeat if shared else test.number
    draws = faults.make_rng(spec.seed, "scatter", place).standard_normal(3)
    warm = 1 + spec.machine.friction_per_kelvin * test.warmer
    if test.kind == "friction":
        sizes = (spec.friction.kinetic_scatter, spec.friction.static_scatter)
        kinetic, static = (float(faults.factors(s, d)) for s, d in zip(sizes, draws, strict=False))
        return evolve(test, friction=kinetic * warm, static=static * warm)
    parts = (spec.scatter.friction, spec.scatter.stiffness, spec.scatter.enclosure)
    sheets, spring, sleeve = (
        float(faults.factors(s, d)) for s, d in zip(parts, draws, strict=True)
    )
    truth = test.subject.truth
    faster = float(np.exp(truth.speed_slope * np.log10(test.speed / truth.speed_reference)))
    return evolve(test, friction=sheets * warm * faster, stiffness=spring, enclosure=sleeve)


def _add_practice_faults(spec: Spec, tests: list[Trial]) -> tuple[Trial, ...]:
    pulls = [t.number for t in tests if t.kind == "pull"]
    order = faults.make_rng(spec.seed, "practice", 0).permutation(len(pulls)).tolist()
    for fault, count in vars(spec.practice).items():
        for _ in range(count):
            number = pulls[order.pop()]
            tests[number] = evolve(tests[number], practice=fault)
    return tuple(tests)


def _add_outliers(spec: Spec, tests: Sequence[Trial]) -> tuple[Trial, ...]:
    """Return the tests, with some pulls, or all pulls at some vacuums, turned into outliers."""
    outlier_spec = spec.odd
    places: dict[tuple[object, ...], list[int]] = {}
    for test in tests:
        if test.kind == "pull":
            key = (
                (test.subject.label, test.vacuum)
                if outlier_spec.per == "vacuum"
                else (test.number,)
            )
            places.setdefault(key, []).append(test.number)
    order = faults.make_rng(spec.seed, "odd", 0).permutation(len(places)).tolist()
    members = [*places.values()]
    outliers = {number for place in order[: outlier_spec.how_many] for number in members[place]}
    return tuple(_make_outlier(spec, test) if test.number in outliers else test for test in tests)


def _make_outlier(spec: Spec, test: Trial) -> Trial:
    outlier_spec, atmosphere = spec.odd, test.subject.true.site.atmosphere
    vacuum = (test.true_vacuum or 0.0) * (1 + outlier_spec.vacuum_change)
    if vacuum > atmosphere:
        raise QuantityError.of(
            "odd.vacuum_change",
            f"{outlier_spec.vacuum_change:g} changes {show(test.vacuum or 0.0, 'Pa', 6)} to "
            f"{show(vacuum, 'Pa', 6)}; a vacuum cannot exceed atmospheric pressure, "
            f"{show(atmosphere, 'Pa', 6)}",
        )
    return evolve(
        test,
        odd=True,
        true_vacuum=vacuum,
        true_speed=test.speed * (1 + outlier_spec.speed_change),
        friction=test.friction * (1 + outlier_spec.friction_change),
        stiffness=test.stiffness * (1 + outlier_spec.stiffness_change),
        overshoot=outlier_spec.overshoot or test.overshoot,
        seating=outlier_spec.seating or test.seating,
    )
