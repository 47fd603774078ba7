"""Intervals of many campaigns from the values of their pulls, without their curves.

What a pull of the virtual laboratory tells is its peak, its slope and, fitted whole, its own three
parameters. Here they are drawn with the errors that reading a curve leaves, for many campaigns at
once. Mountings, enclosure, scatter and intervals are those of `calibrate`. tests/interval_coverage
checks on whole records that reading the curves adds nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import special

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import peak, scale_factor_of_peak
from layerjam.laboratory.identify.bayes.model import priors
from layerjam.laboratory.identify.calibration.budget import Peak, enclosure_line
from layerjam.laboratory.identify.calibration.influence import make_interval
from layerjam.laboratory.identify.calibration.intervals import Interval, Population
from layerjam.laboratory.identify.calibration.least_squares import WORKING
from layerjam.laboratory.identify.calibration.mountings import find_mountings
from layerjam.laboratory.identify.calibration.peaks import join_means
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.shape import SHAPE, change_shape
from strategies import BARE_CURVE

TRAVEL = 0.04
READING = 1e-3
"""Relative error of a peak and of a slope that are read from a curve."""
LOGS = np.linspace(-10.0, 0.5, 60)
"""Logarithms of the scatter over which the posterior is integrated."""


@dataclass(frozen=True, kw_only=True)
class Pulls:
    """The pulls of one campaign: what was true, and what each tells."""

    brake: Brake
    truth: dict[str, float]
    curves: tuple[Curve, ...]
    own: np.ndarray
    """Own scale factor, stiffness and enclosure's factor, (pulls, 3)."""
    told: np.ndarray
    """Scale factor of the peak with the file's enclosure, and slope, (pulls, 2)."""
    peaks: tuple[Peak, ...]


def draw(case: Any, campaigns: int, seed: Any) -> list[Pulls]:
    """Random campaigns of a case of interval_coverage, all peaks in one call of the law."""
    random = np.random.Generator(np.random.PCG64(seed))
    rows, spans, plans = [], [], []
    for _ in range(campaigns):
        brake = load(case.brakes[random.integers(len(case.brakes))]).brake
        truth = {
            "scale_factor": float(brake.scale_factor * random.uniform(0.75, 1.3)),
            "stiffness": float((brake.stiffness_measured or 1e5) * random.uniform(0.7, 1.4)),
            "enclosure_factor": 1.0 + case.enclosure_off * random.choice((-1, 1))
            if case.depth == "exact"
            else float(random.uniform(0.7, 1.4)),
        }
        spread = np.array([random.uniform(0.01, top) for top in (0.05, 0.05, 0.1)])
        levels = random.choice([0.25, 0.4, 0.6, 0.8, 1.0], random.choice(case.vacuums), False)
        vacuums = levels * 94.5e3 * random.uniform(0.95, 1.0)
        repeats = random.choice(case.repeats, len(vacuums))
        places = [
            (vacuum, speed, repeat)
            for vacuum, count in zip(vacuums, repeats, strict=True)
            for speed in case.speeds
            for repeat in range(count)
        ]
        common = case.between or 0.0
        mounted = random.standard_normal((max(repeats), 3))
        z = math.sqrt(1 - common) * random.standard_normal((len(places), 3))
        z += math.sqrt(common) * mounted[[repeat for *_, repeat in places]]
        own = np.array(list(truth.values())) * (1 + spread * z)
        spans.append(slice(len(rows), len(rows) + len(places)))
        rows += [(brake, vacuum) for vacuum, *_ in places]
        plans.append((brake, truth, places, own))
    owns = np.concatenate([own for *_, own in plans])
    vacuum = np.array([v for _, v in rows])
    height, factor = np.zeros(len(rows)), np.zeros(len(rows))
    read = 1 + READING * random.standard_normal((len(rows), 2))
    for name in case.brakes:
        brake = load(name).brake
        here = np.array([b.film.kinetic == brake.film.kinetic for b, _ in rows])
        if here.any():
            real = change_shape(brake, *owns[here].T)
            height[here] = np.asarray(peak(vacuum[here], TRAVEL, real).force) * read[here, 0]
            factor[here] = np.asarray(scale_factor_of_peak(height[here], vacuum[here], brake))
    made = []
    for span, (brake, truth, places, own) in zip(spans, plans, strict=True):
        numbers = [repeat + 1 for *_, repeat in places]
        if case.between is None:
            numbers = list(range(len(places)))
        curves = tuple(
            replace(
                BARE_CURVE,
                vacuum=vacuum,
                speed=speed,
                mounting=number if case.stated else None,
            )
            for (vacuum, speed, _), number in zip(places, numbers, strict=True)
        )
        slope = own[:, 1] * read[span, 1]
        made.append(
            Pulls(
                brake=brake,
                truth=truth,
                curves=curves,
                own=own,
                told=np.column_stack([factor[span], slope]),
                peaks=tuple(
                    Peak(float(f), float(v))
                    for f, v in zip(height[span], vacuum[span], strict=True)
                ),
            )
        )
    return made


