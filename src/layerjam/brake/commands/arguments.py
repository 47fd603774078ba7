"""Quantities and arguments that commands share, each with one definition and its checks."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.device.mount import Rope, Site
from layerjam.brake.simulate.quantities import (
    ARRIVAL_SPEED,
    CONFIDENCE,
    CROSSHEAD_SPEED,
    DURATION,
    ELONGATION,
    FORCE,
    HELD,
    LEAK_TIME,
    MASS,
    SEED,
    SLIP,
    STOP_TRAVEL,
    VACUUM,
)
from layerjam.core.command.declare import ARRAY, Help, Input, OutFile, list_record_parameters
from layerjam.core.errors import Notice, QuantityError, UnknownNameError
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.changes import RecordFile
from layerjam.core.toml_files.source import Source
from layerjam.core.units import QuantitySpec, exact_text, get_spec, show
from layerjam.core.verdict import read_acceptances

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from layerjam.brake.fluid.line import Line

    Array = NDArray[np.float64]
else:
    Array = Sequence[float]  # the help must be displayed without loading NumPy

T = TypeVar("T")
F = TypeVar("F", bound=RecordFile[Any])
AnyBrake = str | Path | BrakeFile | Brake

ATMOSPHERE = evolve(get_spec(Site, "atmosphere"), example="95kPa")
TARGET = evolve(VACUUM, text="target vacuum", symbol="", open_lo=True)
HEIGHT = QuantitySpec("m", "fall height", open_lo=True, hi=1e5, example="30cm")
ROPE_STIFFNESS = evolve(
    get_spec(Rope, "stiffness"), text="stiffness of the rope", example="16.8kN/m"
)
ROPE_DAMPING = evolve(get_spec(Rope, "damping"), example="'20 N s/m'")
SHARE = evolve(get_spec(Brake, "vacuum_share"), example="80%")
LOG_TIME = QuantitySpec("s", "time in the log", lo=-1e9, hi=1e9, example="2s")

Atmosphere = Annotated[float | None, ATMOSPHERE, Help("Atmospheric pressure at the site.")]
Vacuum = Annotated[float, VACUUM]
Target = Annotated[float, TARGET]
Vacuums = Annotated[float | Array, VACUUM, ARRAY]
Slips = Annotated[float | Array, SLIP, ARRAY]
Slip = Annotated[float, SLIP]
Force = Annotated[float, FORCE]
Forces = Annotated[float | Array, FORCE, ARRAY]
Mass = Annotated[float, MASS]
ArrivalSpeed = Annotated[float, ARRIVAL_SPEED]
Height = Annotated[float, HEIGHT]
StopTravel = Annotated[float, STOP_TRAVEL]
CrossheadSpeed = Annotated[float, CROSSHEAD_SPEED]
Elongation = Annotated[float, ELONGATION]
PullElongation = Annotated[float, ELONGATION, Help("", old=("--travel",))]
RopeStiffness = Annotated[float, ROPE_STIFFNESS]
RopeDamping = Annotated[float, ROPE_DAMPING]
Duration = Annotated[float, DURATION]
Seed = Annotated[int, SEED]
VacuumShare = Annotated[
    float, SHARE, Help("Fraction of the vacuum that presses the sheets. Default: all of it.")
]
LeakTime = Annotated[float, LEAK_TIME, Help("Time constant of the leak, as printed by `leak`.")]
HoldTime = Annotated[
    float, HELD, Help("With a leak: time from shutting off the line until the rope is taut.")
]
Confidence = Annotated[float, CONFIDENCE]
Interval = Annotated[
    Literal["next", "mean"],
    Help("95 % intervals for the next test, or for the mean of many."),
]
TunedKeyword = Literal["tuned"]
Horizontal = Annotated[bool, Help("Ignore gravity along the pull.")]
Overwrite = Annotated[bool, Help("Replace existing files.", old=("--force", "--replace"))]
OutBrake = Annotated[
    str | Path, OutFile("Brake file to write.", metavar="FILE.toml", endings=(".toml",))
]


def _read_reason(
    value: Sequence[str] | Mapping[str, str], _arguments: Mapping[str, Any]
) -> Mapping[str, str]:
    return read_acceptances(value)


Accept = Annotated[
    Mapping[str, str] | None,
    Input(
        "Accept this failed check, with the reason.", metavar="CHECK=REASON", convert=_read_reason
    ),
]
"""`--accept CHECK="reason"`, repeatable; the function receives {check: reason}."""
Tare = Annotated[bool, Help("Subtract the force before the load rise.")]


def convert_brake(brake: AnyBrake, atmosphere: float | str | None = None) -> BrakeFile:
    """Return the brake with its name and sources, at the given atmosphere, if any.

    A record created in Python is checked like a file. Raises UnknownNameError, FileError or
    QuantityError.
    """
    return load_record_file(brake, BrakeFile, load, atmosphere)


def load_record_file(
    source: Any,
    kind: type[F],
    read: Callable[[str | Path], F],
    atmosphere: float | str | None,
) -> F:
    """Return the validated file of a brake or line, given a name, a path, a file or a record."""
    if isinstance(source, str | Path):
        file = read(source)
    elif isinstance(source, kind):
        kind.check(source.record)
        file = source
    elif isinstance(source, kind.kind):
        kind.check(source)
        file = kind.from_record(source)
    else:
        raise QuantityError(
            f"{kind.holds}: {type(source).__name__} is not a {kind.holds}; give a catalogue "
            f"name, the path of its file, or the result of layerjam.{read.__name__}"
        )
    if atmosphere is None:
        return file
    pressure = ATMOSPHERE.si(atmosphere, "atmosphere")
    site = evolve(file.record.site, atmosphere=pressure)
    record = evolve(file.record, site=site)
    kind.check(record)
    sources = {"site.atmosphere": Source(kind="unstated", text="given with the command")}
    content: dict[str, Any] = {kind.holds: record, "sources": {**file.sources, **sources}}
    return evolve(file, **content)


EXPORTS = (".csv", ".txt", ".tra", ".tsv", ".dat", ".xls", ".xlsx", ".ods")
"""File extensions of measurement files."""


def _read_brake(value: AnyBrake, arguments: Mapping[str, Any]) -> BrakeFile:
    if isinstance(value, str | Path) and Path(value).suffix.lower() in EXPORTS:
        raise QuantityError.of(
            "brake", f"{value} is a measurement; name the brake first, then the files"
        )
    file = convert_brake(value, arguments.get("atmosphere"))
    film = arguments.get("film")
    if film is None:
        return file
    from layerjam.brake.commands.film import replace_film

    return replace_film(file, str(film))


OtherFilm = Annotated[
    str | None,
    Help("Film for this call: one of the catalogue, or that of a brake.", metavar="FILM"),
]
BrakeInput = Annotated[
    BrakeFile,
    Input("Catalogue name or path of a brake's TOML file.", metavar="BRAKE", convert=_read_brake),
]

TargetBrake = Annotated[
    BrakeFile, Input("Brake to write the result into.", metavar="BRAKE", convert=_read_brake)
]


def apply_share(file: BrakeFile, share: Any) -> BrakeFile:
    """Return the file with the command's value of the vacuum share, if given."""
    if share is None:
        return file
    sources = {"vacuum_share": Source(kind="unstated", text="given with the command")}
    brake = evolve(file.brake, vacuum_share=share)
    return evolve(file, brake=brake, sources={**file.sources, **sources})


