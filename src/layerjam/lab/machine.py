"""A virtual test machine: pulls and friction tests with the faults of a real one, and its files.

From a stated truth and a seed it writes what the readers read. Every file says that it is
synthetic, in its own text and in the sidecar beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.lab.exports import Form, file_bytes, write_pair
from layerjam.lab.faults import stepped
from layerjam.measure.sidecar import Facts
from layerjam.measure.trace import Array, Trace

FORMAT = "virtual test machine"


@dataclass(frozen=True, kw_only=True)
class Machine:
    """A test machine and its faults, in SI units; all faults can be set to zero."""

    sampling_rate: float = 1000.0
    """[Hz]"""
    load_cell_noise: float = 0.15
    """Standard deviation of the force [N]."""
    load_cell_range: float = 500.0
    """The load cell shows nothing beyond plus or minus this [N]; it saturates there."""
    force_quantisation: float = 0.001
    """Step of the force [N]; 0 for none."""
    elongation_quantisation: float = 1e-7
    """Step of the elongation [m]; 0 for none."""
    drift: float = 0.0
    """Of the force's zero [N/s]."""
    zero_offset: float = 0.0
    """Of the force [N]."""
    jitter: float = 0.0
    """Standard deviation of the moment of a sample [s]; at most 0.2 of the sampling period."""
    seed: int = 1

    def generator(self, repeat: int) -> np.random.Generator:
        """The random numbers of one repeat; the same for the same seed and repeat."""
        return np.random.Generator(np.random.PCG64([self.seed, repeat]))


def _sampled(duration: float, machine: Machine, random: np.random.Generator) -> Array:
    """Moments of the samples [s], rising."""
    rate = machine.sampling_rate
    if not (rate > 0 and 0 < duration * rate < 1e8):
        raise QuantityError.of(
            "duration",
            f"{duration:.4g} s at {rate:.4g} Hz is not allowed; it must give 1 to 1e8 samples",
        )
    if not 0 <= machine.jitter * rate <= 0.2:
        raise QuantityError.of(
            "jitter",
            f"{machine.jitter:.4g} s is not allowed; it is at most 0.2 of the sampling "
            f"period, {0.2 / rate:.4g} s",
        )
    time = np.arange(int(np.floor(duration * rate * (1 + 1e-12))) + 1) / rate
    # Drawn also without jitter, so that one fault more leaves the other faults' numbers alone;
    # cut at 2 standard deviations, so that stamps cannot overtake one another.
    shift = np.clip(random.standard_normal(len(time)), -2, 2) * machine.jitter
    shift[[0, -1]] = 0.0
    return time + shift


def _measured(force: Array, time: Array, machine: Machine, random: np.random.Generator) -> Array:
    """What the load cell shows of a true force."""
    shown = force + machine.zero_offset + machine.drift * time
    shown = shown + machine.load_cell_noise * random.standard_normal(len(force))
    shown = np.clip(shown, -machine.load_cell_range, machine.load_cell_range)
    return stepped(shown, machine.force_quantisation)


def pull(
    brake: Brake,
    vacuum: float,
    speed: float,
    travel: float,
    machine: Machine | None = None,
    repeat: int = 1,
    name: str | None = None,
) -> Trace:
    """A slow pull of a brake from rest, shape (N,) each.

    `vacuum` [Pa], `speed` of the crosshead [m/s], `travel` of the crosshead [m]. The truth is
    F = k (u - x), with x the slip at elongation u = speed * t and k the brake's working stiffness,
    which holds the compliance of the mount already. Needs JAX in double precision
    (PrecisionError); QuantityError for a pull that cannot be.
    """
    from layerjam.mechanics.pull import slip_at_elongation
    from layerjam.mechanics.stiffness import working_stiffness

    machine = machine or Machine()
    for what, value in (("speed", speed), ("travel", travel)):
        if not (np.isfinite(value) and value > 0):
            raise QuantityError(f"{what}: {value} is not allowed; it is more than zero")
    random = machine.generator(repeat)
    time = _sampled(travel / speed, machine, random)
    elongation = speed * time
    slip = np.asarray(slip_at_elongation(elongation, vacuum, brake))
    force = float(working_stiffness(brake)) * (elongation - slip)
    if not np.isfinite(force).all():
        raise QuantityError.of(
            "vacuum",
            f"{vacuum:.6g} Pa is not allowed; it is zero or more, and below what makes "
            "the brake snap on its mount",
        )
    return Trace(
        _measured(force, time, machine, random),
        stepped(elongation, machine.elongation_quantisation),
        time,
        "",
        FORMAT,
        facts=Facts(
            vacuum=vacuum,
            speed=speed,
            repeat=repeat,
            brake=name,
            synthetic=True,
            seed=machine.seed,
        ),
    )


