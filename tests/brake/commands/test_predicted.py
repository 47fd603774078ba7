"""Intervals of drops, pulls, summaries and comparisons against closed forms and Monte Carlo."""

import json
import math

import numpy as np
import pytest

import layerjam
from layerjam.brake.device.evidence import Evidence, Part
from layerjam.brake.mechanics.pull import peak
from layerjam.brake.mechanics.stop.exact import stop, time_at_slip
from layerjam.brake.mechanics.stop.motion import rope_spring
from layerjam.brake.simulate import prediction as predicting
from layerjam.brake.simulate.procedure import parse_procedure, simple_pull
from layerjam.brake.simulate.pull_spread import pull_numbers, spread_pull
from layerjam.brake.simulate.repeated_runs import interpolate_samples
from layerjam.brake.simulate.stack import tensile_stack
from layerjam.brake.simulate.tensile import tensile as pull_lumped
from layerjam.core.evolve import evolve

DROP = {"mass": 1.0, "speed": 2.0, "rope_stiffness": 16.8e3}
NUMBERS = ("slip", "peak_force", "peak_g", "peak_deceleration", "stopping_time")
NUMBERS += ("dissipated_energy",)
Z = 1.959963984540054


def proven(sd, names=("scale_factor",), of="mean", speed=(1e-3, 10.0), changes=None):
    """Return Kapton with tests that leave a relative SD of some numbers, and nothing else."""
    file = layerjam.load("choi2018-kapton")
    file = evolve(file, brake=file.brake.with_(**(changes or {})))
    laws = ("mount.spacers", "speed_law.")
    stated = {path: v for path, v in file.known_values.items() if path.startswith(laws)}
    covariance = tuple(tuple(row) for row in (np.eye(len(names)) * sd**2).tolist())
    entry = Evidence(
        command="calibrate",
        date="2026-01-01",
        tests=5,
        names=names,
        exponent_sd=1e-9,
        ranges={"vacuum": (1e3, 101e3), "slip": (0.0, 0.06), "speed": speed},
        fitted=stated,
        parts=(Part(of, covariance),),
    )
    return evolve(file, evidence=(entry,))


@pytest.fixture
def without_speed_scatter(monkeypatch):
    monkeypatch.setattr(predicting, "SPEED_SD", 0.0)


def ends(result, name):
    found = result.intervals[name]
    return found["low"], found["high"]


@pytest.mark.usefixtures("without_speed_scatter")
def test_a_scale_factor_alone_gives_the_peak_of_its_own_quantiles():
    file, sd = proven(0.1), 0.1
    drop = layerjam.drop(file, vacuum=40e3, **DROP)
    pull = layerjam.tensile(file, vacuum=40e3, speed=0.013, elongation=0.04)
    for sign, place in ((-1, 0), (1, 1)):
        factor = file.brake.scale_factor * math.exp(sign * Z * sd)
        brake = evolve(file.brake, scale_factor=factor)
        force = float(peak(40e3, brake.sheets.usable_travel, brake).force)
        assert ends(drop, "peak_force")[place] == pytest.approx(force, rel=5e-3)
        assert ends(pull, "peak_force")[place] == pytest.approx(force, rel=5e-3)
        spring = float(rope_spring(DROP["rope_stiffness"], brake))
        slip = float(stop(1.0, 2.0, 40e3, spring, brake.site.gravity, brake).slip)
        assert ends(drop, "slip")[1 - place] == pytest.approx(slip, rel=5e-3)


@pytest.mark.usefixtures("without_speed_scatter")
@pytest.mark.parametrize("more", [{}, {"rope_damping": 20.0}])
def test_without_uncertainty_the_interval_is_the_value(more):
    result = layerjam.drop(proven(0.0), vacuum=40e3, **DROP, **more)
    for name in NUMBERS:
        assert ends(result, name) == pytest.approx([getattr(result, name)] * 2, rel=1e-3)


@pytest.mark.parametrize("vacuum", [20e3, 40e3, 90e3])
def test_the_interval_contains_the_value_and_grows_with_scatter(vacuum):
    widths = []
    for sd in (0.02, 0.1):
        result = layerjam.drop(proven(sd), vacuum=vacuum, **DROP)
        for name in NUMBERS:
            low, high = ends(result, name)
            assert low <= getattr(result, name) <= high
        low, high = ends(result, "peak_force")
        widths.append(high - low)
    assert widths[0] < widths[1]