def list_rope_notices(file: BrakeFile, stiffness: float | None) -> list[Notice]:
    """Return a notice if the file states a rope and a stop has none.

    A rope belongs to a test, so a stop includes one only if its `stiffness` [N/m] is given.
    """
    rope = file.brake.rope
    if rope is None or stiffness is not None:
        return []
    value = exact_text(float(rope.stiffness), "N/m").replace(" ", "")
    sentence = (
        "the stop has no rope, because the [rope] of the brake file belongs to a test; to include "
        f"it, give --rope-stiffness {value}"
    )
    return [Notice(sentence, "rope-not-used")]


def parse_options(cls: type[T], values: Mapping[str, Any]) -> T:
    """Return a checked record of `options`, for other functions, from text or SI numbers."""
    by_name = {p.name: p for p in list_record_parameters(cls)}
    unknown = [name for name in values if name not in by_name]
    if unknown:
        raise UnknownNameError(f"field of {cls.__name__}", unknown[0], by_name)
    notices: list[Notice] = []
    return cls(**{n: p.read(values.get(n, p.default), values, notices) for n, p in by_name.items()})


def check_vacuum(value: Any, device: "Brake | Line", name: str = "vacuum") -> Any:
    """Return a vacuum [Pa], number or array; raises QuantityError above the site's atmosphere."""
    import numpy as np

    highest_vacuum = float(np.max(value)) if np.size(value) else 0.0
    if highest_vacuum > device.site.atmosphere:
        raise QuantityError(
            f"{name}: {show(highest_vacuum, 'Pa', 6)} exceeds atmospheric pressure, "
            f"{show(device.site.atmosphere, 'Pa', 6)}; a vacuum cannot be higher"
        )
    return value


def slip_notices(value: Any, brake: Brake) -> list[Notice]:
    """Return notices about a slip [m] (number or array) beyond the usable travel.

    Raises QuantityError for a slip beyond the overlap.
    """
    import numpy as np

    largest_slip, sheets = float(np.max(value)) if np.size(value) else 0.0, brake.sheets
    if largest_slip > sheets.overlap:
        raise QuantityError.of(
            "slip",
            f"{show(largest_slip, 'm')} is beyond the overlap of {show(sheets.overlap, 'm')}; "
            "the sheets would have separated",
        )
    if largest_slip > sheets.usable_travel:
        return [
            Notice(
                f"slip {show(largest_slip, 'm')} is beyond the usable travel of "
                f"{show(sheets.usable_travel, 'm')}",
                "beyond-usable-travel",
            )
        ]
    return []
