"""The records of a campaign's tests: true force, then what the machine shows of it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.identify.shape import with_shape
from layerjam.lab import faults
from layerjam.lab.faults import Faults
from layerjam.lab.plan import Subject, Trial, samples, sled_machine
from layerjam.lab.spec import Spec
from layerjam.measure.sidecar import Facts
from layerjam.measure.trace import Array, Trace
from layerjam.units import show

FORMAT = "virtual test machine"
HALVINGS = 60


def gripped(
    stretch: Array,
    vacuum: Array,
    brake: Brake,
    spring: Array,
    overshoot: Array,
    seating: Array,
    machine: Faults,
) -> tuple[Array, Array]:
    """(slip [m], force [N]) at an elongation `stretch` [m] from where the brake is taut, (M, N).

    The sheets' friction begins higher by a part that fades exponentially with slip; grips and caps
    give way under the first load by s(F) = seating (1 - exp(-F/F1)). The elongation is
    slip + F/k + s(F).

    `spring` [N/m], `overshoot` [-] and `seating` [m] have shape (M, 1). Raises QuantityError where
    the friction would fall faster than spring and seat can follow.
    """
    from layerjam.mechanics.friction import sheet_friction
    from layerjam.mechanics.pull import brake_force

    def resists(slip: Array) -> Array:
        more = overshoot * np.exp(-slip / machine.overshoot_slip)
        sheets = np.asarray(sheet_friction(slip, vacuum, brake))
        return np.asarray(brake_force(slip, vacuum, brake)) + more * sheets

    def gives(force: Array) -> Array:
        return force / spring + seating * -np.expm1(-force / machine.seating_force)

    first = resists(np.zeros_like(stretch))
    softest = 1 / spring + seating / machine.seating_force
    if (overshoot * first / machine.overshoot_slip * softest >= 1).any():
        raise QuantityError.of(
            "overshoot",
            "the friction would fall faster than the mount can follow, so that the brake snaps; "
            "let it fade over more slip (machine.overshoot_slip)",
        )
    stuck = _root(lambda force: gives(force) - stretch, np.zeros_like(stretch), first)
    slip = _root(lambda x: x + gives(resists(x)) - stretch, np.zeros_like(stretch), stretch)
    slides = gives(first) < stretch
    slip = np.where(slides, slip, 0.0)
    return slip, np.where(slides, resists(slip), stuck)


def _root(of: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Where a rising function of arrays is zero between two arrays, by bisection."""
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        below = of(middle) < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray((low + high) / 2)


def _column(values: Sequence[float]) -> Array:
    return np.array(values, dtype=float)[:, None]


def pulls_at_once(tests: Sequence[Trial]) -> list[tuple[float, list[Trial]]]:
    """(speed [m/s], pulls of one brake at that speed), for all brakes and speeds."""
    groups: dict[tuple[str, float], list[Trial]] = defaultdict(list)
    for test in tests:
        if test.kind == "pull":
            groups[test.subject.label, test.true_speed].append(test)
    return [(speed, some) for (_, speed), some in groups.items()]


def possible(spec: Spec, tests: Sequence[Trial]) -> None:
    """Raise QuantityError where a pull of the campaign cannot be; quick, without its samples."""
    for speed, some in pulls_at_once(tests):
        turned = (spec.machine.slack + spec.pulls.travel) / speed
        ends = np.array([[0.0, turned, turned + spec.pulls.unload / speed]])
        _pull_force(spec, some, ends)


def pull_traces(spec: Spec, tests: Sequence[Trial], count: int) -> list[Trace]:
    """Pulls of one brake at one speed, all at once."""
    machine, speed = spec.machine, tests[0].true_speed
    numbers = np.array([t.number for t in tests])
    time = faults.moments(machine, spec.seed, numbers, count)
    far = machine.slack + spec.pulls.travel
    travel = speed * time
    travel = far - np.abs(travel - far) if spec.pulls.unload > 0 else travel
    force = _pull_force(spec, tests, np.maximum(time - machine.lag, 0.0))
    shown = faults.shown_force(
        force, time, _column([t.warmer for t in tests]), machine, spec.seed, numbers
    )
    return _traces(spec, machine, tests, time, faults.shown_travel(travel, machine), shown)


def _pull_force(spec: Spec, tests: Sequence[Trial], time: Array) -> Array:
    """True force [N] at moments [s], shape (M, N)."""
    machine, subject, speed = spec.machine, tests[0].subject, tests[0].true_speed
    true = subject.true
    own = float(true.stiffness_measured or 0.0) * _column([t.stiffness for t in tests])
    spring = 1 / (1 / own + machine.compliance)
    stacked = _stacked(true, spring, tests)
    begun = machine.preload / spring
    turned = (machine.slack + spec.pulls.travel) / speed
    rising = np.minimum(time, turned)
    stretch = np.maximum(speed * rising - machine.slack, 0.0) + begun
    vacuum = _column([float(t.true_vacuum or 0.0) for t in tests]) - machine.vacuum_loss * rising
    slip, loaded = _slid(spec, tests, stretch, vacuum, stacked, spring)
    if not np.isfinite(slip).all():
        raise QuantityError.of(
            "pulls.vacuums",
            f"a pull of {subject.label} cannot be; the vacuum stays zero or more "
            "and below what makes the brake snap on its mount",
        )
    back = speed * np.maximum(time - turned, 0.0)
    if spec.pulls.unload > 0:
        _returns(subject, slip, vacuum, stacked)
    # on the return the sheets stick, so that the spring alone relaxes; a brake cannot push
    force = np.maximum(loaded - spring * back, 0.0)
    jerks = faults.saw(np.where(back > 0, 0.0, slip), machine.stick_slip, spring)
    return np.maximum(force + jerks, 0.0)


