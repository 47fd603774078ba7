"""A brake as a functional mock-up unit: FMI 3.0 or 2.0, model exchange and co-simulation in one."""

from __future__ import annotations

import io
import platform
import struct
import sys
import zipfile
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.errors import QuantityError
from layerjam.interop.fmi_variables import parameter_list
from layerjam.interop.fmi_xml import MODEL, Version, build_description, model_description
from layerjam.interop.source import KERNEL, WRAPPERS
from layerjam.kernel.compiler import SOURCES, library
from layerjam.kernel.parameters import brake_of
from layerjam.mechanics.stiffness import working_stiffness


class Platform(NamedTuple):
    """Where a binary runs: its folder in FMI 3 and 2, its file's ending, its compiler's target."""

    folder: str
    folder_2: str | None
    ending: str
    target: str


PLATFORMS: Mapping[str, Platform] = {
    "linux": Platform("x86_64-linux", "linux64", ".so", "x86_64-linux-gnu.2.17"),
    "linux-arm": Platform("aarch64-linux", None, ".so", "aarch64-linux-gnu.2.17"),
    "windows": Platform("x86_64-windows", "win64", ".dll", "x86_64-windows-gnu"),
    "macos": Platform("x86_64-darwin", "darwin64", ".dylib", "x86_64-macos"),
    "macos-arm": Platform("aarch64-darwin", None, ".dylib", "aarch64-macos"),
}
FLAGS = ("-fvisibility=hidden",)
EPOCH = (1980, 1, 1, 0, 0, 0)
UNIT = WRAPPERS / "fmu"
_MAGIC = b"LJBRAKE1"


def own_platform() -> str | None:
    """The name of this machine among PLATFORMS; None if it is another."""
    arm = platform.machine().lower() in ("arm64", "aarch64")
    if sys.platform.startswith("linux"):
        return "linux-arm" if arm else "linux"
    if sys.platform == "darwin":
        return "macos-arm" if arm else "macos"
    return "windows" if sys.platform == "win32" else None


def start_values(given: Brake | BrakeFile, rope_stiffness: float | None = None) -> dict[str, float]:
    """{parameter: value} of a brake; 0 stands for what it does not have.

    Raises QuantityError for sheets that fan out, a speed law or a hyperelastic enclosure.
    """
    brake = brake_of(given)
    made = {one.name: _value(brake, one.name) for one in parameter_list()}
    made["rope.stiffness"] = rope_stiffness or 0.0
    if brake.vacuum_share is None:
        made["vacuum_share"] = 1.0
    if brake.stiffness_measured is None and not float(working_stiffness(brake)) > 0:
        raise QuantityError.of("stiffness_measured", "there is no stiffness to compute with")
    return made


def _value(brake: Brake, path: str) -> float:
    at: object = brake
    for name in path.split("."):
        at = getattr(at, name) if at is not None else None
    return 0.0 if at is None else float(at)  # type: ignore[arg-type]


def chosen_platforms(version: Version, names: Sequence[str] | None) -> tuple[str, ...]:
    """The platforms to build for, this machine's own by default.

    Raises QuantityError for a name that is not known, or not to this version of FMI.
    """
    own = own_platform()
    if names is None:
        names = (own,) if own is not None else ()
    for name in names:
        if name not in PLATFORMS:
            raise QuantityError.of(
                "platforms", f"'{name}' is not known; choose among {', '.join(PLATFORMS)}"
            )
        if version == "2" and PLATFORMS[name].folder_2 is None:
            raise QuantityError.of(
                "platforms", f"FMI 2.0 has no name for '{name}'; take FMI 3, or leave it out"
            )
    if not names:
        raise QuantityError.of(
            "platforms", f"none is given for this machine; choose among {', '.join(PLATFORMS)}"
        )
    return tuple(dict.fromkeys(names))


def binary(version: Version, name: str) -> bytes:
    """The library for a platform, compiled once and kept; CompilerError where it cannot be."""
    at = PLATFORMS[name]
    built = library(
        [UNIT / f"fmi{version}.c", UNIT / "model.c", SOURCES / "layerjam.c"],
        flags=FLAGS,
        includes=[SOURCES, UNIT / "headers"],
        ending=at.ending,
        target=None if name == own_platform() else at.target,
    )
    return built.read_bytes()


def fmu(
    version: Version,
    name: str,
    values: Mapping[str, float],
    binaries: Mapping[str, bytes],
    mark: str = "",
) -> bytes:
    """The archive: description, binaries {platform: library}, start values, and all sources.

    The sources start with this brake too; `mark` is said in the description. The same input gives
    the same bytes.
    """
    sources = (f"fmi{version}.c", "model.c", "layerjam.c")
    files: dict[str, bytes | str] = {
        "modelDescription.xml": model_description(version, name, values, sources, mark),
        "resources/brake.bin": _MAGIC
        + struct.pack(
            f"<I{len(values)}d", len(values), *(values[o.name] for o in parameter_list())
        ),
    }
    for one, library_ in binaries.items():
        at = PLATFORMS[one]
        folder = at.folder if version == "3" else at.folder_2
        files[f"binaries/{folder}/{MODEL}{at.ending}"] = library_
    if version == "3":
        files["sources/buildDescription.xml"] = build_description(sources)
    for kernel in KERNEL:
        files[f"sources/{kernel}"] = (SOURCES / kernel).read_bytes()
    for own in (f"fmi{version}.c", "model.c", "model.h", "variables.h"):
        files[f"sources/{own}"] = (UNIT / own).read_bytes()
    files["sources/values.h"] = _values_header(values)
    for header in sorted((UNIT / "headers").glob(f"fmi{version}*.h")):
        files[f"sources/headers/{header.name}"] = header.read_bytes()
    return _packed(files)


def _values_header(values: Mapping[str, float]) -> str:
    rows = ", \\\n    ".join(repr(float(values[one.name])) for one in parameter_list())
    about = "/* The exported brake, in the order of variables.h. */"
    return f"{about}\n#define LJ_VALUES {{ \\\n    {rows}}}\n"


def _packed(files: Mapping[str, bytes | str]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            about = zipfile.ZipInfo(name, EPOCH)
            about.compress_type = zipfile.ZIP_DEFLATED
            about.create_system = 3
            about.external_attr = 0o644 << 16
            archive.writestr(about, content)
    return out.getvalue()
