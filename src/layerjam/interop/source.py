"""A brake as C source: the kernel's files, and one with the brake's eight numbers."""

from __future__ import annotations

from pathlib import Path

from layerjam._version import __version__
from layerjam.kernel.compiler import SOURCES
from layerjam.kernel.kernel import Precision
from layerjam.kernel.parameters import UNITS, Parameters

WRAPPERS = Path(__file__).parent / "c"
"""C that stands around the kernel: an example, the plugin for MuJoCo, the mock-up unit."""
BRAKE, EXAMPLE = "brake.h", "example.c"
KERNEL = ("layerjam.h", "layerjam.c", "formulas.h")
NAMES = (BRAKE, *KERNEL, EXAMPLE)
"""All files of an export."""
_GUARD = "#define LAYERJAM_H\n"
_SINGLE = "\n/* exported in single precision */\n#ifndef LJ_SINGLE\n#define LJ_SINGLE\n#endif\n"


def c_files(name: str, of: Parameters, precision: Precision, mark: str = "") -> dict[str, str]:
    """{file: text} of the kernel with a brake called `name`; `mark` is said beside the name."""
    made = _kernel()
    if precision == "single":
        made["layerjam.h"] = made["layerjam.h"].replace(_GUARD, _GUARD + _SINGLE)
    return {BRAKE: brake_header(name, of, mark), **made, EXAMPLE: _wrapper(EXAMPLE)}


def plugin_files() -> dict[str, str]:
    """{file: text} of the actuator plugin for MuJoCo with the kernel that it wraps."""
    return {"layerjam_mujoco.c": _wrapper("mujoco_plugin.c"), **_kernel()}


def _kernel() -> dict[str, str]:
    return {one: (SOURCES / one).read_text(encoding="utf-8") for one in KERNEL}


def _wrapper(name: str) -> str:
    return (WRAPPERS / name).read_text(encoding="utf-8")


def brake_header(name: str, of: Parameters, mark: str = "") -> str:
    """The numbers of a brake as a constant for C and C++."""
    plain, said = (
        "".join(c if c.isprintable() else "?" for c in text).replace("*/", "* /")
        for text in (name, mark)
    )
    said = said and f" * {said}.\n"
    rows = (
        f"    (lj_real){value!r}, /* {key} [{UNITS[key]}] */\n"
        for key, value in of._asdict().items()
    )
    return f"""/* The brake {plain}, written by layerjam {__version__}. SI units.
{said} *
 * It holds contact * vacuum * overlap when at rest: the greater static friction is not in it.
 */
#ifndef LAYERJAM_BRAKE_H
#define LAYERJAM_BRAKE_H

#include "layerjam.h"

static const lj_brake brake = {{
{"".join(rows)}}};

#endif
"""
