"""Many brakes as they would be drawn, by closed forms: no file, no mesh, no library."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from layerjam.design.bill import Bill
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.device.workshop import Build, Casting, check_build
from layerjam.errors import FileError, QuantityError
from layerjam.fabricate import checks as rules
from layerjam.fabricate.choices import choices
from layerjam.fabricate.film import film_parts, hole_checks, stock_margin
from layerjam.fabricate.lengths import CannotBuildError, Lengths, change_arrays, lengths, mm
from layerjam.fabricate.masses import mass_rows
from layerjam.fabricate.nest import Wanted
from layerjam.fabricate.parts import Part, parts
from layerjam.fabricate.verdicts import ROUNDING, Check

FITS = ("clamp-length", "nut-width", "head-width", "least-wall")
"""Checks without which parts do not fit together."""


@dataclass(frozen=True)
class Draws:
    """Draws brakes by one workshop's choices: what each is made of, and whether it can be built."""

    build: Build
    casting: Casting = Casting()

    def __call__(self, brake: Brake, force: Any) -> Bill:
        """Return the bills of brakes whose sheets are arrays, at their greatest forces [N].

        A number of screws or of the mould's bolts changes the list of prisms: brakes that share
        both are drawn at once.
        """
        found = lengths(brake, self.build)
        known = ~np.isnan(np.asarray(brake.film.strength, float))
        keys = np.stack(np.broadcast_arrays(found.screws, found.mould.bolts, known, force)[:3])
        bill = np.full((len(Bill._fields), keys.shape[1]), np.nan)
        for screws, bolts, strong in np.unique(keys, axis=1).T:
            place = np.flatnonzero((keys == np.array([[screws], [bolts], [strong]])).all(axis=0))
            sub = change_arrays(found, partial(_rows, place))
            mould = replace(sub.mould, bolts=int(bolts))
            sub = replace(sub, screws=int(screws), mould=mould)
            some = change_arrays(brake, partial(_rows, place))
            if not strong:
                some = replace(some, film=replace(some.film, strength=None))
            with np.errstate(invalid="ignore"):
                rows = np.broadcast_arrays(*self._bill(some, sub, force[place]))
            bill[:, place] = rows
        return Bill(*bill)

    def _bill(self, brake: Brake, found: Lengths, force: Any) -> Bill:
        made, film = parts(found, self.build), film_parts(self.build, found)
        volumes = {
            stays: sum(p.solid.volume * p.count for p in made if p.printed and p.stays is stays)
            for stays in (True, False)
        }
        shapes = [*self._geometry(brake, found)]
        margins = [
            (check.key, check.margin())
            for check in self._checks(brake, found, force, made, film)
            if check.otherwise != "warning"
        ]
        every = [stock_margin(film, self.build), *shapes, *(margin for _, margin in margins)]
        # of parts that do not fit together the volumes by closed form mean nothing
        drawn = np.broadcast_arrays(*shapes, *(m for key, m in margins if key in FITS))
        fits = np.min(drawn, axis=0) >= 1
        amounts = (
            sum(part.outline.area() * part.count for part in film) * 1e-6,
            volumes[True] * 1e-9,
            volumes[False] * 1e-9,
            sum(row.mass for row in mass_rows(brake, self.build, found, made)),
        )
        film_area, printed, tools, mass = (np.where(fits, row, np.nan) for row in amounts)
        # a search ends a rounding beyond its limits, which a build would refuse
        margin = np.min(np.broadcast_arrays(*every), axis=0) * (1 - 4 * ROUNDING)
        return Bill(film_area, printed, tools, mass, margin)

    def _geometry(self, brake: Brake, found: Lengths) -> Iterator[Any]:
        """Margins of the rules that are errors in a build."""
        for _, value, limit, _ in rules.drawable_limits(self.build, found):
            with np.errstate(divide="ignore", invalid="ignore"):
                share = np.divide(limit, value) * (1 - ROUNDING)
            # below a limit of zero lies what is less than zero
            yield np.where(np.asarray(value) > 0, share, np.where(value < limit, np.inf, 0.0))
        for radius in (self.build.tip_radius, self.build.clamp_radius):
            yield found.width / 2 / mm(radius) * (1 - ROUNDING) if radius else np.inf

    def _checks(
        self, brake: Brake, found: Lengths, force: Any, made: list[Part], film: list[Wanted]
    ) -> Iterator[Check]:
        """The checks of a build, but for the stock and the cutter."""
        yield from hole_checks(film, found)
        yield from rules.part_checks(brake, self.build, self.casting, found, made, force)

    def reason(self, brake: Brake, force: float) -> str | None:
        """Return the first reason why one brake cannot be built; None if it can."""
        try:
            check_build(brake, self.build)
            found = lengths(brake, self.build)
            rules.agree_drawn(brake, self.build, found)
        except (CannotBuildError, QuantityError) as error:
            return str(error)
        made, film = parts(found, self.build), film_parts(self.build, found)
        failed = (c for c in self._checks(brake, found, force, made, film) if c.level == "failed")
        return next((f"{check.code}: {check.text}" for check in failed), None)


def _rows(place: Any, row: Any) -> Any:
    return row[place]


def drawn_mass(file: BrakeFile) -> float | None:
    """Mass [kg] of one brake as `build` draws it, of the parts that have a mass before weighing.

    None where its parts would not fit together.
    """
    try:
        build = choices(file).build
        found = lengths(file.brake, build)
        rules.agree_drawn(file.brake, build, found)
    except (FileError, CannotBuildError, QuantityError):
        return None
    fits = (*rules.clamp_checks(build, found), rules.wall_check(build, found))
    if not all(check.ok for check in fits):
        return None
    return float(sum(r.mass for r in mass_rows(file.brake, build, found, parts(found, build))))
