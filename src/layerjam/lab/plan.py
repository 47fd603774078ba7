"""The tests of a campaign before anything is simulated: which, at what, and what scatters."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.device.load import catalogue, load
from layerjam.errors import QuantityError
from layerjam.lab import faults
from layerjam.lab.faults import Faults
from layerjam.lab.spec import MOST_SAMPLES, Spec, Truth
from layerjam.units import show


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A brake of the campaign as it truly is."""

    label: str
    """In the names of its files, where "_" stands between the parts and so not in a label."""
    name: str
    """Of the catalogue; a brake from elsewhere has its file copied into the campaign's folder."""
    copied: str
    """The text of that file; empty for one of the catalogue."""
    known: Brake
    """As its file says."""
    true: Brake
    """Its stiffness is stated; without scatter, speed law and the machine's compliance."""
    truth: Truth


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One pull or friction test: what the gauge says, and what was so. SI units."""

    number: int
    kind: str
    """"pull" or "friction"."""
    name: str
    """Of its file, without the ending."""
    subject: Subject
    repeat: int
    speed: float
    vacuum: float | None
    """What the gauge shows; None in a friction test."""
    true_vacuum: float | None
    friction: float
    """Factor on the sheets' (or the film's kinetic) friction in this test."""
    static: float
    """Factor on the film's static friction; 1 in a pull."""
    stiffness: float
    """Factor on the stiffness; 1 in a friction test."""
    enclosure: float
    """Factor on the sleeve's force; 1 in a friction test."""
    warmer: float
    """Temperature above that of the first test [K]."""
    practice: str = ""
    """The practice fault of its file; empty for none."""


def planned(spec: Spec) -> tuple[tuple[Subject, ...], tuple[Trial, ...]]:
    """The brakes and all tests of a checked spec; QuantityError for what cannot be."""
    subjects = tuple(_subject(truth) for truth in spec.brakes)
    labels = [s.label for s in subjects]
    if len(set(labels)) < len(labels):
        twice = next(label for label in labels if labels.count(label) > 1)
        raise QuantityError.of(
            "brakes.label", f"'{twice}' names two brakes; give each its own label"
        )
    for subject, vacuum in itertools.product(subjects, spec.pulls.vacuums):
        _vacuum_allowed(subject, vacuum, spec.machine)
    for speed in spec.pulls.speeds if spec.pulls.vacuums else ():
        samples(duration(spec, speed), spec.machine)
    if spec.friction.repeats:
        samples(spec.friction.travel / spec.friction.speed, sled_machine(spec))
    plain = [*_friction_tests(spec, subjects), *_pulls(spec, subjects)]
    if len({t.name for t in plain}) < len(plain):
        raise QuantityError.of("pulls", "two vacuums or speeds are alike to five digits")
    last = max(1, len(plain) - 1)
    tests = [
        _scattered(spec, replace(t, number=n, warmer=spec.machine.warming * n / last))
        for n, t in enumerate(plain)
    ]
    return subjects, _with_practice(spec, tests)


def _subject(truth: Truth) -> Subject:
    from layerjam.mechanics.stiffness import working_stiffness

    file = truth.brake if isinstance(truth.brake, BrakeFile) else load(truth.brake)
    known = file.brake
    kinetic = truth.kinetic if truth.kinetic is not None else known.film.kinetic
    static = truth.static if truth.static is not None else known.film.static
    if kinetic > static:
        raise QuantityError.of(
            "brakes.kinetic",
            f"{kinetic:g} is more than the static friction, {static:g}; kinetic "
            "friction is at most the static one",
        )
    # modulus and friction of the sleeve by the same factor: its force at every slip by that factor
    sleeve = truth.enclosure_factor
    film = replace(
        known.film,
        static=static,
        kinetic=kinetic,
        friction_on_silicone=known.film.friction_on_silicone * sleeve,
    )
    stiffness = truth.stiffness or float(working_stiffness(known))
    true = replace(
        known,
        film=film,
        enclosure=replace(known.enclosure, modulus=known.enclosure.modulus * sleeve),
        scale_factor=truth.scale_factor or known.scale_factor,
        stiffness_measured=stiffness,
    )
    if truth.pressure_exponent is not None:
        true = replace(
            true, pressure_exponent=truth.pressure_exponent, test_pressure=truth.test_pressure
        )
    label = re.sub(r"[^\w.+-]+|_", "-", truth.label or file.name)
    known_name = isinstance(truth.brake, str) and truth.brake in catalogue()
    return Subject(
        label=label,
        name=file.name,
        copied="" if known_name else file.text,
        known=known,
        true=true,
        truth=truth,
    )


