"""Masses, amounts and margins of many drawn brakes in closed form, without files or meshes."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.workshop import Build, Casting, check_build
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.evolve import evolve
from layerjam.workshop.design.bill import Bill
from layerjam.workshop.fabricate import checks as rules
from layerjam.workshop.fabricate.choices import resolve_choices
from layerjam.workshop.fabricate.film import film_parts, hole_checks, stock_margin
from layerjam.workshop.fabricate.lengths import (
    CannotBuildError,
    Lengths,
    compute_lengths,
    map_arrays,
    mm,
)
from layerjam.workshop.fabricate.masses import mass_rows
from layerjam.workshop.fabricate.nest import CutPart
from layerjam.workshop.fabricate.parts import Part, make_parts
from layerjam.workshop.fabricate.verdicts import ROUNDING, Check

FITS = ("clamp-length", "nut-width", "head-width", "least-wall")
"""Checks that determine whether parts fit together."""


@dataclass(frozen=True)
class Draws:
    """Function that draws brakes with the choices of one workshop."""

    build: Build
    casting: Casting = Casting()

    def __call__(self, brake: Brake, force: Any) -> Bill:
        """Return the bills of brakes whose sheets are arrays (n,), at their maximum forces [N].

        Forces and kinetic friction may have a first axis for samples of each brake. The list of
        prisms depends on the numbers of screws and mould bolts, so brakes with the same numbers are
        drawn together.
        """
        sizes = compute_lengths(brake, self.build)
        has_limit = ~np.isnan(np.asarray(brake.film.strength, float))
        columns = (sizes.screws, sizes.mould.bolts, has_limit)
        counts = np.array([np.broadcast_to(row, force.shape[-1]) for row in columns], int)
        shape = counts.max(axis=1) + 1
        keys = np.ravel_multi_index(tuple(counts), tuple(shape))
        bill = np.full((len(Bill._fields), *force.shape), np.nan)
        for key in np.unique(keys):
            screws, bolts, is_strong = np.unravel_index(key, tuple(shape))
            place = np.flatnonzero(keys == key)
            group = map_arrays(sizes, partial(_select_rows, place))
            mould = evolve(group.mould, bolts=int(bolts))
            group = evolve(group, screws=int(screws), mould=mould)
            brakes = map_arrays(brake, partial(_select_rows, place))
            if not is_strong:
                brakes = evolve(brakes, film=evolve(brakes.film, strength=None))
            with np.errstate(invalid="ignore"):
                rows = np.broadcast_arrays(*self._compute_bill(brakes, group, force[..., place]))
            bill[..., place] = rows
        return Bill(*bill)

    def _compute_bill(self, brake: Brake, sizes: Lengths, force: Any) -> Bill:
        solids, film = make_parts(sizes, self.build), film_parts(self.build, sizes)
        volumes = {
            is_in_brake: sum(
                p.solid.volume * p.count for p in solids if p.printed and p.stays is is_in_brake
            )
            for is_in_brake in (True, False)
        }
        shapes = [*self._drawing_margins(brake, sizes)]
        margins = [
            (check.key, check.margin())
            for check in self._list_checks(brake, sizes, force, solids, film)
            if check.otherwise != "warning"
        ]
        all_margins = [stock_margin(film, self.build), *shapes, *(margin for _, margin in margins)]
        # closed-form volumes are wrong for parts that do not fit together
        fit_margins = np.broadcast_arrays(*shapes, *(m for key, m in margins if key in FITS))
        fits = np.min(fit_margins, axis=0) >= 1
        amounts = (
            sum(part.outline.area() * part.count for part in film) * 1e-6,
            volumes[True] * 1e-9,
            volumes[False] * 1e-9,
            sum(row.mass for row in mass_rows(brake, self.build, sizes, solids)),
        )
        film_area, print_volume, tools, mass = (np.where(fits, row, np.nan) for row in amounts)
        # rounding may end a search slightly beyond a limit, and a build would reject the result
        margin = np.min(np.broadcast_arrays(*all_margins), axis=0) * (1 - 4 * ROUNDING)
        return Bill(film_area, print_volume, tools, mass, margin)

    def _drawing_margins(self, brake: Brake, sizes: Lengths) -> Iterator[Any]:
        """Yield the margins of the rules whose violation is an error in a build."""
        for _, value, limit, _ in rules.drawable_limits(self.build, sizes):
            with np.errstate(divide="ignore", invalid="ignore"):
                share = np.divide(limit, value) * (1 - ROUNDING)
            # only a value below zero meets a limit of zero
            yield np.where(np.asarray(value) > 0, share, np.where(value < limit, np.inf, 0.0))
        for radius in (self.build.tip_radius, self.build.clamp_radius):
            yield sizes.width / 2 / mm(radius) * (1 - ROUNDING) if radius else np.inf

    def _list_checks(
        self, brake: Brake, sizes: Lengths, force: Any, solids: list[Part], film: list[CutPart]
    ) -> Iterator[Check]:
        """Yield the checks of a build, except those of the stock and the cutter."""
        yield from hole_checks(film, sizes)
        yield from rules.part_checks(brake, self.build, self.casting, sizes, solids, force)

    def reason(self, brake: Brake, force: float) -> str | None:
        """Return the first reason why a brake cannot be built; None if it can."""
        try:
            check_build(brake, self.build)
            sizes = compute_lengths(brake, self.build)
            rules.check_drawability(brake, self.build, sizes)
        except (CannotBuildError, QuantityError) as error:
            return str(error)
        solids, film = make_parts(sizes, self.build), film_parts(self.build, sizes)
        checks = self._list_checks(brake, sizes, force, solids, film)
        return next((f"{c.code}: {c.text}" for c in checks if c.level == "failed"), None)


def _select_rows(place: Any, row: Any) -> Any:
    return row[..., place]


def drawn_mass(file: BrakeFile) -> float | None:
    """Return the mass [kg] of one brake as drawn, excluding parts of unknown mass.

    It is None if the parts do not fit together.
    """
    try:
        build = resolve_choices(file).build
        sizes = compute_lengths(file.brake, build)
        rules.check_drawability(file.brake, build, sizes)
    except (FileError, CannotBuildError, QuantityError):
        return None
    fits = (*rules.clamping_checks(build, sizes), rules.wall_check(build, sizes))
    if not all(check.ok for check in fits):
        return None
    return float(sum(r.mass for r in mass_rows(file.brake, build, sizes, make_parts(sizes, build))))
