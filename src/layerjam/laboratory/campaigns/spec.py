"""Specification of a campaign: brakes with their true values, tests, faults and files.

The unit, meaning and bounds of every number are defined once, here or in `faults`, and used by the
file reader, its error messages and the commented example.
"""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from types import MappingProxyType
from typing import Any

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.simulate.quantities import CROSSHEAD_SPEED, NORMAL_FORCE, SEED
from layerjam.core.errors import QuantityError
from layerjam.core.toml_files.values import ListSpec, TextSpec, value
from layerjam.core.units import QuantitySpec, check, like, nested, quantity, show
from layerjam.laboratory.campaigns.exports import ENCODINGS, LANGUAGES, LAYOUTS, Form
from layerjam.laboratory.campaigns.faults import Faults, LoadCell, check_consistency, fault

MOST_TESTS = 10_000
MOST_SAMPLES = 5_000_000
"""Largest number of samples in one test."""


def _list_field(unit: str, text: str, default: tuple[float, ...], **bounds: Any) -> Any:
    return value(ListSpec(each=QuantitySpec(unit, text, **bounds), distinct=True), default)


def _scatter_field(name: str) -> Any:
    return fault("1", f"{name}: relative standard deviation between repeats", 0.5)


def _fault_field(fault_text: str) -> Any:
    return quantity("1", f"files {fault_text}", hi=1000, whole=True, default=0)


def _text_field(text: str, default: Any, choices: tuple[str, ...] = ()) -> Any:
    """Return a field for a text, which must be one of the `choices`, if any."""
    return value(TextSpec(text=text, choices=choices), default)


@dataclass(frozen=True, kw_only=True)
class Truth:
    """A brake, and its true values if they differ from those in its file.

    None means the value in the file.
    """

    brake: str | BrakeFile = _text_field("catalogue name or path of a brake file", MISSING)
    label: str = _text_field("short name for its files; default: the name of the brake", "")
    scale_factor: float | None = quantity(
        "1", "true scale factor of the sheets' friction", lo=1e-3, hi=100, default=None
    )
    stiffness: float | None = quantity(
        "N/m", "true stiffness of brake and mount", lo=100, hi=1e9, default=None
    )
    enclosure_factor: float = quantity(
        "1", "true factor applied to the enclosure's force", lo=1e-3, hi=100, default=1.0
    )
    static: float | None = quantity(
        "1", "true static friction of the film on itself", lo=1e-4, hi=5, default=None
    )
    kinetic: float | None = quantity(
        "1", "true kinetic friction of the film on itself", lo=1e-4, hi=5, default=None
    )
    ageing: float | None = quantity(
        "1", "true growth of static friction per decade of hold time", lo=-1, hi=1, default=None
    )
    static_hold: float = quantity(
        "s", "hold time at which that growth is zero", lo=1e-3, hi=1e8, default=10.0
    )
    pressure_exponent: float | None = quantity(
        "1", "true exponent of the friction's dependence on pressure", lo=-0.9, hi=2, default=None
    )
    test_pressure: float = quantity(
        "Pa", "reference pressure of that exponent", lo=1, hi=1e7, default=3.9e3
    )
    speed_slope: float = quantity(
        "1",
        "true change in ln(friction) per decade of speed",
        lo=-0.5,
        hi=0.5,
        default=0.0,
    )
    speed_reference: float = quantity(
        "m/s", "reference speed of that slope", lo=1e-6, hi=10, default=0.01
    )


@dataclass(frozen=True, kw_only=True)
class Pulls:
    """Pulls of each brake, at all vacuums and all speeds."""

    vacuums: tuple[float, ...] = _list_field("Pa", "vacuums shown by the gauge", (), hi=120e3)
    speeds: tuple[float, ...] = _list_field(
        "m/s", "speeds of the crosshead", (13e-3,), lo=1e-6, hi=10.0
    )
    repeats: int = quantity(
        "1", "repeats at each vacuum and speed", lo=1, hi=1000, whole=True, default=3
    )
    travel: float = quantity(
        "m", "crosshead travel after the brake becomes taut", lo=1e-4, hi=5, default=0.04
    )
    unload: float = quantity("m", "return at the end, at the same speed", hi=5, default=0.0)


@dataclass(frozen=True, kw_only=True)
class FrictionTests(LoadCell):
    """Friction tests of each brake's film: a string pulls a sled over the film."""

    repeats: int = quantity("1", "repeats; 0 for none", hi=1000, whole=True, default=0)
    normal_force: float = like(
        NORMAL_FORCE, "force pressing the films together", default=0.25 * 9.80665
    )
    travel: float = quantity("m", "travel of the crosshead", lo=1e-3, hi=5, default=0.11)
    speed: float = like(CROSSHEAD_SPEED, default=2.5e-3)
    sampling_rate: float = quantity("Hz", "samples per second", lo=0.1, hi=1e6, default=100.0)
    string_stiffness: float = quantity(
        "N/m", "stiffness of string and load cell", lo=1, hi=1e7, default=300.0
    )
    holds: tuple[float, ...] = _list_field(
        "s", "hold times under load before the pulls; each is repeated", (), lo=1e-3, hi=1e8
    )
    texture: float = quantity(
        "1", "scatter of friction along the film, as a fraction of the mean", hi=0.3, default=0.01
    )
    static_scatter: float = _scatter_field("static friction")
    kinetic_scatter: float = _scatter_field("kinetic friction")
    stick_slip: float = fault("N", "stick-slip while sliding, peak to peak", 100)


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """Scatter of the brake from pull to pull; each factor is log-normal with mean 1."""

    friction: float = _scatter_field("sheets' friction")
    stiffness: float = _scatter_field("stiffness")
    enclosure: float = _scatter_field("enclosure's force")
    per: str = _text_field(
        "pulls that share one random draw: each pull separately, or all pulls with the "
        "same repeat number (for a brake that is dismounted between repeats)",
        "pull",
        ("pull", "repeat"),
    )


