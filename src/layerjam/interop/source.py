"""A brake as C source: the kernel's files, and one with the brake's eight numbers."""

from pathlib import Path

from layerjam._version import __version__
from layerjam.brake.kernel.compiler import SOURCES
from layerjam.brake.kernel.kernel import Precision
from layerjam.brake.kernel.parameters import UNITS, Parameters

WRAPPERS = Path(__file__).parent / "c"
"""C code around the kernel: an example, the plugin for MuJoCo, the mock-up unit."""
BRAKE, EXAMPLE = "brake.h", "example.c"
KERNEL = ("layerjam.h", "layerjam.c", "formulas.h")
NAMES = (BRAKE, *KERNEL, EXAMPLE)
"""All files of an export."""
_GUARD = "#define LAYERJAM_H\n"
_SINGLE = "\n/* exported in single precision */\n#ifndef LJ_SINGLE\n#define LJ_SINGLE\n#endif\n"


def c_files(name: str, numbers: Parameters, precision: Precision, mark: str = "") -> dict[str, str]:
    """Return {file: text} of the kernel with a brake called `name`; `mark` follows the name."""
    texts = _read_kernel()
    if precision == "single":
        texts["layerjam.h"] = texts["layerjam.h"].replace(_GUARD, _GUARD + _SINGLE)
    return {BRAKE: brake_header(name, numbers, mark), **texts, EXAMPLE: _read_code(EXAMPLE)}


def plugin_files() -> dict[str, str]:
    """Return {file: text} of the actuator plugin for MuJoCo with its kernel."""
    texts = {"layerjam_mujoco.c": _read_code("mujoco_plugin.c"), "joint.h": _read_code("joint.h")}
    return {**texts, **_read_kernel()}


def _read_kernel() -> dict[str, str]:
    return {file: (SOURCES / file).read_text(encoding="utf-8") for file in KERNEL}


def _read_code(name: str) -> str:
    return (WRAPPERS / name).read_text(encoding="utf-8")


def brake_header(name: str, numbers: Parameters, mark: str = "") -> str:
    """Return the numbers of a brake as a constant for C and C++."""
    plain, note = (
        "".join(c if c.isprintable() else "?" for c in text).replace("*/", "* /")
        for text in (name, mark)
    )
    note = note and f" * {note}.\n"
    rows = (
        f"    (lj_real){value!r}, /* {key} [{UNITS[key]}] */\n"
        for key, value in numbers._asdict().items()
    )
    return f"""/* The brake {plain}, written by layerjam {__version__}. SI units.
{note} *
 * At rest it resists contact * vacuum * overlap: the greater static friction is not in it.
 */
#ifndef LAYERJAM_BRAKE_H
#define LAYERJAM_BRAKE_H

#include "layerjam.h"

static const lj_brake brake = {{
{"".join(rows)}}};

#endif
"""