def _vacuum_allowed(subject: Subject, vacuum: float, machine: Faults) -> None:
    atmosphere = subject.true.site.atmosphere
    true = vacuum + machine.vacuum_error
    if not 0 <= true <= atmosphere or vacuum > atmosphere:
        raise QuantityError.of(
            "pulls.vacuums",
            f"{show(vacuum, 'Pa', 6)} shown is {show(true, 'Pa', 6)} in the brake "
            f"{subject.label}; that is at least zero and at most the atmosphere, "
            f"{show(atmosphere, 'Pa', 6)}",
        )


def duration(spec: Spec, speed: float) -> float:
    """Of a pull [s]."""
    return (spec.machine.slack + spec.pulls.travel + spec.pulls.unload) / speed


def samples(lasts: float, machine: Faults) -> int:
    """Samples of one test."""
    count = int(np.floor(lasts * machine.sampling_rate * (1 + 1e-12))) + 1
    if not 10 <= count <= MOST_SAMPLES:
        raise QuantityError.of(
            "sampling_rate",
            f"a test of {show(lasts, 's')} at {machine.sampling_rate:g} Hz has "
            f"{count} samples; 10 to {MOST_SAMPLES} are allowed",
        )
    return count


def sled_machine(spec: Spec) -> Faults:
    """The machine with the friction tests' own load cell."""
    own = spec.friction
    return replace(
        spec.machine,
        sampling_rate=own.sampling_rate,
        force_noise=own.force_noise,
        force_offset=own.force_offset,
        load_cell_range=own.load_cell_range,
        force_step=own.force_step,
        force_drift=0.0,
        zero_per_kelvin=0.0,
        jitter=min(spec.machine.jitter, 0.2 / own.sampling_rate),
    )


def _pulls(spec: Spec, subjects: Sequence[Subject]) -> Iterator[Trial]:
    numbers = _numbers(spec.pulls.repeats)
    loops = (subjects, spec.pulls.vacuums, spec.pulls.speeds, numbers)
    for subject, vacuum, speed, number in itertools.product(*loops):
        at = f"{subject.label}_{vacuum / 1e3:.5g}kPa_{speed * 1e3:.5g}mms"
        yield _test("pull", at, number, subject, speed, vacuum, vacuum + spec.machine.vacuum_error)


def _friction_tests(spec: Spec, subjects: Sequence[Subject]) -> Iterator[Trial]:
    for subject, number in itertools.product(subjects, _numbers(spec.friction.repeats)):
        yield _test("friction", subject.label, number, subject, spec.friction.speed)


def _numbers(repeats: int) -> list[str]:
    """1, 2, ... of equal length, so that files sort."""
    return [f"{n:0{len(str(repeats))}d}" for n in range(1, repeats + 1)]


def _test(
    kind: str,
    at: str,
    number: str,
    subject: Subject,
    speed: float,
    vacuum: float | None = None,
    true_vacuum: float | None = None,
) -> Trial:
    """A test without scatter."""
    return Trial(
        number=0,
        kind=kind,
        name=f"{kind}_{at}_{number}",
        subject=subject,
        repeat=int(number),
        speed=speed,
        vacuum=vacuum,
        true_vacuum=true_vacuum,
        friction=1.0,
        static=1.0,
        stiffness=1.0,
        enclosure=1.0,
        warmer=0.0,
    )


def _scattered(spec: Spec, test: Trial) -> Trial:
    """The test with its own draw of what scatters."""
    shared = test.kind == "pull" and spec.scatter.per == "repeat"
    # draws of one repeat number of a brake are those of a test that has no number of its own
    brake = next(n for n, t in enumerate(spec.brakes) if t is test.subject.truth)
    place = 10**6 * (brake + 1) + test.repeat if shared else test.number
    draws = faults.generator(spec.seed, "scatter", place).standard_normal(3)
    warm = 1 + spec.machine.friction_per_kelvin * test.warmer
    if test.kind == "friction":
        sizes = (spec.friction.kinetic_scatter, spec.friction.static_scatter)
        kinetic, static = (float(faults.spread(s, d)) for s, d in zip(sizes, draws, strict=False))
        return replace(test, friction=kinetic * warm, static=static * warm)
    each = (spec.scatter.friction, spec.scatter.stiffness, spec.scatter.enclosure)
    sheets, spring, sleeve = (float(faults.spread(s, d)) for s, d in zip(each, draws, strict=True))
    truth = test.subject.truth
    faster = float(np.exp(truth.speed_slope * np.log10(test.speed / truth.speed_reference)))
    return replace(test, friction=sheets * warm * faster, stiffness=spring, enclosure=sleeve)


def _with_practice(spec: Spec, tests: list[Trial]) -> tuple[Trial, ...]:
    """The tests, some pulls among them marked with a practice fault."""
    pulls = [t.number for t in tests if t.kind == "pull"]
    drawn = faults.generator(spec.seed, "practice", 0).permutation(len(pulls)).tolist()
    for what, count in vars(spec.practice).items():
        for _ in range(count):
            number = pulls[drawn.pop()]
            tests[number] = replace(tests[number], practice=what)
    return tuple(tests)
