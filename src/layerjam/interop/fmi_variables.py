"""The variables of a functional mock-up unit, as one list for its XML and its C code.

`python -m layerjam.interop.fmi_variables` rewrites `c/fmu/variables.h`; a test checks that file.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from layerjam.brake.device.brake import Brake
from layerjam.core.units import quantities

FILE = Path(__file__).parent / "c" / "fmu" / "variables.h"
Role = Literal["independent", "input", "output", "flag", "local", "parameter"]
TIME, FIRST_INPUT, FIRST_OUTPUT, FIRST_FLAG, TURNING, FIRST_PARAMETER = 0, 1, 10, 20, 30, 100
"""Value references, spaced so that later additions do not change the existing ones."""


@dataclass(frozen=True)
class Variable:
    """One variable as an importer sees it."""

    reference: int
    name: str
    role: Role
    unit: str
    text: str
    least: float | None = None
    most: float | None = None
    whole: bool = False
    optional: bool = False
    """Whether zero means "not measured" or "none"."""

    @property
    def symbol(self) -> str:
        """Name in C."""
        return "LJ_" + self.name.upper().replace(".", "_")


_PARAMETERS = (
    "sheets.count",
    "sheets.width",
    "sheets.thickness",
    "sheets.overlap",
    "sheets.free_left",
    "sheets.free_right",
    "film.modulus",
    "film.kinetic",
    "film.friction_on_silicone",
    "enclosure.wall",
    "enclosure.modulus",
    "scale_factor",
    "stiffness_measured",
    "pressure_exponent",
    "test_pressure",
    "vacuum_share",
    "rope.stiffness",
)
"""Values of a brake file that the law needs, named as in that file."""
_OPTIONAL = {"stiffness_measured", "pressure_exponent", "test_pressure", "rope.stiffness"}
_INPUTS = (
    ("elongation", "m", "elongation of brake and rope together"),
    ("velocity", "m/s", "elongation rate; extrapolates the elongation within a co-simulation step"),
    ("vacuum", "Pa", "difference from atmospheric pressure, zero or more"),
)
_OUTPUTS = (
    ("force", "N", "pull of the brake, never negative"),
    ("slip", "m", "slip of the sheets"),
    ("stiffness", "N/m", "slope of force versus elongation, for continued motion"),
    ("work", "J", "external work done on the brake so far"),
    ("heat", "J", "energy dissipated so far"),
    ("stored", "J", "stored elastic energy"),
)
_SNAPPED = "it slid although its friction fell more steeply than its stiffness; the force may jump"
_FLAGS = (
    ("slack", "", "the brake is longer than the elongation and carries no force"),
    ("separated", "", "the overlap was used up; only the enclosure pulls"),
    ("closed", "", "the enclosure has pulled the brake back"),
    ("snapped", "", _SNAPPED),
    ("forgotten", "", "more nested reversals than can be stored; the last ones are ignored"),
)
_GROUPS: tuple[tuple[int, Role, tuple[tuple[str, str, str], ...]], ...] = (
    (TIME, "independent", (("time", "s", "simulated time"),)),
    (FIRST_INPUT, "input", _INPUTS),
    (FIRST_OUTPUT, "output", _OUTPUTS),
    (FIRST_FLAG, "flag", _FLAGS),
    (TURNING, "local", (("turning", "m/s", "the velocity; its zeros mark reversals"),)),
)
"""First value reference, role and (name, unit, text) of all variables but the parameters."""


def list_parameters() -> tuple[Variable, ...]:
    """Return the parameters, with the bounds of a brake file."""
    specs, result = {path: spec for path, spec, _ in quantities(Brake)}, []
    for number, path in enumerate(_PARAMETERS, FIRST_PARAMETER):
        spec, is_optional = specs[path], path in _OPTIONAL
        text = spec.text + "; 0: none" * is_optional
        bounds = spec.lo, spec.hi, spec.whole, is_optional
        result.append(Variable(number, path, "parameter", spec.unit, text, *bounds))
    return tuple(result)


def list_variables() -> tuple[Variable, ...]:
    """Return all variables in the order of their value references."""
    result = [
        Variable(first + i, name, role, unit, text)
        for first, role, rows in _GROUPS
        for i, (name, unit, text) in enumerate(rows)
    ]
    return (*result, *list_parameters())


def make_token() -> str:
    """Return the token that links a description to a binary; it is the same for every brake."""
    digest = hashlib.sha256(repr(list_variables()).encode()).hexdigest()
    return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"


def format_header() -> str:
    """Return the list of variables as a C header."""
    references = "".join(
        f"#define {v.symbol} {v.reference}u\n"
        for v in list_variables()
        if v.role not in ("parameter", "flag")
    )
    places = "".join(f"#define {v.symbol} {i}\n" for i, v in enumerate(list_parameters()))
    names = "".join(
        f'    [{v.reference}] = "{v.name}",\n' for v in list_variables() if v.role != "parameter"
    )
    rows = "".join(
        f'    {{"{v.name}", {v.least!r}, {v.most!r}, {int(v.whole)}, {int(v.optional)}}},\n'
        for v in list_parameters()
    )
    return f"""/* Printed by layerjam/interop/fmi_variables.py. Apache License 2.0. */

#define LJ_TOKEN "{make_token()}"

/* value references */
{references}#define LJ_FIRST_INPUT {FIRST_INPUT}u
#define LJ_INPUTS {len(_INPUTS)}
#define LJ_FIRST_OUTPUT {FIRST_OUTPUT}u
#define LJ_OUTPUTS {len(_OUTPUTS)}
#define LJ_FIRST_FLAG {FIRST_FLAG}u
#define LJ_FLAGS {len(_FLAGS)}
#define LJ_FIRST_PARAMETER {FIRST_PARAMETER}u
#define LJ_PARAMETERS {len(_PARAMETERS)}

/* places among the parameters */
{places}
static const char *const lj_names[LJ_FIRST_PARAMETER] = {{
{names}}};

typedef struct {{
    const char *name;
    double least, most;
    int whole, optional;
}} lj_variable;

static const lj_variable lj_parameters[LJ_PARAMETERS] = {{
{rows}}};
"""


if __name__ == "__main__":
    FILE.write_text(format_header(), encoding="utf-8")