def _slid(
    spec: Spec, tests: Sequence[Trial], stretch: Array, vacuum: Array, stacked: Brake, spring: Array
) -> tuple[Array, Array]:
    """Slip [m] and force [N] at an elongation of brake, mount and grips, shape (M, N)."""
    from layerjam.mechanics.pull import slip_at_elongation

    slip = np.array(slip_at_elongation(stretch, vacuum, stacked))
    force = spring * (stretch - slip)
    rows = [row for row, test in enumerate(tests) if test.overshoot or test.seating]
    if rows:
        some = [tests[row] for row in rows]
        vacuum = np.broadcast_to(vacuum, stretch.shape)
        slip[rows], force[rows] = gripped(
            stretch[rows],
            vacuum[rows],
            _stacked(tests[0].subject.true, spring[rows], some),
            spring[rows],
            _column([t.overshoot for t in some]),
            _column([t.seating for t in some]),
            spec.machine,
        )
    return slip, force


def _stacked(true: Brake, spring: Array, tests: Sequence[Trial]) -> Brake:
    """The brakes of some tests in one record, what scatters with shape (M, 1)."""
    sheets = _column([t.friction for t in tests])
    sleeve = _column([t.enclosure for t in tests])
    return with_shape(true, true.scale_factor * sheets, spring, sleeve)


def _returns(subject: Subject, slip: Array, vacuum: Array, stacked: Brake) -> None:
    """Refuse a return on which the enclosure would close the brake against its sheets."""
    from layerjam.mechanics.enclosure import enclosure_force
    from layerjam.mechanics.friction import sheet_friction

    end, last = slip[:, -1:], np.broadcast_to(vacuum, slip.shape)[:, -1:]
    sleeve = np.asarray(enclosure_force(end, last, stacked))
    if (sleeve > np.asarray(sheet_friction(end, last, stacked))).any():
        raise QuantityError.of(
            "pulls.unload",
            f"at {show(float(last.min()), 'Pa')} the enclosure of {subject.label} is "
            "stronger than its sheets' friction and would close it on the return; unload at "
            "more vacuum or after less travel",
        )


def friction_trace(spec: Spec, test: Trial) -> Trace:
    """One friction test."""
    from layerjam.mechanics.ageing import aged_static

    own, machine, film = spec.friction, sled_machine(spec), test.subject.true.film
    numbers = np.array([test.number])
    time = faults.moments(machine, spec.seed, numbers, samples(own.travel / own.speed, machine))
    drawn = own.speed * np.maximum(time[0] - machine.lag, 0.0)
    profile = _rough(drawn, faults.generator(spec.seed, "texture", test.number))
    kinetic = film.kinetic * test.friction * own.normal_force
    rested = film.static
    if test.hold is not None:
        rested = float(aged_static(test.hold, test.subject.true))
    static = max(rested * test.static * own.normal_force, kinetic)
    # along the string's stiffness up to the static friction, then the film's own profile
    rising = own.string_stiffness * drawn
    sliding = np.maximum.accumulate(rising >= static)
    force = np.where(sliding, kinetic * (1 + own.texture * profile), rising)
    slid = np.maximum(drawn - static / own.string_stiffness, 0.0)
    force = force + faults.saw(slid, own.stick_slip, _column([own.string_stiffness])[0])
    shown = faults.shown_force(
        force[None, :], time, _column([test.warmer]), machine, spec.seed, numbers
    )
    travel = faults.shown_travel(own.speed * time, machine)
    return _traces(spec, machine, [test], time, travel, shown)[0]


def _rough(travel: Array, random: np.random.Generator) -> Array:
    """A random profile of standard deviation one that changes over about 1 mm, shape (N,)."""
    knots = np.arange(0.0, travel[-1] + 2e-3, 1e-3)
    return np.interp(travel, knots, random.standard_normal(len(knots)))


def _traces(
    spec: Spec, machine: Faults, tests: Sequence[Trial], time: Array, travel: Array, force: Array
) -> list[Trace]:
    """The records of tests, samples lost and stamps repeated."""
    out = []
    for row, test in enumerate(tests):
        keep = faults.kept(machine, spec.seed, test.number, force.shape[1])
        columns = [force[row], travel[row], time[row]]
        if keep is not None:
            columns = [c[keep] for c in columns]
        stamps = faults.shown_stamps(columns[2], machine, spec.seed, test.number)
        facts = Facts(
            vacuum=test.vacuum,
            speed=test.speed,
            repeat=test.repeat,
            brake=test.subject.name,
            normal_force=spec.friction.normal_force if test.kind == "friction" else None,
            hold=test.hold,
            synthetic=True,
            seed=spec.seed,
        )
        out.append(Trace(columns[0], columns[1], stamps, test.name, FORMAT, facts=facts))
    return out
