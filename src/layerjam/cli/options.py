"""Options that several commands share, and how their text becomes SI."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.device.load import load
from layerjam.device.mount import Site
from layerjam.errors import FileError, QuantityError
from layerjam.units import Meaning, meaning_of, show

BrakeName = Annotated[
    str, typer.Argument(metavar="BRAKE", help="Catalogue name or path of a brake's TOML file.")
]
Files = Annotated[
    list[Path], typer.Argument(metavar="FILE...", help="Exports of a test machine.")
]
Atmosphere = Annotated[
    str | None, typer.Option(metavar="Q", help="Atmosphere of the site, e.g. 95kPa.")
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object in SI units, nothing else.")]
Figure = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Draw it: .svg, .png or .pdf.")
]
Force = Annotated[
    bool, typer.Option("--force", "--replace", help="Replace files that exist.")
]
Replace = Annotated[bool, typer.Option("--replace", help="Replace a figure that exists.")]
Vacuum = Annotated[str, typer.Option(metavar="Q", help="Vacuum, e.g. 94.5kPa.")]
Slip = Annotated[str, typer.Option(metavar="Q", help="Slip of the sheets, e.g. 20mm.")]

VACUUM = Meaning("Pa", "vacuum")
SLIP = Meaning("m", "slip")
FORCE = Meaning("N", "force")
NORMAL_FORCE = Meaning("N", "normal force", open_lo=True)
SPEED = Meaning("m/s", "crosshead speed", open_lo=True, hi=100)
TRAVEL = Meaning("m", "travel of the crosshead", open_lo=True, hi=10)


def engine() -> None:
    """Switch JAX to double precision, with compiled code kept in the user's cache folder.

    Called by every command that computes, and only then: importing JAX takes half a second.
    """
    import os

    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    import jax
    import platformdirs

    jax.config.update("jax_enable_x64", True)
    cache = Path(platformdirs.user_cache_dir("layerjam")) / "compiled"
    try:
        cache.mkdir(parents=True, exist_ok=True)
        writable = os.access(cache, os.W_OK)
    except OSError:
        writable = False
    if writable:
        jax.config.update("jax_compilation_cache_dir", str(cache))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)


def brake_at(name: str, atmosphere: str | None) -> BrakeFile:
    """The brake, at the site's atmosphere if one is given."""
    file = load(name)
    if atmosphere is None:
        return file
    pressure = meaning_of(Site, "atmosphere").read(atmosphere, "--atmosphere")
    site = replace(file.brake.site, atmosphere=pressure)
    return replace(file, brake=replace(file.brake, site=site))


def read_vacuum(text: str, brake: Brake, name: str = "--vacuum") -> float:
    """A vacuum that the site allows."""
    value = VACUUM.read(text, name)
    if value > brake.site.atmosphere:
        raise QuantityError(
            f"{name}: {show(value, 'Pa', 6)} is more than the atmosphere, "
            f"{show(brake.site.atmosphere, 'Pa', 6)}; a vacuum is at most that"
        )
    return value


def read_slip(text: str, brake: Brake) -> tuple[float, list[str]]:
    """A slip within the overlap, and what to say of one beyond the usable travel."""
    value, sheets = SLIP.read(text, "--slip"), brake.sheets
    if value > sheets.overlap:
        raise QuantityError(
            f"--slip: {show(value, 'm')} is beyond the overlap of {show(sheets.overlap, 'm')}; "
            "the sheets would have separated"
        )
    if value > sheets.usable_travel:
        return value, [
            f"slip {show(value, 'm')} is beyond the usable travel of "
            f"{show(sheets.usable_travel, 'm')}"
        ]
    return value, []


def check_figure(path: Path | None, force: bool) -> None:
    """Refuse a figure that could not be written, before anything is computed."""
    if path is None:
        return
    if path.suffix.lower() not in (".svg", ".png", ".pdf"):
        raise FileError(path, f"the ending '{path.suffix}' is not known; use .svg, .png or .pdf")
    check_target(path, force)


def check_target(path: Path | None, force: bool) -> None:
    """Refuse an output file that exists, unless --force."""
    if path is None:
        return
    if path.exists() and not force:
        raise FileError(path, "exists already; --force replaces it")
    if not path.parent.is_dir():
        raise FileError(path, f"cannot be written: there is no folder {path.parent}")
