"""One build before any file is written: lengths, parts, film, masses and checks."""

import itertools
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from types import MappingProxyType

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.gauge import gauge_notices
from layerjam.brake.device.workshop import Build
from layerjam.core.brief import brief
from layerjam.core.errors import Notice
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.values import entries
from layerjam.core.units import show
from layerjam.core.verdict import Acceptance
from layerjam.workshop.fabricate import checks as rules
from layerjam.workshop.fabricate.choices import Choices
from layerjam.workshop.fabricate.film import Film, brake_pitch, lay_out_film
from layerjam.workshop.fabricate.lengths import Lengths, compute_lengths
from layerjam.workshop.fabricate.masses import MassRow, mass_rows
from layerjam.workshop.fabricate.parts import Part, make_parts
from layerjam.workshop.fabricate.silicone import compute_mix_mass, split_mix
from layerjam.workshop.fabricate.strength import screw_preload, screw_torque
from layerjam.workshop.fabricate.verdicts import Check, warning_notices

BASIS: Mapping[str, str] = MappingProxyType(
    tomllib.loads(
        files("layerjam.workshop.fabricate").joinpath("basis.toml").read_text(encoding="utf-8")
    )
)
"""{key of [build]: basis of its default}."""

SCREWS = "layerjam assumes one for every 20 mm of width; the paper mentions a 'corresponding screw'"
"""Basis of the default number of screws."""

DRAWN = (
    "the paper gives no dimensions of cap, clamp, neck, enclosure end or mould: layerjam "
    "assumes all of them",
    "spacers of the same film lie between the sheets in both caps; the paper mentions none",
    "screws and nuts to ISO 4762, 4032, 273 and 888, of steel, 7850 kg/m^3, with a tenth "
    "subtracted for a screw's thread and socket",
    "friction of film on printed plastic is unknown: that of film on film is used instead",
)
"""Assumptions of every build."""


@brief
@dataclass(frozen=True, kw_only=True)
class Drawing:
    """All data of a build of `parallel` × `series` identical brakes."""

    file: BrakeFile
    choices: Choices
    lengths: Lengths
    parts: Sequence[Part]
    film: Film
    masses: Sequence[MassRow]
    checks: Sequence[Check]
    force: float
    """Maximum force on one brake [N]."""
    parallel: int = 1
    series: int = 1
    accepted: Sequence[Acceptance] = ()
    """Accepted failed checks of the brake's file and of the build."""

    def with_acceptances(self, acceptances: Sequence[Acceptance]) -> "Drawing":
        """Return the build with these acceptances of failed checks, which its files then state."""
        sentences = [
            " ".join(f"Check {row.check} failed; accepted on {row.date}: {row.reason}".split())
            for row in acceptances
        ]
        film = evolve(self.film, notes=[*self.film.notes, *sentences])
        return evolve(self, film=film, accepted=tuple(acceptances))

    @property
    def brakes(self) -> int:
        """Total number of brakes."""
        return self.parallel * self.series

    @property
    def build(self) -> Build:
        """Choices for the build, without their sources."""
        return self.choices.build

    @property
    def preload(self) -> float:
        """Force to which each clamp screw is tightened [N]."""
        return screw_preload(self.force, self.file.brake, self.lengths)

    @property
    def torque(self) -> float:
        """Tightening torque of each clamp screw [N m]."""
        return screw_torque(self.force, self.file.brake, self.build, self.lengths)

    @property
    def silicone_mass(self) -> float:
        """Mass of silicone to mix for all brakes, including waste [kg]."""
        density = self.file.brake.enclosure.density
        return self.brakes * compute_mix_mass(self.lengths, self.build, density)

    @property
    def silicone_parts(self) -> list[float] | None:
        """Masses of the silicone's components A and B [kg]; None if the mixing ratio is unknown."""
        return split_mix(self.file.making.enclosure.mix, self.silicone_mass)

    @property
    def yoke_moment(self) -> float | None:
        """Maximum bending moment [N m] in each of a side's two yokes; None if there are none."""
        if self.parallel == 1:
            return None
        step, middle = brake_pitch(self.build, self.lengths) * 1e-3, (self.parallel - 1) / 2
        return self.force * sum(abs(i - middle) * step for i in range(self.parallel)) / 4

    def assumptions(self) -> list[str]:
        """Return the assumptions of the build, including each default value with its basis."""
        specs = dict(entries(Build))
        sentences = []
        for name in self.choices.default_keys:
            value, spec = getattr(self.build, name), specs[name].spec
            if value is None:
                continue
            sentences.append(f"build.{name} = {spec.to_toml(value)}: {BASIS[name]}")
        if self.file.brake.mount.screws is None:
            sentences.append(f"mount.screws = {self.lengths.screws}: {SCREWS}")
        return [*sentences, *DRAWN]

    def notices(self) -> list[Notice]:
        """Return the warnings of a build."""
        notices = gauge_notices(self.file), rules.screw_notices(self.lengths), _list_notices(self)
        return [*warning_notices(self.checks), *itertools.chain(*notices)]


