"""Every figure of every shipped brake: axes name their units, no word hides another or leaves.

The paper's own figures are measured as `reproduce` draws them (test_reproduce).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from core.drawing.legible import faults
from laboratory.campaigns import bench as virtual
from layerjam.bench.control.closed_loop import simulate_run
from layerjam.bench.control.follow import bode_response, follow, rehabilitation, spread_force
from layerjam.bench.control.plan import plan_stop
from layerjam.bench.figures import control_figures, line_pictures
from layerjam.brake.commands.bend import bend
from layerjam.brake.commands.drop import drop as drop_command
from layerjam.brake.commands.stick_slip import stick_slip
from layerjam.brake.commands.tensile import tensile as tensile_command
from layerjam.brake.commands.vacuum_line import rise
from layerjam.brake.device.load import catalogue, load
from layerjam.brake.figures import device_drawing, force_figures, impact_figures
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.simulate.drop import drop
from layerjam.brake.simulate.prediction import Prediction
from layerjam.brake.simulate.procedure import simple_pull
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.drawing import chart
from layerjam.laboratory.figures import (
    bayes_figures,
    brake_figures,
    calibration_figure,
    friction_figures,
    measurement_figures,
    pull_figures,
)
from layerjam.laboratory.identify.bayes.model import Prior
from layerjam.laboratory.identify.bayes.posterior import BayesFit
from layerjam.laboratory.identify.calibration.peaks import calibrate
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves
from layerjam.laboratory.identify.curves import Curve, make_curves
from layerjam.laboratory.identify.friction.ageing import fit_ageing
from layerjam.laboratory.identify.friction.reduction import reduce_friction
from layerjam.laboratory.identify.logs.crash import reduce_crash
from layerjam.laboratory.identify.logs.leak import fit_leak
from layerjam.laboratory.identify.logs.leak import pressure as leaked
from layerjam.laboratory.identify.logs.pump_down import fit_pump_down
from layerjam.laboratory.identify.logs.pump_down import pressure as pumped
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.identify.pull.summary import pull_summary
from layerjam.laboratory.identify.validation.metrics import validate_curves
from layerjam.laboratory.measure.trace import Trace
from layerjam.studies.machines import page as machine_figures
from layerjam.studies.machines.registry import load_scenario, scenarios
from layerjam.workshop.commands.array import array
from layerjam.workshop.design.requirements import Objective
from layerjam.workshop.figures import design_figures

pytest.importorskip("matplotlib")
FULL, PART = 94.5e3, 46.1e3
BRAKES = ("choi2018-kapton", "choi2018-ptfe", "choi2018-polyester", "choi2018-ptfe-fiberglass")
MACHINE = virtual.Machine(sampling_rate=10e3, load_cell_noise=0.15, seed=7)
SLED = virtual.Machine(sampling_rate=40.0, load_cell_noise=0.002, load_cell_range=10.0, seed=2)
A = 101325.0


# inputs


@cache
def pulls(
    name: str, vacuums: tuple[float, ...] = (FULL, PART), speed: float = 0.013
) -> list[Trace]:
    """Two pulls at each vacuum, from brakes that scatter by 3 %."""
    brake, random = load(name).brake, np.random.default_rng(5)
    made = []
    for count, vacuum in enumerate(v for v in vacuums for _ in range(2)):
        factor = brake.scale_factor * (1 + 0.03 * random.standard_normal())
        some = replace(brake, scale_factor=factor)
        made.append(virtual.pull(some, vacuum, speed, 0.03, MACHINE, repeat=count, name=name))
    return made


@cache
def curves(name: str, *speeds: float) -> tuple[Curve, ...]:
    traces = [t for v in speeds or (0.013,) for t in pulls(name, speed=v)]
    return make_curves([(t, pull_features(t), t.facts.vacuum or 0.0) for t in traces])


@cache
def exact(name: str, count: int = 4) -> Any:
    some = [(c, c.vacuum) for c in curves(name)[:count]]
    return calibrate(some, replace(load(name).brake, scale_factor=1.0))


@cache
def validated(name: str, *speeds: float) -> Any:
    return validate_curves(curves(name, *speeds), load(name).brake)


def rubbed(name: str) -> Any:
    film = load(name).brake.film
    traces = [
        virtual.friction(film.static, film.kinetic, 2.45, machine=SLED, repeat=n, kinetic_sd=0.004)
        for n in (1, 2, 3)
    ]
    return traces, reduce_friction(traces, 2.45)


def stuck_and_slipped() -> Any:
    """Sleds whose string lets go again and again: teeth."""
    sled = replace(SLED, sampling_rate=100.0, load_cell_noise=0.0005)
    trace = virtual.friction(0.3, 0.2, 2.45, machine=sled)
    slip = np.abs(trace.elongation - trace.elongation[0])
    saw = 2.45 * (0.2 + 0.1 * (slip / 2e-3 % 1.0))
    made = replace(trace, force=np.where(slip < 6e-4, trace.force, saw))
    return [made], reduce_friction([made], 2.45)


@cache
def posterior(name: str) -> BayesFit:
    """Draws as a sampler would leave them, without the sampler."""
    brake, random = load(name).brake, np.random.default_rng(1)
    shape, count = (2, 200), len(curves(name))
    k, a = exact(name).stiffness, brake.scale_factor

    def about(value: float, part: float, *more: int) -> Any:
        return value * np.exp(part * random.standard_normal((*shape, *more)))

    return BayesFit(
        brake=brake,
        paths=tuple(c.path for c in curves(name)),
        vacuum=tuple(c.vacuum for c in curves(name)),
        scale_factor=about(a, 0.01),
        stiffness=about(k, 0.02),
        enclosure_factor=about(1.0, 0.05),
        scale_factor_sd=about(0.03, 0.2),
        stiffness_sd=about(0.02, 0.2),
        scale_factor_mounting_sd=None,
        stiffness_mounting_sd=None,
        correlation=np.zeros(shape),
        curve_scale_factor=about(a, 0.02, count),
        curve_stiffness=about(k, 0.03, count),
        slack=about(1e-6, 0.1, count),
        residual=about(0.002, 0.1, count),
        divergences=0,
        seed=1,
        priors={
            "scale_factor": Prior(1.0, 0.5, "1", True, "wide"),
            "stiffness": Prior(1e5, 0.7, "N/m", True, "wide"),
        },
    )


def found(name: str, count: int) -> Any:
    return [(t, pull_summary(t)) for t in pulls(name)[:count]]


def designs(name: str) -> Any:
    """What `design` gives, of a front made up around a brake."""
    mass, hold = 0.02 * np.linspace(0.5, 2, 12), 200 * np.linspace(0.6, 1.8, 12)
    every = [{"mass": m, "holding_force": f} for m, f in zip(mass, hold, strict=True)]
    goals = [Objective("mass", True), Objective("holding_force", False)]
    values = {"chosen": every[4], "runner_up": every[5], "refined": every[4] | {"mass": 0.0149}}
    return SimpleNamespace(
        name=name,
        record=SimpleNamespace(spec=SimpleNamespace(objectives=goals)),
        feasible_designs=12,
        designs=40,
        front=every,
        front_size=12,
        **values,
        forbidden=[{"short": 0.1, "constraint": "length ≤ 110 mm", "design": every[9]}],
        units={"mass": "kg", "holding_force": "N"},
    )


@cache
def regulated() -> Any:
    regulator = line_pictures.make_regulator("pi")
    return regulator, simulate_run(regulator, [(8.0, 60e3)])


@cache
def followed(name: str) -> Any:
    brake, regulator = load(name).brake, line_pictures.make_regulator("scheduled")
    time = np.arange(1200) * regulator.sample_time
    top = 0.8 * float(brake_force(0.01, FULL, brake))
    wanted = rehabilitation(time, low=0.3 * top, high=top, period=6.0)
    run = follow(regulator, brake, wanted, 0.01 + 0 * time)
    sine = {"slip": 0.01, "mean": 0.5 * top, "amplitude": 0.1 * top}
    response = bode_response(regulator, brake, frequencies=[0.3, 1.0], **sine)
    return run, response, spread_force(run, brake, 0 * time, Prediction(load(name)))


def planned(name: str) -> Any:
    return plan_stop(load(name), load_line("choi2018").line, line_pictures.COLLISION)


def dropped(name: str) -> Any:
    return drop(load(name), mass=1.0, speed=2.0, vacuum=FULL, rope_stiffness=2e4)[1]


def crashed(name: str) -> Any:
    return drop_command(name, mass=1.0, speed=2.5, vacuum=5e3, rope_stiffness=16.8e3)


def pull_of(name: str, vacuum: float) -> Any:
    return tensile_command(name, vacuum=vacuum, speed=1e-3, travel=0.03)


def held() -> Any:
    t = np.arange(0, 200, 0.5)
    noise = np.random.default_rng(1).normal(0, 20, len(t))
    return fit_leak(t, leaked("laminar", t, 7e3, 0.004, A) + noise)


def emptied() -> Any:
    t = np.arange(0, 15, 0.02)
    noise = np.random.default_rng(0).normal(0, 50, len(t))
    return fit_pump_down(t, np.where(t < 1, A, pumped(np.maximum(t - 1, 0), A, 6e3, 0.4)) + noise)


def struck() -> Any:
    t = np.arange(0, 0.15, 1e-4)
    inside = (t > 0.06) & (t < 0.08)
    pulse = np.where(inside, 180 * np.sin(np.pi * (t - 0.06) / 0.02), 0.0)
    return reduce_crash(t, pulse + np.random.default_rng(3).normal(0, 0.5, len(t)))


def specimens(tmp_path: Path, count: int) -> Any:
    from layerjam.laboratory.commands.enclosure import enclosure
    from layerjam.laboratory.identify.rubber import hyperelastic

    strain, files = np.linspace(0.01, 3, 300), []
    for number in range(count):
        stress = hyperelastic.stress("neo-hookean", {"C1": 3e4 + 2e3 * number}, strain)
        rows = (f"{e * 100:.4f};{s / 1e6:.8f}" for e, s in zip(strain, stress, strict=True))
        files.append(tmp_path / f"specimen-{number}.csv")
        files[-1].write_text("\n".join(["Strain (%);Stress (MPa)", *rows]), encoding="utf-8")
    record = enclosure(files).record
    return record, {path: 1.1e5 for path in record}


OF_BRAKE: dict[str, Callable[[str], Any]] = {
    "device": lambda n: device_drawing.draw_device(load(n)),
    "force": lambda n: force_figures.plot_force_slip(load(n), FULL, 0.02),
    "force-at-the-end": lambda n: force_figures.plot_force_slip(load(n), 5e3, 0.065),
    "vacuum": lambda n: force_figures.plot_force_vacuum(load(n), 0.02, 40.0, 60e3),
    "vacuum-none": lambda n: force_figures.plot_force_vacuum(load(n), 0.02, 900.0, np.inf),
    "tensile": lambda n: chart.draw_panes(
        force_figures.tensile_panes(tensile(load(n), simple_pull(FULL, 0.013, 0.04)))
    ),
    "friction": lambda n: friction_figures.draw_friction(*rubbed(n)),
    "calibration": lambda n: calibration_figure.draw_calibration(load(n), exact(n), True),
    "calibration-of-one": lambda n: calibration_figure.draw_calibration(
        load(n), exact(n, 1), False
    ),
    "validation": lambda n: pull_figures.draw_validation(load(n), validated(n), True),
    "overlay": lambda n: brake_figures.draw_overlay(
        load(n).brake, validated(n, 0.007, 0.019), True
    ),
    "residuals": lambda n: brake_figures.draw_residuals(validated(n, 0.007, 0.019)),
    "scale-factors": lambda n: brake_figures.draw_factors(exact(n)),
    "posterior": lambda n: bayes_figures.posterior(posterior(n)),
    "bands": lambda n: bayes_figures.bands(posterior(n), curves(n)),
    "deviations": lambda n: bayes_figures.deviations(posterior(n), curves(n)),
    "vacuum-for-force": lambda n: bayes_figures.vacuum_for_force(posterior(n), 0.02, 30.0),
    "following": lambda n: control_figures.draw_tracking(*followed(n)),
    "following-alone": lambda n: control_figures.draw_tracking(followed(n)[0], None),
    "front": lambda n: design_figures.draw_front(designs(n)),
    "drop": lambda n: chart.draw_panes(impact_figures.drop_panes(dropped(n))),
    "drop-that-crashes": lambda n: crashed(n).draw(),
    "array": lambda n: array(n, parallel=2, series=3).draw(),
    "tensile-beside": lambda n: pull_of(n, FULL).plot(beside={"50 kPa": pull_of(n, 50e3)}),
    "plan": lambda n: control_figures.draw_plan(planned(n)),
    "pull": lambda n: pull_figures.draw_pulls(found(n, 1)),
    "pulls": lambda n: pull_figures.draw_pulls(found(n, 4)),
    "bend": lambda n: bend(n, vacuum=FULL, angle=0.5).draw(),
    "bend-over-a-joint": lambda n: bend(n, vacuum=PART, angle=1.5, radius=0.03).draw(),
    "bend-without-vacuum": lambda n: bend(n, vacuum=0.0, angle=0.5, radius=0.1).draw(),
    "stick-slip": lambda n: stick_slip(n, vacuum=FULL, speed=1e-3, travel=4e-3).draw(),
}


ALONE: dict[str, Callable[[], Any]] = {
    "stick-slip-friction": lambda: friction_figures.draw_friction(*stuck_and_slipped()),
    "calibration-of-curves": lambda: calibration_figure.draw_calibration(
        load(BRAKES[0]), calibrate_curves(curves(BRAKES[0]), load(BRAKES[0]).brake), True
    ),
    "loop": lambda: chart.draw_panes(control_figures.loop_panes(*regulated())),
    "drop-without-brake": lambda: drop_command(
        BRAKES[0], mass=1.0, speed=1.5, rope_stiffness=16.8e3, no_brake=True
    ).draw(),
    "rise-air": lambda: rise("choi2018", target=80e3).draw(),
    "rise-water": lambda: rise("choi2018", target=80e3, fluid="water").draw(),
    "rise-never": lambda: rise("choi2018", target=1.01e5).draw(),
    "ageing": lambda: measurement_figures.draw_ageing(
        fit_ageing([1.0, 1.0, 10.0, 100.0, 1000.0], [0.30, 0.31, 0.32, 0.34, 0.35])
    ),
    "leak": lambda: measurement_figures.draw_leak(held()),
    "pump-down": lambda: measurement_figures.draw_pump_down(emptied(), None, None),
    "crash": lambda: measurement_figures.draw_crash(struck()),
}


# tests


@pytest.mark.parametrize(
    "brake", [BRAKES[0], *(pytest.param(name, marks=pytest.mark.slow) for name in BRAKES[1:])]
)
@pytest.mark.parametrize("name", OF_BRAKE)
def test_a_figure_of_a_brake(name: str, brake: str) -> None:
    assert faults(OF_BRAKE[name](brake)) == []


@pytest.mark.parametrize("name", ALONE)
def test_a_figure_of_its_own(name: str) -> None:
    assert faults(ALONE[name]()) == []


@pytest.mark.parametrize("count", [1, 3])
def test_figures_of_specimens(tmp_path: Path, count: int) -> None:
    assert faults(measurement_figures.draw_sleeve(*specimens(tmp_path, count))) == []


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[] if n == "rehabilitation" else pytest.mark.slow) for n in scenarios()],
)
def test_figures_of_a_machine(name: str) -> None:
    for picture in machine_figures.draw_pictures(load_scenario(name).analyse()):
        assert faults(picture.figure()) == [], picture.name


def test_every_shipped_brake_is_drawn() -> None:
    assert set(BRAKES) <= set(catalogue())