def test_samples_agree_with_an_independent_monte_carlo():
    sd, names = 0.08, ("scale_factor", "stiffness_measured", "enclosure_force")
    file = proven(sd, names)
    result = layerjam.drop(file, vacuum=50e3, **DROP)
    random = np.random.default_rng(7)
    draws, brake = 20_000, file.brake
    friction, stiffness, enclosure = np.exp(sd * random.standard_normal((3, draws)))
    # beyond no tested speed and vacuum: 2 m/s is inside the range of the tests
    other = evolve(
        brake,
        scale_factor=brake.scale_factor * friction,
        stiffness_measured=brake.stiffness_measured * stiffness,
        enclosure=evolve(brake.enclosure, modulus=brake.enclosure.modulus * enclosure),
        film=evolve(brake.film, friction_on_silicone=brake.film.friction_on_silicone * enclosure),
    )
    spring = rope_spring(DROP["rope_stiffness"], other)
    unit = np.ones(draws)
    end = stop(unit, 2.0 * unit, 50e3 * unit, spring, brake.site.gravity, other)
    for name, values in (("slip", end.slip), ("peak_force", end.peak_force)):
        expected = np.quantile(values, (0.025, 0.975))
        assert ends(result, name) == pytest.approx(expected, rel=0.015)
    assert ends(result, "dissipated_energy") == pytest.approx(
        np.quantile(end.heat, (0.025, 0.975)), rel=0.015
    )
    case = (unit, 2.0 * unit, 50e3 * unit, spring, brake.site.gravity, other)
    times = np.quantile(time_at_slip(end.slip, *case), (0.025, 0.975))
    assert ends(result, "stopping_time") == pytest.approx(times, rel=0.015)


# at 30 kPa a third of these stops use up the travel; at 15 kPa all do, and no time is the longest
@pytest.mark.parametrize("vacuum", [15e3, 30e3, 60e3])
@pytest.mark.parametrize("rope", [None, 16.8e3])
def test_stopping_times_are_those_of_every_sample(vacuum, rope):
    case = {"mass": 1.0, "speed": 2.0, "rope_stiffness": rope, "vacuum": vacuum}
    file = layerjam.load("choi2018-kapton")
    result = layerjam.drop(file, **case)
    brakes = predicting.Prediction(file, vacuum, result.slip, 2.0).brakes
    unit = np.ones(len(brakes.scale_factor))
    spring, gravity = rope_spring(rope, brakes), file.brake.site.gravity * unit
    numbers = (unit, 2.0 * unit, vacuum * unit, spring * unit, gravity, brakes)
    times = time_at_slip(stop(*numbers).slip, *numbers)
    expected = np.quantile(times, (0.025, 0.975), method="hazen")
    assert ends(result, "stopping_time") == pytest.approx(expected, rel=1e-9)


def test_the_ends_of_the_force_have_the_intervals_of_forces_at_these_vacuums():
    answer = layerjam.vacuum("choi2018-kapton", slip=0.02, force=100.0)
    full = layerjam.force("choi2018-kapton", slip=0.02, vacuum=101325.0)
    assert answer.interval("greatest_force") == pytest.approx(full.interval("force"))
    # the enclosure alone: its spread is log-normal
    low, high = answer.interval("least_force")
    assert low * high == pytest.approx(answer.least_force**2, rel=1e-2)
    sd = layerjam.load("choi2018-kapton").brake.enclosure.force_sd
    assert math.log(high / low) == pytest.approx(2 * Z * sd, rel=1e-2)


STACK = {"vacuum": 60e3, "speed": 0.013, "elongation": 0.02, "model": "stack"}


def pull_stack(brake, **layout):
    """Peak and work of a pull sheet by sheet, without intervals."""
    file = evolve(layerjam.load("choi2018-kapton"), brake=brake)
    record, _ = tensile_stack(file, simple_pull(60e3, 0.013, 0.02), **layout)
    return float(record.force.max()), float(record.work[-1])


