"""Pulls without a test machine, and single tests of the virtual laboratory."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.laboratory.campaigns.campaign import campaign
from layerjam.laboratory.campaigns.exports import write_trace
from layerjam.laboratory.campaigns.faults import Faults
from layerjam.laboratory.campaigns.spec import FrictionTests, Pulls, Spec, Truth
from layerjam.laboratory.measure.trace import Trace
from strategies import KAPTON

FULL = 94.5e3


@dataclass(frozen=True, kw_only=True)
class Machine:
    """The laboratory's machine as the tests use it: an ordinary load cell, and a seed."""

    sampling_rate: float = 1000.0
    load_cell_noise: float = 0.15
    load_cell_range: float = 500.0
    force_quantisation: float = 0.001
    elongation_quantisation: float = 1e-7
    drift: float = 0.0
    zero_offset: float = 0.0
    jitter: float = 0.0
    seed: int = 1

    def faults(self) -> Faults:
        return Faults(
            sampling_rate=self.sampling_rate,
            force_noise=self.load_cell_noise,
            load_cell_range=self.load_cell_range,
            force_step=self.force_quantisation,
            travel_step=self.elongation_quantisation,
            force_drift=self.drift,
            force_offset=self.zero_offset,
            jitter=self.jitter,
        )


QUIET: dict[str, Any] = {
    "load_cell_noise": 0.0, "force_quantisation": 0.0, "elongation_quantisation": 0.0,
}  # fmt: skip


def pull(
    brake: Brake,
    vacuum: float,
    speed: float,
    travel: float,
    machine: Machine | None = None,
    repeat: int = 1,
    name: str | None = None,
) -> Trace:
    """One pull of a campaign."""
    pulls = Pulls(vacuums=(vacuum,), speeds=(speed,), repeats=1, travel=travel)
    return _one(brake, machine or Machine(), repeat, name, pulls=pulls)


def friction(
    static: float,
    kinetic: float,
    normal_force: float,
    *,
    travel: float = 0.1,
    machine: Machine | None = None,
    repeat: int = 1,
    static_sd: float = 0.0,
    kinetic_sd: float = 0.0,
    texture: float = 0.01,
    string_stiffness: float = 5e3,
) -> Trace:
    """One friction test of a campaign."""
    machine = machine or Machine(load_cell_noise=0.002, load_cell_range=10.0)
    tests = FrictionTests(
        repeats=1,
        normal_force=normal_force,
        travel=travel,
        sampling_rate=machine.sampling_rate,
        string_stiffness=string_stiffness,
        texture=texture,
        static_scatter=static_sd / static,
        kinetic_scatter=kinetic_sd / kinetic if kinetic else 0.0,
        force_noise=machine.load_cell_noise,
        force_offset=machine.zero_offset,
        load_cell_range=machine.load_cell_range,
        force_step=machine.force_quantisation,
    )
    return _one(KAPTON, machine, repeat, None, friction=tests, film=(static, kinetic))


def _one(
    brake: Brake, machine: Machine, repeat: int, name: str | None,
    film: tuple[float | None, float | None] = (None, None), **tests: Any,
) -> Trace:  # fmt: skip
    file = BrakeFile(name=name or "bench", sources={}, text="", brake=brake)
    truth = Truth(brake=file, static=film[0], kinetic=film[1])
    spec = Spec(
        brakes=(truth,), seed=1000 * machine.seed + repeat, machine=machine.faults(), **tests
    )
    [trace] = campaign(spec).traces()
    facts = replace(trace.facts, repeat=repeat, seed=machine.seed, brake=name)
    return replace(trace, path="", facts=facts)


write_own = write_trace
write_bluehill = partial(write_trace, layout="bluehill")
write_testxpert = partial(write_trace, layout="testxpert")
WRITERS = {"own": write_own, "bluehill": write_bluehill, "testxpert": write_testxpert}


def curve(
    brake: Brake, vacuum: float = FULL, travel: float = 0.04, rows: int = 4001, path: str = "curve"
) -> Trace:
    """The model's own curve, without any noise."""
    u = np.linspace(0.0, travel, rows)
    force = np.asarray(force_at_elongation(u, vacuum, brake))
    return Trace(force=force, elongation=u, time=u / 0.013, path=path, format="model")


def noisy(
    brake: Brake, seed: int, noise: float = 0.15, vacuum: float = FULL, speed: float = 0.013
) -> Trace:
    """A pull at 1000 Hz to 40 mm, with nothing but white noise."""
    machine = Machine(**(QUIET | {"load_cell_noise": noise}), seed=seed)
    return pull(brake, vacuum, speed, 0.04, machine)
