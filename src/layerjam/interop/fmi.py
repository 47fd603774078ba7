"""A brake as a functional mock-up unit: FMI 3.0 or 2.0, model exchange and co-simulation."""

import io
import platform
import struct
import sys
import zipfile
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.kernel.compiler import SOURCES, TARGETS, build_library
from layerjam.brake.kernel.parameters import check_exportable
from layerjam.brake.mechanics.effects import list_effects, pressure_on_sheets
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.core.errors import QuantityError
from layerjam.interop.fmi_variables import list_parameters
from layerjam.interop.fmi_xml import MODEL, Version, build_description, model_description
from layerjam.interop.source import KERNEL, WRAPPERS


class Platform(NamedTuple):
    """Platform of a binary: its folder in FMI 3 and 2, file ending, and compiler target."""

    folder: str
    folder_2: str | None
    ending: str
    target: str


PLATFORMS: Mapping[str, Platform] = {
    "linux": Platform("x86_64-linux", "linux64", ".so", TARGETS["linux", "x86_64"]),
    "linux-arm": Platform("aarch64-linux", None, ".so", TARGETS["linux", "aarch64"]),
    "windows": Platform("x86_64-windows", "win64", ".dll", TARGETS["win32", "AMD64"]),
    "macos": Platform("x86_64-darwin", "darwin64", ".dylib", TARGETS["darwin", "x86_64"]),
    "macos-arm": Platform("aarch64-darwin", None, ".dylib", TARGETS["darwin", "arm64"]),
}
FLAGS = ("-fvisibility=hidden",)
EPOCH = (1980, 1, 1, 0, 0, 0)
UNIT = WRAPPERS / "fmu"
_MAGIC = b"LJBRAKE1"


def find_platform() -> str | None:
    """Return this machine's key in PLATFORMS, or None."""
    arm = platform.machine().lower() in ("arm64", "aarch64")
    if sys.platform.startswith("linux"):
        return "linux-arm" if arm else "linux"
    if sys.platform == "darwin":
        return "macos-arm" if arm else "macos"
    return "windows" if sys.platform == "win32" else None


def brake_values(brake: Brake | BrakeFile, rope_stiffness: float | None = None) -> dict[str, float]:
    """Return {parameter: value} of a brake; 0 for a value that it does not have.

    Raises QuantityError for sheets that fan out, a speed law or a hyperelastic enclosure.
    """
    brake = check_exportable(brake)
    for effect in list_effects(brake):
        if not effect.in_fmu:
            raise effect.refuse("an FMU")
    values = {p.name: _read_value(brake, p.name) for p in list_parameters()}
    values["rope.stiffness"] = rope_stiffness or 0.0
    values["vacuum_share"] = float(pressure_on_sheets(1.0, brake))
    if brake.stiffness_measured is None and not float(working_stiffness(brake)) > 0:
        raise QuantityError.of("stiffness_measured", "is neither measured nor computable")
    return values


def _read_value(brake: Brake, path: str) -> float:
    node: object = brake
    for name in path.split("."):
        node = getattr(node, name) if node is not None else None
    return 0.0 if node is None else float(node)  # type: ignore[arg-type]


def choose_platforms(version: Version, names: Sequence[str] | None) -> tuple[str, ...]:
    """Return the platforms to build for, by default that of this machine.

    Raises QuantityError for an unknown name, or one that this version of FMI lacks.
    """
    own_name = find_platform()
    if names is None:
        names = (own_name,) if own_name is not None else ()
    for name in names:
        if name not in PLATFORMS:
            raise QuantityError.of(
                "platforms", f"'{name}' is unknown; choose from {', '.join(PLATFORMS)}"
            )
        if version == "2" and PLATFORMS[name].folder_2 is None:
            raise QuantityError.of(
                "platforms", f"FMI 2.0 has no name for '{name}'; use FMI 3, or omit it"
            )
    if not names:
        raise QuantityError.of(
            "platforms", f"none matches this machine; choose from {', '.join(PLATFORMS)}"
        )
    return tuple(dict.fromkeys(names))


def build_binary(version: Version, name: str) -> bytes:
    """Return the library for a platform, from the cache or compiled; raises CompilerError."""
    target = PLATFORMS[name]
    path = build_library(
        [UNIT / f"fmi{version}.c", UNIT / "model.c", SOURCES / "layerjam.c"],
        flags=FLAGS,
        includes=[SOURCES, UNIT / "headers"],
        ending=target.ending,
        target=None if name == find_platform() else target.target,
    )
    return path.read_bytes()


def build_fmu(
    version: Version,
    name: str,
    values: Mapping[str, float],
    binaries: Mapping[str, bytes],
    mark: str = "",
) -> bytes:
    """Return the FMU archive: description, `binaries` {platform: library}, start values, sources.

    The sources also contain the brake's start values; `mark` is part of the description. The same
    input produces the same bytes.
    """
    sources = (f"fmi{version}.c", "model.c", "layerjam.c")
    numbers = [values[parameter.name] for parameter in list_parameters()]
    files: dict[str, bytes | str] = {
        "modelDescription.xml": model_description(version, name, values, sources, mark),
        "resources/brake.bin": _MAGIC + struct.pack(f"<I{len(values)}d", len(values), *numbers),
    }
    for platform_name, library_ in binaries.items():
        target = PLATFORMS[platform_name]
        folder = target.folder if version == "3" else target.folder_2
        files[f"binaries/{folder}/{MODEL}{target.ending}"] = library_
    if version == "3":
        files["sources/buildDescription.xml"] = build_description(sources)
    for kernel in KERNEL:
        files[f"sources/{kernel}"] = (SOURCES / kernel).read_bytes()
    for source in (f"fmi{version}.c", "model.c", "model.h", "variables.h"):
        files[f"sources/{source}"] = (UNIT / source).read_bytes()
    rows = ", \\\n    ".join(repr(float(number)) for number in numbers)
    comment = "/* The exported brake, in the order of variables.h. */"
    files["sources/values.h"] = f"{comment}\n#define LJ_VALUES {{ \\\n    {rows}}}\n"
    for header in sorted((UNIT / "headers").glob(f"fmi{version}*.h")):
        files[f"sources/headers/{header.name}"] = header.read_bytes()
    return _zip_files(files)


def _zip_files(files: Mapping[str, bytes | str]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
    return out.getvalue()
