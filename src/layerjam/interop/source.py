"""A brake as C source: the kernel's files, and one with the brake's eight numbers."""

from __future__ import annotations

from layerjam._version import __version__
from layerjam.interop.compiler import SOURCES
from layerjam.interop.kernel import Precision
from layerjam.interop.parameters import UNITS, Parameters

BRAKE = "brake.h"
FILES = ("layerjam.h", "layerjam.c", "formulas.h", "example.c")
NAMES = (BRAKE, *FILES)
"""All files of an export."""
_GUARD = "#define LAYERJAM_H\n"
_SINGLE = "\n/* exported in single precision */\n#ifndef LJ_SINGLE\n#define LJ_SINGLE\n#endif\n"


def c_files(name: str, of: Parameters, precision: Precision) -> dict[str, str]:
    """{file: text} of the kernel with a brake called `name`."""
    made = {one: (SOURCES / one).read_text(encoding="utf-8") for one in FILES}
    if precision == "single":
        made["layerjam.h"] = made["layerjam.h"].replace(_GUARD, _GUARD + _SINGLE)
    return {BRAKE: brake_header(name, of), **made}


def plugin_files() -> dict[str, str]:
    """{file: text} of the actuator plugin for MuJoCo with the kernel that it wraps."""
    kernel = ("layerjam.h", "layerjam.c", "formulas.h")
    made = {one: (SOURCES / one).read_text(encoding="utf-8") for one in kernel}
    return {"layerjam_mujoco.c": (SOURCES / "mujoco_plugin.c").read_text(encoding="utf-8"), **made}


def brake_header(name: str, of: Parameters) -> str:
    """The numbers of a brake as a constant for C and C++."""
    plain = "".join(c if c.isprintable() else "?" for c in name).replace("*/", "* /")
    rows = (
        f"    (lj_real){value!r}, /* {key} [{UNITS[key]}] */\n"
        for key, value in of._asdict().items()
    )
    return f"""/* The brake {plain}, written by layerjam {__version__}. SI units.
 *
 * It holds contact * vacuum * overlap when at rest: the greater static friction is not in it.
 */
#ifndef LAYERJAM_BRAKE_H
#define LAYERJAM_BRAKE_H

#include "layerjam.h"

static const lj_brake brake = {{
{"".join(rows)}}};

#endif
"""