def test_a_stack_agrees_with_stacks_drawn_one_by_one():
    sd, names = 0.08, ("scale_factor", "stiffness_measured", "enclosure_force")
    result = layerjam.tensile(proven(sd, names), **STACK)
    random, base = np.random.default_rng(11), layerjam.load("choi2018-kapton").brake
    numbers = []
    for friction, stiffness, rubber in np.exp(sd * random.standard_normal((300, 3))):
        brake = evolve(
            base,
            scale_factor=base.scale_factor * friction,
            stiffness_measured=base.stiffness_measured * stiffness,
            enclosure=evolve(base.enclosure, modulus=base.enclosure.modulus * rubber),
            film=evolve(base.film, friction_on_silicone=base.film.friction_on_silicone * rubber),
        )
        numbers.append(pull_stack(brake))
    for name, values in zip(("peak_force", "work"), np.transpose(numbers), strict=True):
        # the quantiles of 300 stacks vary by 0.15 of the SD
        assert ends(result, name) == pytest.approx(np.quantile(values, (0.025, 0.975)), rel=0.03)
    assert result.basis == "tested"
    assert pull_stack(base)[0] == pytest.approx(result.peak_force, rel=1e-12)


@pytest.mark.parametrize("static", [False, True])
def test_static_friction_widens_a_stack_that_has_it(static):
    result = layerjam.tensile(proven(0.0), static=static, **STACK)
    file = layerjam.load("choi2018-kapton")
    width = math.sqrt(math.log1p(file.sources["film.static"].sd ** 2)) * static
    for sign, end in zip((-1, 1), ends(result, "peak_force"), strict=True):
        film = file.brake.film
        other = evolve(film, static=film.static * math.exp(sign * Z * width))
        peak_force, _ = pull_stack(evolve(file.brake, film=other), static=static)
        assert end == pytest.approx(peak_force, rel=3e-3)


def test_the_mean_has_a_narrower_interval_than_the_next_test():
    file = proven(0.1, of="test")
    following, mean = (
        layerjam.drop(file, vacuum=40e3, interval=of, **DROP) for of in ("next", "mean")
    )
    assert ends(following, "slip")[0] < ends(mean, "slip")[0] <= mean.slip
    assert mean.slip <= ends(mean, "slip")[1] < ends(following, "slip")[1]
    assert {row["of"] for row in mean.intervals.values()} == {"mean"}
    assert {row["of"] for row in following.intervals.values()} == {"next test"}


def test_every_command_with_the_option_widens_from_mean_to_next():
    file = proven(0.1, of="test")
    calls = {
        "force": lambda of: layerjam.force(file, slip=0.02, vacuum=40e3, interval=of),
        "vacuum": lambda of: layerjam.vacuum(file, slip=0.02, force=50.0, interval=of),
        "peak_force": lambda of: layerjam.tensile(
            file, vacuum=40e3, speed=0.01, elongation=0.03, interval=of
        ),
    }
    for name, call in calls.items():
        (low, high), (inner, outer) = (ends(call(of), name) for of in ("next", "mean"))
        assert low < inner < outer < high
    tuned = [
        layerjam.tune(file, mass=1.0, speed=2.0, travel=0.04, interval=of)
        for of in ("next", "mean")
    ]
    assert tuned[0].safe_vacuum == tuned[1].safe_vacuum  # it always covers the next stops
    assert ends(tuned[0], "vacuum")[1] > ends(tuned[1], "vacuum")[1]


def test_a_damped_rope_without_damping_agrees_with_the_exact_law():
    file = proven(0.08, ("scale_factor", "stiffness_measured", "enclosure_force"))
    exact = layerjam.drop(file, vacuum=50e3, **DROP)
    damped = layerjam.drop(file, vacuum=50e3, rope_damping=1e-3, **DROP)
    for name in NUMBERS:
        assert ends(damped, name) == pytest.approx(ends(exact, name), rel=0.02)


def test_a_pull_by_laws_and_by_repeated_runs_agree():
    file = proven(0.08, ("scale_factor", "stiffness_measured", "enclosure_force"))
    steps = parse_procedure("evacuate to 50 kPa; pull at 13 mm/s until 30 mm")
    prediction, samples = spread_pull(file, steps, pull_lumped(file, steps))
    repeated = interpolate_samples(
        prediction, lambda brake: pull_numbers(pull_lumped(evolve(file, brake=brake), steps))
    )
    assert samples.keys() == repeated.keys()
    for name, values in samples.items():
        ends_found = prediction.quantiles(values, (0.025, 0.975))
        assert ends_found == pytest.approx(
            prediction.quantiles(repeated[name], (0.025, 0.975)), rel=0.03
        )


def test_an_elastic_pull_and_a_pull_to_separation_have_intervals():
    file = proven(0.05)
    for elongation in (1e-4, 0.2):
        result = layerjam.tensile(file, vacuum=50e3, speed=0.01, elongation=elongation)
        for name in ("peak_force", "work", "force_at_end"):
            low, high = ends(result, name)
            value = getattr(result, name)
            assert low * (1 - 1e-9) <= value <= high * (1 + 1e-9)