def intervals(case: Any, pulls: Pulls) -> dict[str, Interval | None]:
    """The intervals of one campaign by the method of the case."""
    if case.depth == "exact":
        return of_peaks(pulls)
    return of_curves(pulls) if case.depth == "curves" else of_posterior(pulls)


def of_peaks(pulls: Pulls) -> dict[str, Interval | None]:
    """As `calibrate` at depth exact."""
    mounted = find_mountings(pulls.curves, np.log(pulls.told))
    enclosure = enclosure_line(pulls.peaks, pulls.brake).relative or 0.0
    found = {}
    for name, values, shared in zip(SHAPE[:2], pulls.told.T, (enclosure, 0.0), strict=True):
        shared = math.hypot(shared, mounted.unseen.get(name, 0.0))  # noqa: PLW2901
        units = join_means({name: values.tolist()}).join_groups(mounted.groups)
        error = units.standard_error(np.ones(1))
        found[name] = make_interval(name, float(units.estimate[0]), error, shared, "")
    return found


def of_curves(pulls: Pulls) -> dict[str, Interval | None]:
    """As `calibrate` at depth curves, if noise is small: then every curve weighs alike."""
    logs = np.column_stack([np.log(pulls.own[:, :2]), pulls.own[:, 2]])
    mounted = find_mountings(pulls.curves, logs - logs.mean(axis=0))
    units = Population(
        estimate=logs.mean(axis=0),
        design=np.tile(np.diag(1 / WORKING), (len(logs), 1, 1)),
        residual=(logs - logs.mean(axis=0)) / WORKING,
    ).join_groups(mounted.groups)
    found: dict[str, Interval | None] = {}
    for place, name in enumerate(SHAPE):
        told = units.standard_error(np.eye(3)[place])
        at = float(units.estimate[place])
        value, size = (at, 1.0) if place == 2 else (math.exp(at), math.exp(at))
        found[name] = make_interval(name, value, told and (size * told[0], told[1]),
            mounted.unseen.get(name, 0.0), "",
        )  # fmt: skip
    return found


def of_posterior(pulls: Pulls) -> dict[str, Interval | None]:
    """The Bayesian model's posterior, integrated over both scatters on a grid.

    Curves tell their own values far better than these scatter. Scale factor and stiffness are then
    a hierarchy of normal values with a scatter within and between mountings. For the priors of both
    and a wide one of the mean see `priors`; pulls in equal numbers of each mounting.
    """
    known = priors(pulls.brake, mounted=True)
    groups = [c.mounting for c in pulls.curves]
    logs = np.log(pulls.own[:, :2])
    found: dict[str, Interval | None] = {}
    for name, column in zip(SHAPE[:2], logs.T, strict=True):
        y = np.array([column[np.array(groups) == group] for group in sorted(set(groups))])
        count, each = y.shape
        inner, outer = LOGS[:, None], LOGS
        low = sum(
            -0.5 * ((at - known[key].place) / known[key].sd) ** 2
            for at, key in ((inner, f"{name}_sd"), (outer, f"{name}_mounting_sd"))
        )
        own, both = np.exp(2 * inner), np.exp(2 * inner) + each * np.exp(2 * outer)
        means = y.mean(axis=1)
        within = float(((y - means[:, None]) ** 2).sum())
        between = each * float(((means - means.mean()) ** 2).sum())
        low = low - 0.5 * count * (each - 1) * np.log(own) - 0.5 * (count - 1) * np.log(both)
        low = low - 0.5 * within / own - 0.5 * between / both
        weight = np.exp(low - low.max()).ravel()
        keep = weight > 1e-6
        weight = weight[keep] / weight[keep].sum()
        error = np.sqrt(both / y.size).ravel()[keep]
        at = means.mean() + np.linspace(-8, 8, 321) * float((weight * error).sum())
        share = special.ndtr((at[:, None] - means.mean()) / error) @ weight
        ends = np.exp(np.interp((0.025, 0.975), share, at))
        middle = float(np.exp(means.mean()))
        found[name] = Interval(
            low=float(ends[0]),
            high=float(ends[1]),
            standard_error=float(ends[1] - ends[0]) / 4,
            degrees_of_freedom=math.inf,
            coverage_factor=2.0,
            method=f"posterior about {middle:.3g}",
        )
    return found