def draw_build(
    file: BrakeFile, choices: Choices, force: float, parallel: int = 1, series: int = 1
) -> Drawing:
    """Return the build of a brake whose maximum force is `force` [N].

    Raises QuantityError for choices in conflict, CannotBuildError if no screw is long enough. Any
    other reason why it cannot be built is in the result's `checks`.
    """
    brake, build, casting = file.brake, choices.build, file.making.enclosure
    sizes = compute_lengths(brake, build)
    rules.check_drawability(brake, build, sizes)
    solids = make_parts(sizes, build)
    rows = mass_rows(brake, build, sizes, solids)
    cut = lay_out_film(file, build, sizes, parallel * series)
    friction = file.sources.get("film.kinetic", Source())
    source = ": ".join(filter(None, (friction.kind, friction.text)))
    all_checks = [
        *cut.checks,
        *rules.part_checks(brake, build, casting, sizes, solids, force, source),
        *rules.mass_checks(brake, rows),
    ]
    return Drawing(
        file=file,
        choices=choices,
        lengths=sizes,
        parts=solids,
        film=cut,
        masses=rows,
        checks=sorted(all_checks, key=lambda check: int(check.code[1:])),
        force=force,
        parallel=parallel,
        series=series,
    )


def _list_notices(plan: Drawing) -> Iterator[Notice]:
    brake, lengths = plan.file.brake, plan.lengths
    for side in lengths.sides:
        surplus = side.clamped * 1e-3 - brake.mount.clamped_length
        if surplus > 1e-6:
            yield Notice(
                f"the {side.name} sheets are {show(surplus, 'm')} longer than the sum of "
                "free length, overlap and clamped length: the surplus lengthens clamp and cap",
                "surplus-length",
            )
    if lengths.count % 2 == 0:
        yield Notice(
            f"{lengths.count} sheets: one outer face is a left sheet, the other a right "
            "sheet; mark the faces",
            "even-count",
        )
    if plan.build.print_strength is None:
        stresses = [c.value for c in plan.checks if c.code == "C9" and c.value is not None]
        yield Notice(
            "whether the printed caps hold was not checked (C9: up to "
            f"{show(max(stresses), 'Pa', 3)}): give build.print_strength of your plastic",
            "unchecked-caps",
        )
    source = plan.file.sources.get("sheets.usable_travel", Source())
    if source.kind != "measured":
        travel = show(brake.sheets.usable_travel, "m")
        text = f"the usable travel of {travel} has not been tested on this brake"
        yield Notice(text, "untested-travel")
    yield Notice(
        "uncured resin inhibits the cure of platinum silicone: seal a resin mould, and "
        "test-cure a drop on it first",
        "resin-mould",
    )
    if plan.yoke_moment is not None:
        yield Notice(
            f"each yoke bears a moment of {show(plan.yoke_moment, 'N m', 3)}: its section "
            "modulus must be at least this moment divided by the allowable stress. Brakes "
            "in parallel have the same elongation only if the yoke does not tilt",
            "yoke",
        )
    yield Notice("we have never cut, printed or cast this design", "never-built")
