"""Records of a campaign's tests: first the true force, then the readings of the machine."""

from collections import defaultdict
from collections.abc import Callable, Sequence

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.core.errors import QuantityError
from layerjam.core.units import show
from layerjam.laboratory.campaigns import faults
from layerjam.laboratory.campaigns.faults import Faults
from layerjam.laboratory.campaigns.plan import Subject, Trial, make_sled_machine, sample_count
from layerjam.laboratory.campaigns.spec import Spec
from layerjam.laboratory.identify.shape import change_shape
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Array, Trace

FORMAT = "virtual test machine"
HALVINGS = 60


def simulate_gripped_pull(
    stretch: Array,
    vacuum: Array,
    brake: Brake,
    spring: Array,
    overshoot: Array,
    seating: Array,
    machine: Faults,
) -> tuple[Array, Array]:
    """Return (slip [m], force [N]), shape (M, N), at elongations `stretch` [m] of the taut brake.

    `spring` [N/m], `overshoot` [-] and `seating` [m] have shape (M, 1). Raises QuantityError if
    friction would drop faster than spring and seat can follow.
    """
    from layerjam.brake.mechanics.friction import sheet_friction
    from layerjam.brake.mechanics.pull import brake_force

    def excess_force(slip: Array) -> Array:
        excess = overshoot * np.exp(-slip / machine.overshoot_slip)
        sheets = np.asarray(sheet_friction(slip, vacuum, brake))
        return np.asarray(brake_force(slip, vacuum, brake)) + excess * sheets

    def grip_elongation(force: Array) -> Array:
        return force / spring + seating * -np.expm1(-force / machine.seating_force)

    first = excess_force(np.zeros_like(stretch))
    softest = 1 / spring + seating / machine.seating_force
    if (overshoot * first / machine.overshoot_slip * softest >= 1).any():
        raise QuantityError.of(
            "overshoot",
            "the friction would fall faster than the mount relaxes, and the brake would "
            "snap; increase machine.overshoot_slip",
        )
    stuck = _zeros(lambda force: grip_elongation(force) - stretch, np.zeros_like(stretch), first)
    slip = _zeros(
        lambda x: x + grip_elongation(excess_force(x)) - stretch, np.zeros_like(stretch), stretch
    )
    is_sliding = grip_elongation(first) < stretch
    slip = np.where(is_sliding, slip, 0.0)
    return slip, np.where(is_sliding, excess_force(slip), stuck)