def test_stops_that_snap_leave_the_end_open():
    """On a soft rope some samples snap, so that there is no upper bound."""
    result = layerjam.drop(
        "choi2018-kapton", mass=1.0, speed=2.0, vacuum=20e3, rope_stiffness=300.0
    )
    assert not result.feasible and result.intervals == {} and result.basis == "handbook"


def test_a_tuned_stop_states_its_share_and_a_bare_drop_has_no_basis():
    tuned = layerjam.drop("choi2018-kapton", vacuum="tuned", travel=0.04, **DROP)
    said = [w for w in tuned.warnings if w.key == "share-within-travel"]
    assert len(said) == 1 and "5" in said[0] and "within 40 mm" in said[0]
    bare = layerjam.drop("choi2018-kapton", no_brake=True, **DROP)
    assert bare.basis is None and bare.intervals is None
    assert "95 %" not in bare.table()


def test_the_basis_names_what_lies_outside_the_tests():
    file = proven(0.05, speed=(1e-3, 0.1))
    result = layerjam.drop(file, vacuum=50e3, **DROP)
    assert result.basis == "extrapolated"
    (row,) = result.extrapolated
    assert row == {"quantity": "speed", "value": 2.0, "low": 1e-3, "high": 0.1}
    assert json.loads(result.json())["basis"] == "extrapolated"
    assert layerjam.drop(proven(0.05), vacuum=50e3, **DROP).basis == "tested"


def test_show_array_and_compare_use_the_same_interval():
    file = proven(0.1)
    shown = layerjam.show(file)
    low, high = ends(shown, "max_force")
    assert low < shown.max_force < high
    assert ends(shown, "force_density") == pytest.approx((low / shown.mass, high / shown.mass))
    single = layerjam.array(file)
    many = layerjam.array(file, parallel=3, series=2)
    assert ends(single, "peak_force") == pytest.approx((low, high))
    assert ends(many, "peak_force") == pytest.approx((3 * low, 3 * high))
    short = layerjam.array(file, until=1e-4)
    assert "peak_force" not in short.intervals
    row = layerjam.compare(file).devices[0]
    assert row["basis"] == "tested"
    found = row["intervals"]["max_force"]
    assert (found["low"], found["high"]) == pytest.approx((low, high))


def change_factor(file, deviation):
    """Return a brake with another scale factor, and no tests."""
    factor = file.brake.scale_factor * math.exp(deviation)
    return evolve(file, brake=evolve(file.brake, scale_factor=factor), evidence=())


@pytest.mark.parametrize("counts", [{}, {"parallel": 2, "series": 3}])
def test_an_array_at_its_end_has_the_numbers_of_weaker_and_stronger_brakes(counts):
    sd, file = 0.1, proven(0.1)
    result = layerjam.array(file, vacuum=60e3, **counts)
    for place, sign in enumerate((-1, 1)):
        other = layerjam.array(change_factor(file, sign * Z * sd), vacuum=60e3, **counts)
        for name in ("force_at_end", "work", "energy", "peak_force"):
            assert ends(result, name)[place] == pytest.approx(getattr(other, name), rel=5e-3)
    assert "force_at_end" not in layerjam.array(file, until=1e-3, **counts).intervals


@pytest.mark.usefixtures("without_speed_scatter")
def test_both_stops_of_a_plan_have_the_numbers_of_weaker_and_stronger_brakes():
    sd, file, arrival = 0.03, proven(0.03), {"mass": 1.0, "speed": 2.0}
    result = layerjam.plan("choi2018", file, warning=3.0, travel=0.04, **arrival)
    # an integrated stop with the vacuum that moves differs slightly, so compare constant ones
    for head, vacuum in (("", result.reached), ("tuned_", result.tuned_vacuum)):
        names = ["peak_force", "peak_g", *(() if head else ("dissipated_energy",))]
        for place, sign in enumerate((-1, 1)):
            brake = change_factor(file, sign * Z * sd)
            stop_record = layerjam.drop(brake, vacuum=vacuum, **arrival)
            for name in names:
                # a weaker brake slips further, and gravity adds to the heat
                end = 1 - place if name == "dissipated_energy" else place
                value = getattr(stop_record, name)
                assert ends(result, f"{head}{name}")[end] == pytest.approx(value, rel=5e-3)
            assert ends(result, f"{head}slip")[1 - place] == pytest.approx(
                stop_record.slip, rel=5e-3
            )


