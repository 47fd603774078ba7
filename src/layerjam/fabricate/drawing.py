"""One build: its lengths, parts, film, masses and checks, before any file is made of it."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from types import MappingProxyType

from layerjam.device.file import BrakeFile
from layerjam.device.gauge import notices_of_gauge
from layerjam.device.workshop import Build
from layerjam.errors import Notice
from layerjam.fabricate import checks as rules
from layerjam.fabricate.choices import Choices
from layerjam.fabricate.film import Film, film, pitch
from layerjam.fabricate.lengths import Lengths, lengths
from layerjam.fabricate.masses import MassRow, mass_rows
from layerjam.fabricate.parts import Part, parts
from layerjam.fabricate.silicone import halves, mixed
from layerjam.fabricate.strength import preload, torque
from layerjam.fabricate.verdicts import Check, notices
from layerjam.records.source import Source
from layerjam.records.values import entries
from layerjam.units import show
from layerjam.verdict import Acceptance

BASIS: Mapping[str, str] = MappingProxyType(
    tomllib.loads(files("layerjam.fabricate").joinpath("basis.toml").read_text(encoding="utf-8"))
)
"""{key of [build]: what its default rests on}."""

SCREWS = "ours, one for every 20 mm of width; the paper says 'corresponding screw'"
"""What the number of screws rests on where nobody stated it."""

DRAWN = (
    "the paper prints no dimension of cap, clamp, neck, enclosure's end or mould: all are ours",
    "spacers of the same film lie between the sheets in both caps; the paper mentions none",
    "screws and nuts by ISO 4762, 4032, 273 and 888, of steel, 7850 kg/m^3, a screw's thread and "
    "socket taken as a tenth of it",
    "friction of film on printed plastic is not known: film on film stands in for it",
)
"""What else is assumed in every build."""


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """All that is known of a build; `parallel` times `series` equal brakes."""

    file: BrakeFile
    choices: Choices
    lengths: Lengths
    parts: Sequence[Part]
    film: Film
    masses: Sequence[MassRow]
    checks: Sequence[Check]
    force: float
    """Greatest force on one brake [N]."""
    parallel: int = 1
    series: int = 1
    accepted: Sequence[Acceptance] = ()
    """Failed checks of the brake's file and of the build that somebody accepted."""

    def stating(self, accepted: Sequence[Acceptance]) -> Drawing:
        """Return the build whose files state these accepted checks."""
        said = [
            " ".join(f"Check {one.check} failed; accepted on {one.date}: {one.reason}".split())
            for one in accepted
        ]
        film = replace(self.film, notes=[*self.film.notes, *said])
        return replace(self, film=film, accepted=tuple(accepted))

    @property
    def brakes(self) -> int:
        """Brakes in all."""
        return self.parallel * self.series

    @property
    def build(self) -> Build:
        """The choices' values."""
        return self.choices.build

    @property
    def preload(self) -> float:
        """Force of each clamp's screw [N]."""
        return preload(self.force, self.file.brake, self.lengths)

    @property
    def torque(self) -> float:
        """Torque of each clamp's screw [N m]."""
        return torque(self.force, self.file.brake, self.build, self.lengths)

    @property
    def silicone_mass(self) -> float:
        """Silicone to mix for all brakes, waste included [kg]."""
        density = self.file.brake.enclosure.density
        return self.brakes * mixed(self.lengths, self.build, density)

    @property
    def silicone_parts(self) -> list[float] | None:
        """Masses of A and B [kg]; None where the mix is not known."""
        return halves(self.file.making.enclosure.mix, self.silicone_mass)

    @property
    def yoke_moment(self) -> float | None:
        """Greatest bending moment [N m] in each of a side's two yokes; None without a yoke."""
        if self.parallel == 1:
            return None
        step, middle = pitch(self.build, self.lengths) * 1e-3, (self.parallel - 1) / 2
        return self.force * sum(abs(i - middle) * step for i in range(self.parallel)) / 4

    def assumptions(self) -> list[str]:
        """What nobody has measured or given, each with the reason for its value."""
        known = dict(entries(Build))
        said = []
        for name in self.choices.assumed:
            value, spec = getattr(self.build, name), known[name].spec
            if value is None:
                continue
            said.append(f"build.{name} = {spec.to_toml(value)}: {BASIS[name]}")
        if self.file.brake.mount.screws is None:
            said.append(f"mount.screws = {self.lengths.screws}: {SCREWS}")
        return [*said, *DRAWN]

    def notices(self) -> list[Notice]:
        """What is to be warned of."""
        return [*notices(self.checks), *_notices(self)]


def drawing(
    file: BrakeFile, chosen: Choices, force: float, parallel: int = 1, series: int = 1
) -> Drawing:
    """The build of a brake whose greatest force is `force` [N].

    Raises QuantityError for choices that contradict each other, CannotBuildError where no lengths
    can be found. Whether the rest can be built say `checks`.
    """
    brake, build, known = file.brake, chosen.build, file.making.enclosure
    found = lengths(brake, build)
    rules.agree_drawn(brake, build, found)
    drawn = parts(found, build)
    rows = mass_rows(brake, build, found, drawn)
    cut = film(file, build, found, parallel * series)
    known_by = file.sources.get("film.kinetic", Source())
    source = ": ".join(filter(None, (known_by.kind, known_by.text)))
    made = [
        *cut.checks,
        *rules.part_checks(brake, build, known, found, drawn, force, source),
        *rules.mass_checks(brake, rows),
    ]
    return Drawing(
        file=file,
        choices=chosen,
        lengths=found,
        parts=drawn,
        film=cut,
        masses=rows,
        checks=sorted(made, key=lambda check: int(check.code[1:])),
        force=force,
        parallel=parallel,
        series=series,
    )


def _notices(made: Drawing) -> list[Notice]:
    brake, found = made.file.brake, made.lengths
    said = [*notices_of_gauge(made.file), *rules.screw_notices(found)]
    for side in found.sides:
        surplus = side.clamped * 1e-3 - brake.mount.clamped_length
        if surplus > 1e-6:
            said.append(
                Notice(
                    f"the {side.name} sheets are {show(surplus, 'm')} longer than free length, "
                    "overlap and clamped length together: the surplus goes into the clamp, and "
                    "the cap grows",
                    "surplus-length",
                )
            )
    if found.count % 2 == 0:
        said.append(
            Notice(
                f"{found.count} sheets: one outer face is a left sheet, the other a right one; "
                "mark the faces",
                "even-count",
            )
        )
    source = made.file.sources.get("sheets.usable_travel", Source())
    if source.kind != "measured":
        travel = show(brake.sheets.usable_travel, "m")
        said.append(
            Notice(
                f"usable travel of {travel} has not been tested on this brake", "untested-travel"
            )
        )
    said.append(
        Notice(
            "uncured resin inhibits platinum silicone: seal a resin mould, and cure a dab on it "
            "first",
            "resin-mould",
        )
    )
    if made.parallel > 1 and made.yoke_moment is not None:
        said.append(
            Notice(
                f"each yoke bends with {show(made.yoke_moment, 'N m', 3)}: its section modulus is "
                "at least that over the stress it may bear; brakes side by side share their "
                "elongation only while the yoke does not tilt",
                "yoke",
            )
        )
    said.append(Notice("never cut, printed or cast by us", "never-built"))
    return said