def friction(
    static: float,
    kinetic: float,
    normal_force: float,
    *,
    travel: float = 0.1,
    speed: float = 2.5e-3,
    machine: Machine | None = None,
    repeat: int = 1,
    static_sd: float = 0.0,
    kinetic_sd: float = 0.0,
    texture: float = 0.01,
    string_stiffness: float = 5e3,
) -> Trace:
    """A sled pulled over film by a string, as in the paper's friction test; shape (N,) each.

    The force rises along `string_stiffness` [N/m] to static * normal_force [N], drops to
    kinetic * normal_force and stays there over `travel` [m] of the crosshead at `speed` [m/s].
    The coefficients scatter from repeat to repeat by `static_sd` and `kinetic_sd` (absolute), and
    along the film by `texture` (relative, over about 1 mm).
    """
    machine = machine or Machine(load_cell_noise=0.002, load_cell_range=10.0)
    positive = {"static": static, "kinetic": kinetic, "normal_force": normal_force}
    positive |= {"travel": travel, "speed": speed, "string_stiffness": string_stiffness}
    for what, value in positive.items():
        if not (np.isfinite(value) and value > 0):
            raise QuantityError(f"{what}: {value} is not allowed; it is more than zero")
    random = machine.generator(repeat)
    time = _sampled(travel / speed, machine, random)
    elongation = speed * time
    of_static = static + static_sd * random.standard_normal()
    of_kinetic = kinetic + kinetic_sd * random.standard_normal()
    sliding = of_kinetic * normal_force * (1 + texture * rough(elongation, random))
    drawn = sled_force(elongation, of_static * normal_force, sliding, string_stiffness)
    return Trace(
        _measured(drawn, time, machine, random),
        stepped(elongation, machine.elongation_quantisation),
        time,
        "",
        FORMAT,
        facts=Facts(
            speed=speed,
            repeat=repeat,
            normal_force=normal_force,
            synthetic=True,
            seed=machine.seed,
        ),
    )


def sled_force(elongation: Array, static: float, sliding: Array, stiffness: float) -> Array:
    """Force of a sled's string [N]: along `stiffness` [N/m] up to `static` [N], then `sliding`."""
    rising = stiffness * elongation
    broken = np.maximum.accumulate(rising >= static)
    return np.where(broken, sliding, rising)


def rough(elongation: Array, random: np.random.Generator) -> Array:
    """A random profile with unit standard deviation that changes over about 1 mm."""
    knots = np.arange(0.0, elongation[-1] + 2e-3, 1e-3)
    return np.interp(elongation, knots, random.standard_normal(len(knots)))


def write_own(trace: Trace, path: str | Path, force: bool = False) -> Path:
    """Write our own CSV (SI, every digit) and its sidecar; FileError where they exist already."""
    return _write(trace, path, "own", force)


def write_bluehill(trace: Trace, path: str | Path, force: bool = False) -> Path:
    """Write as Instron Bluehill does: everything in quotes, names over units, s, mm and N."""
    return _write(trace, path, "bluehill", force)


def write_testxpert(trace: Trace, path: str | Path, force: bool = False) -> Path:
    """Write as Zwick testXpert does (.TRA): Latin-1, specimen lines, numbers of six digits."""
    return _write(trace, path, "testxpert", force)


WRITERS = {"own": write_own, "bluehill": write_bluehill, "testxpert": write_testxpert}


def _write(trace: Trace, path: str | Path, layout: str, force: bool) -> Path:
    return write_pair(trace, path, file_bytes(trace, Form(layout=layout)), force)