def test_the_mean_of_a_summary_and_of_an_array_has_no_scatter():
    sd, mean_sd, names = 0.1, 0.02, ("scale_factor",)
    (tests,) = proven(mean_sd).evidence
    parts = (*tests.parts, Part("test", ((sd**2,),)))
    file = evolve(layerjam.load("choi2018-kapton"), evidence=(evolve(tests, parts=parts),))
    assert tests.names == names
    for run, name in ((layerjam.show, "max_force"), (layerjam.array, "force_at_end")):
        for interval, total in (("mean", mean_sd), ("next", math.hypot(sd, mean_sd))):
            result = run(file, interval=interval)
            for place, sign in enumerate((-1, 1)):
                other = run(change_factor(file, sign * Z * total))
                assert ends(result, name)[place] == pytest.approx(getattr(other, name), rel=5e-3)
            assert {i["of"] for i in result.intervals.values()} == {
                "mean" if interval == "mean" else "next test"
            }


def test_energy_over_a_travel_that_no_pull_reached_is_extrapolated():
    (tests,) = proven(0.1).evidence
    narrow = evolve(tests, ranges={**tests.ranges, "slip": (0.0, 0.04)})
    file = evolve(layerjam.load("choi2018-kapton"), evidence=(narrow,))
    for result in (layerjam.show(file), layerjam.array(file)):
        assert result.basis == "extrapolated"
        (row,) = result.extrapolated
        assert row == {"quantity": "slip", "value": 0.06, "low": 0.0, "high": 0.04}
    assert layerjam.show(proven(0.1)).basis == "tested"


def test_compare_says_when_intervals_overlap():
    apart = layerjam.compare("choi2018-kapton", "choi2018-ptfe")
    assert not any(w.key == "intervals-overlap" for w in apart.warnings)
    near = layerjam.compare("choi2018-kapton", "choi2018-polyester")
    (said,) = (w for w in near.warnings if w.key == "intervals-overlap")
    assert "choi2018-polyester" in said and "choi2018-kapton" in said


OF_A_FAN = {
    "show": (layerjam.show, {}, ("max_force", "energy_capacity")),
    "drop": (layerjam.drop, {"vacuum": 40e3, **DROP}, ("slip", "peak_force")),
    "tensile": (
        layerjam.tensile,
        {"vacuum": 40e3, "speed": 0.01, "elongation": 0.03},
        ("peak_force", "work"),
    ),
}


@pytest.mark.parametrize(
    "command", ["show", "drop", pytest.param("tensile", marks=pytest.mark.slow)]
)
def test_a_brake_without_spacers_has_intervals_in_every_command(command):
    """One slip with many frictions failed in the quadrature of sheets that fan out."""
    file = layerjam.load("choi2018-kapton")
    file = evolve(file, brake=evolve(file.brake, mount=evolve(file.brake.mount, spacers=False)))
    run, case, names = OF_A_FAN[command]
    result = run(file, **case)
    for name in names:
        low, high = ends(result, name)
        assert low < getattr(result, name) < high


@pytest.mark.parametrize("vacuum", [40e3, 101e3])
def test_the_figure_of_a_drop_shows_the_interval_of_its_peak_and_what_is_untested(vacuum):
    file = proven(0.1)
    (tests,) = file.evidence
    narrow = evolve(tests, ranges={**tests.ranges, "vacuum": (30e3, 60e3)})
    result = layerjam.drop(evolve(file, evidence=(narrow,)), vacuum=vacuum, **DROP)
    panes = result.panes()
    ((low, high),) = panes[0].bands
    assert (float(low.y[0]), float(high.y[0])) == ends(result, "peak_force")
    assert panes[0].y_range[1] > high.y[0]
    due = "solid" if vacuum < 60e3 else "dashed"
    assert {pane.curves[0].dash for pane in panes} == {due}


@pytest.mark.parametrize(("strength", "verb"), [(14.0, "exceeds"), (16.0, "may exceed"), (18, "")])
def test_show_notes_a_stress_that_exceeds_or_may_exceed_the_strength(strength, verb):
    """The stress at the clamp of Kapton is 14.85 MPa, and 95 % of brakes lie below 16.83 MPa."""
    file = layerjam.edit("choi2018-kapton", {"film.strength": f"{strength} MPa"})
    notices = [w for w in layerjam.show(file.record).warnings if w.key == "clamp-stress"]
    assert len(notices) == bool(verb) and all(f"clamp {verb} the film" in n for n in notices)