def _zeros(function: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Return, by bisection, the zeros of an increasing function between two arrays."""
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        is_negative = function(middle) < 0
        low, high = np.where(is_negative, middle, low), np.where(is_negative, high, middle)
    return np.asarray((low + high) / 2)


def _as_column(values: Sequence[float]) -> Array:
    return np.array(values, dtype=float)[:, None]


def group_pulls(tests: Sequence[Trial]) -> list[tuple[float, list[Trial]]]:
    """Return (speed [m/s], pulls of a brake at that speed) for all brakes and speeds."""
    groups: dict[tuple[str, float], list[Trial]] = defaultdict(list)
    for test in tests:
        if test.kind == "pull":
            groups[test.subject.label, test.true_speed].append(test)
    return [(speed, group) for (_, speed), group in groups.items()]


def check_pulls(spec: Spec, tests: Sequence[Trial]) -> None:
    """Raise QuantityError if a pull is impossible; this is quick: no samples are simulated."""
    for speed, group in group_pulls(tests):
        turn_time = (spec.machine.slack + spec.pulls.travel) / speed
        ends = np.array([[0.0, turn_time, turn_time + spec.pulls.unload / speed]])
        _simulate_pull_force(spec, group, ends)


def simulate_pulls(spec: Spec, tests: Sequence[Trial], count: int) -> list[Trace]:
    """Return the records of one brake's pulls at one speed."""
    machine, speed = spec.machine, tests[0].true_speed
    numbers = np.array([t.number for t in tests])
    time = faults.sample_times(machine, spec.seed, numbers, count)
    end = machine.slack + spec.pulls.travel
    travel = speed * time
    travel = end - np.abs(travel - end) if spec.pulls.unload > 0 else travel
    force = _simulate_pull_force(spec, tests, np.maximum(time - machine.lag, 0.0))
    reading = faults.measured_force(
        force, time, _as_column([t.warmer for t in tests]), machine, spec.seed, numbers
    )
    return _record_traces(
        spec, machine, tests, time, faults.measured_travel(travel, machine), reading
    )


def _simulate_pull_force(spec: Spec, tests: Sequence[Trial], time: Array) -> Array:
    """Return the true force [N] at times [s], shape (M, N)."""
    machine, subject, speed = spec.machine, tests[0].subject, tests[0].true_speed
    true = subject.true
    stiffness = float(true.stiffness_measured or 0.0) * _as_column([t.stiffness for t in tests])
    spring = 1 / (1 / stiffness + machine.compliance)
    brakes = _batch_brakes(true, spring, tests)
    start = machine.preload / spring
    turn_time = (machine.slack + spec.pulls.travel) / speed
    rising = np.minimum(time, turn_time)
    stretch = np.maximum(speed * rising - machine.slack, 0.0) + start
    vacuum = _as_column([float(t.true_vacuum or 0.0) for t in tests]) - machine.vacuum_loss * rising
    slip, rising_force = _compute_slip_and_force(spec, tests, stretch, vacuum, brakes, spring)
    if not np.isfinite(slip).all():
        raise QuantityError.of(
            "pulls.vacuums",
            f"a pull of {subject.label} is impossible; the vacuum must be zero or more "
            "and below the value at which the brake snaps on its mount",
        )
    return_travel = speed * np.maximum(time - turn_time, 0.0)
    if spec.pulls.unload > 0:
        _check_return_stroke(subject, slip, vacuum, brakes)
    # on the return stroke the sheets stick and only the spring relaxes; a brake cannot push
    force = np.maximum(rising_force - spring * return_travel, 0.0)
    jerks = faults.saw_force(np.where(return_travel > 0, 0.0, slip), machine.stick_slip, spring)
    return np.maximum(force + jerks, 0.0)


def _compute_slip_and_force(
    spec: Spec, tests: Sequence[Trial], stretch: Array, vacuum: Array, brakes: Brake, spring: Array
) -> tuple[Array, Array]:
    """Return slip [m] and force [N], (M, N), at the total elongation of brake, mount and grips."""
    from layerjam.brake.mechanics.pull import slip_at_elongation

    slip = np.array(slip_at_elongation(stretch, vacuum, brakes))
    force = spring * (stretch - slip)
    rows = [row for row, test in enumerate(tests) if test.overshoot or test.seating]
    if rows:
        subset = [tests[row] for row in rows]
        vacuum = np.broadcast_to(vacuum, stretch.shape)
        slip[rows], force[rows] = simulate_gripped_pull(
            stretch[rows],
            vacuum[rows],
            _batch_brakes(tests[0].subject.true, spring[rows], subset),
            spring[rows],
            _as_column([t.overshoot for t in subset]),
            _as_column([t.seating for t in subset]),
            spec.machine,
        )
    return slip, force


def _batch_brakes(true: Brake, spring: Array, tests: Sequence[Trial]) -> Brake:
    """Return the brakes of some tests as one Brake; scattered values have shape (M, 1)."""
    sheets = _as_column([t.friction for t in tests])
    sleeve = _as_column([t.enclosure for t in tests])
    return change_shape(true, true.scale_factor * sheets, spring, sleeve)


def _check_return_stroke(subject: Subject, slip: Array, vacuum: Array, brakes: Brake) -> None:
    """Raise an error if the enclosure would close the brake during the return stroke."""
    from layerjam.brake.mechanics.enclosure import enclosure_force
    from layerjam.brake.mechanics.friction import sheet_friction

    end, last = slip[:, -1:], np.broadcast_to(vacuum, slip.shape)[:, -1:]
    sleeve = np.asarray(enclosure_force(end, last, brakes))
    if (sleeve > np.asarray(sheet_friction(end, last, brakes))).any():
        raise QuantityError.of(
            "pulls.unload",
            f"at {show(float(last.min()), 'Pa')} the enclosure of {subject.label} pulls "
            "harder than the friction of its sheets and would close the brake during "
            "unloading; use more vacuum or less travel",
        )


def simulate_friction_test(spec: Spec, test: Trial) -> Trace:
    """Return the record of one friction test."""
    from layerjam.brake.mechanics.ageing import aged_static

    test_spec, machine, film = spec.friction, make_sled_machine(spec), test.subject.true.film
    numbers = np.array([test.number])
    time = faults.sample_times(
        machine, spec.seed, numbers, sample_count(test_spec.travel / test_spec.speed, machine)
    )
    travel_of_string = test_spec.speed * np.maximum(time[0] - machine.lag, 0.0)
    profile = _random_profile(travel_of_string, faults.make_rng(spec.seed, "texture", test.number))
    kinetic = film.kinetic * test.friction * test_spec.normal_force
    static_friction = film.static
    if test.hold is not None:
        static_friction = float(aged_static(test.hold, test.subject.true))
    static = max(static_friction * test.static * test_spec.normal_force, kinetic)
    # the force rises with the string's stiffness to static friction, then follows the film's
    # profile
    rising = test_spec.string_stiffness * travel_of_string
    sliding = np.maximum.accumulate(rising >= static)
    force = np.where(sliding, kinetic * (1 + test_spec.texture * profile), rising)
    slip = np.maximum(travel_of_string - static / test_spec.string_stiffness, 0.0)
    force = force + faults.saw_force(
        slip, test_spec.stick_slip, _as_column([test_spec.string_stiffness])[0]
    )
    reading = faults.measured_force(
        force[None, :], time, _as_column([test.warmer]), machine, spec.seed, numbers
    )
    travel = faults.measured_travel(test_spec.speed * time, machine)
    return _record_traces(spec, machine, [test], time, travel, reading)[0]


def _random_profile(travel: Array, random: np.random.Generator) -> Array:
    """Return a random profile, shape (N,), with an SD of 1 and a resolution of about 1 mm."""
    knots = np.arange(0.0, travel[-1] + 2e-3, 1e-3)
    return np.interp(travel, knots, random.standard_normal(len(knots)))


def _record_traces(
    spec: Spec, machine: Faults, tests: Sequence[Trial], time: Array, travel: Array, force: Array
) -> list[Trace]:
    """Return the records of tests, with lost samples and repeated time stamps."""
    out = []
    for row, test in enumerate(tests):
        keep = faults.sample_mask(machine, spec.seed, test.number, force.shape[1])
        columns = [force[row], travel[row], time[row]]
        if keep is not None:
            columns = [c[keep] for c in columns]
        stamps = faults.recorded_times(columns[2], machine, spec.seed, test.number)
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
