"""Metadata that a measurement file does not contain, in NAME.csv.toml next to NAME.csv."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from layerjam.brake.simulate.quantities import AREA, CROSSHEAD_SPEED, NORMAL_FORCE, SEED, VACUUM
from layerjam.core.store import store_file
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.toml import parse_toml, read_text
from layerjam.core.toml_files.values import TextSpec, entries, value
from layerjam.core.toml_files.writer import plain_lines
from layerjam.core.units import FlagSpec, build, like, quantity
from layerjam.laboratory.measure.certificate import Certificate, CertificateSpec

SIDECAR_ENDING = ".toml"
FOLDER = "conditions.toml"
"""File of metadata for all files in its folder, with the same keys."""
READ = "read"
"""Table of a sidecar with reading options; see `measure.options`."""


def _text_field(text: str) -> str:
    """Return the field of a text that the report prints as "not stated" if empty."""
    field: str = value(TextSpec(text=text), default="")
    return field


def _certificate_field(instrument: str) -> Any:
    spec = CertificateSpec(text=f"calibration certificate of the {instrument}")
    return value(spec, default=None, table=True)


def _limit_field(quantity_name: str) -> Any:
    return quantity("1", f"relative error limit of the {quantity_name}", hi=0.2, default=None)


@dataclass(frozen=True, kw_only=True)
class Facts:
    """Conditions of one test; None (or empty) if not stated.

    The fields from `number` onwards are for a signed report (ASTM D1894, section 12; ISO/IEC 17025,
    section 7.8.2).
    """

    vacuum: float | None = like(VACUUM, "vacuum in the brake during the test", default=None)
    speed: float | None = like(CROSSHEAD_SPEED, default=None)
    repeat: int | None = quantity("1", "repeat number", whole=True, default=None)
    mounting: int | None = quantity(
        "1",
        "number of the mounting in which the brake was pulled; default: the repeat number",
        whole=True,
        default=None,
    )
    brake: str | None = value(TextSpec(text="name of the brake"), default=None)
    normal_force: float | None = like(NORMAL_FORCE, "normal force of a friction test", default=None)
    hold: float | None = quantity(
        "s", "time under load before the pull of a friction test", lo=1e-3, hi=1e8, default=None
    )
    procedure: str | None = value(TextSpec(text="test procedure, as free text"), default=None)
    synthetic: bool = value(FlagSpec(text="the numbers were computed, not measured"), default=False)
    seed: int | None = like(SEED, "seed of a synthetic file", default=None)
    note: str = value(TextSpec(text="anything else"), default="")
    number: str = _text_field("number of the test or of its report")
    customer: str = _text_field("customer of the test, with its address")
    date: str = _text_field("date of the test")
    operator: str = _text_field("operator")
    laboratory: str = _text_field("laboratory, with its address")
    machine: str = _text_field("test machine, with its serial number")
    apparatus: str = _text_field("sled and table, or grips and fixture")
    load_cell: str = _text_field("load cell, with its serial number")
    load_cell_limit: float | None = _limit_field("load cell")
    load_cell_certificate: Certificate | None = _certificate_field("load cell")
    gauge: str = _text_field("vacuum gauge, with its serial number")
    gauge_limit: float | None = quantity(
        "Pa", "error limit of the vacuum gauge", hi=5e4, default=None
    )
    gauge_certificate: Certificate | None = _certificate_field("vacuum gauge")
    normal_force_limit: float | None = _limit_field("normal force of a friction test")
    normal_force_certificate: Certificate | None = _certificate_field(
        "normal force of a friction test"
    )
    area: float | None = like(AREA, "area under the sled of a friction test", default=None)
    area_limit: float | None = _limit_field("area under the sled")
    film_maker: str = _text_field("manufacturer and product name of the film")
    film_lot: str = _text_field("lot of the film")
    film_direction: str = _text_field("roll direction of the film in the test")
    conditioning: str = _text_field(
        "conditioning of the specimens: duration, temperature and humidity"
    )
    climate: str = _text_field("temperature and humidity during the test")

    @property
    def instrument_limits(self) -> dict[str, float | None]:
        """Error limits of the load cell (relative) and the gauge [Pa]; None if unknown."""
        return {"load_cell": self.load_cell_limit, "gauge": self.gauge_limit}

    @property
    def mounting_number(self) -> int | None:
        """Number of the mounting; None if unknown."""
        return self.repeat if self.mounting is None else self.mounting


_FIELDS = dict(entries(Facts))


def sidecar_path(path: str | Path) -> Path:
    """Return the path of a data file's sidecar: the same name followed by .toml."""
    path = Path(path)
    return path.parent / (path.name + SIDECAR_ENDING)  # a name may be empty: '', '.', '/'


def read_facts(path: str | Path) -> Facts:
    """Return the metadata of the data file `path`; all are unknown if there is no sidecar.

    Metadata of all files in a folder are in its conditions.toml; a file's own sidecar has priority.
    Raises FileError, with file and line, for invalid TOML, an unknown key or an invalid value.
    """
    of_all, of_file = (_read_toml_file(place) for place in list_fact_files(path))
    return build(Facts, {**of_all, **of_file})


def list_fact_files(path: str | Path) -> tuple[Path, Path]:
    """Return the paths of a data file's metadata: the folder's, and its own (with priority)."""
    return Path(path).parent / FOLDER, sidecar_path(path)


def _read_toml_file(place: Path) -> dict[str, Any]:
    return parse_facts(read_text_or_empty(place), place)


def parse_facts(text: str, place: str | Path) -> dict[str, Any]:
    """Return {key: SI value} from a sidecar's text; a FileError names the file and the line."""
    reader = Reader(text, place, _FIELDS, words={})
    reader.read_all({k: v for k, v in parse_toml(text, place).items() if k != READ})
    return reader.values


def read_text_or_empty(place: Path) -> str:
    """Return the text of a metadata file, empty if there is none."""
    try:
        exists = place.exists()
    except (OSError, ValueError):  # a name that is too long or contains a NUL cannot have a sidecar
        exists = False
    return read_text(place) if exists else ""


def format_facts(facts: Facts) -> str:
    """Return the TOML text of a sidecar, from which `read_facts` returns the same metadata."""
    lines = ["# Metadata that the data file next to this one does not contain."]
    return "\n".join([*lines, *plain_lines(_FIELDS, vars(facts)), ""])


def write_facts(path: str | Path, facts: Facts, overwrite: bool = False) -> Path:
    """Write the sidecar of the data file `path`; FileError if one exists, unless `overwrite`."""
    return store_file(sidecar_path(path), format_facts(facts), overwrite)