@dataclass(frozen=True, kw_only=True)
class Files:
    """Formats of the files; if there are several layouts, the files alternate between them."""

    layouts: tuple[str, ...] = value(
        ListSpec(each=TextSpec(text="layouts, used in turn", choices=tuple(LAYOUTS))), ("own",)
    )
    encoding: str = _text_field(
        "encoding; 'usual' is the default of each layout", "usual", ("usual", *ENCODINGS)
    )
    decimal: str = _text_field(
        "decimal sign; 'usual' is the default of each layout", "usual", ("usual", ".", ",")
    )
    language: str = _text_field("language of the column names", "en", tuple(LANGUAGES))

    def list_forms(self) -> list[Form]:
        """Return the forms between which the files alternate."""
        base_form = {"encoding": self.encoding, "decimal": self.decimal, "language": self.language}
        return [Form(layout=layout, **base_form) for layout in self.layouts]


@dataclass(frozen=True, kw_only=True)
class Practice:
    """Number of pull files, chosen by the seed, with each fault that a reader should detect."""

    cut_off: int = _fault_field("cut off in the middle of a line")
    header_only: int = _fault_field("with a header but no numbers")
    wrong_unit: int = _fault_field("with kN in the header but numbers in N")
    negative_force: int = _fault_field("from a machine that counts tension as negative")
    saturated: int = _fault_field("with a load cell that saturates at 80 % of the peak")
    no_sidecar: int = _fault_field("without a sidecar that states the vacuum")


def _outlier_field(name: str, lo: float = -0.9) -> Any:
    return quantity("1", f"{name}, as a fraction", lo=lo, hi=1, default=0.0)


@dataclass(frozen=True, kw_only=True)
class Odd:
    """Outlying pulls, chosen by the seed, which differ from the others only in these changes."""

    how_many: int = quantity("1", "number of outliers", hi=1000, whole=True, default=0)
    per: str = _text_field(
        "outliers: single pulls, or all pulls of a brake at one vacuum",
        "pull",
        ("pull", "vacuum"),
    )
    friction_change: float = _outlier_field("change in the sheets' friction from its true value")
    stiffness_change: float = _outlier_field("change in stiffness from its true value")
    vacuum_change: float = _outlier_field("vacuum in the brake minus the gauge reading")
    speed_change: float = _outlier_field("change in speed from the stated speed")
    overshoot: float = fault("1", "relative excess of the sheets' static friction", 1)
    seating: float = fault("m", "settling of grips and caps under the first load", 0.01)


@dataclass(frozen=True, kw_only=True)
class Spec:
    """A complete campaign; the same spec always produces exactly the same numbers."""

    brakes: tuple[Truth, ...] = ()
    seed: int = like(SEED, "seed of all random numbers", default=1)
    pulls: Pulls = nested(Pulls, default=Pulls())
    friction: FrictionTests = nested(FrictionTests, default=FrictionTests())
    scatter: Scatter = nested(Scatter, default=Scatter())
    machine: Faults = nested(Faults, default=Faults())
    files: Files = nested(Files, default=Files())
    practice: Practice = nested(Practice, default=Practice())
    odd: Odd = nested(Odd, default=Odd())


TABLES: Mapping[str, type] = MappingProxyType(
    {"brakes": Truth}
    | {f.name: f.metadata["record"] for f in fields(Spec) if "record" in f.metadata}
)


def check_spec(spec: Spec) -> Spec:
    """Return the spec if all numbers are within their bounds and consistent."""
    if not spec.brakes:
        raise QuantityError.of("brakes", "none is given; a campaign needs at least one [[brakes]]")
    for truth in spec.brakes:
        check(truth, "brakes.")
    check(spec)
    check_consistency(spec.machine)
    if spec.pulls.unload > spec.pulls.travel:
        raise QuantityError.of(
            "pulls.unload",
            f"{show(spec.pulls.unload, 'm')} exceeds the travel, {show(spec.pulls.travel, 'm')}",
        )
    if not spec.files.layouts:
        raise QuantityError.of("files.layouts", "none is stated; state at least one")
    for form in spec.files.list_forms():
        form.check_encoding()
    pulls = len(spec.brakes) * len(spec.pulls.vacuums) * len(spec.pulls.speeds)
    pulls *= spec.pulls.repeats
    tests = pulls + len(spec.brakes) * spec.friction.repeats
    if not tests:
        raise QuantityError.of(
            "pulls.vacuums", "neither brakes to pull nor friction tests are given"
        )
    if tests > MOST_TESTS:
        raise QuantityError(f"the campaign has {tests} tests; at most {MOST_TESTS} are allowed")
    places = len(spec.brakes) * len(spec.pulls.vacuums) if spec.odd.per == "vacuum" else pulls
    if spec.odd.how_many > places:
        raise QuantityError.of(
            "odd.how_many", f"asks for {spec.odd.how_many} outliers, but only {places} are possible"
        )
    faulty = sum(vars(spec.practice).values())
    if faulty > pulls:
        raise QuantityError.of(
            "practice",
            f"asks for {faulty} faulty files, but there are {pulls} pulls, and each has "
            "at most one such fault",
        )
    return spec
