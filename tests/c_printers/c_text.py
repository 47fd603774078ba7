"""Words of C: names, declarations, structures and lines, for the printers of Python as C."""

import re
import textwrap
import typing
from typing import Any

RESERVED = {"case", "short", "long", "double", "float", "int", "register", "signed", "static"}
REAL, INTEGER, WORD, TRUTH = "double", "int64_t", "uint64_t", "int"
TYPES = {
    "float": REAL,
    "int": INTEGER,
    "Word": WORD,
    "bool": TRUTH,
    "Sequence[float]": "const double *",
    "Sequence[int]": "const int64_t *",
    "Array": "double *",
}
"""{annotation: C type}."""


def format_record(record: Any) -> str:
    """Return a named tuple of numbers and sequences as a C structure."""
    fields = (
        f"    {join_declaration(kind, c_variable(n))};\n" for n, kind in field_types(record).items()
    )
    return f"typedef struct {{\n{''.join(fields)}}} {record_name(record.__name__)};\n"


def field_types(record: Any) -> dict[str, str]:
    """Return {field of a named tuple: C type}."""
    kinds = {}
    for name, kind in typing.get_type_hints(record).items():
        parts = [kind, *typing.get_args(kind)]
        words = [getattr(typing.get_origin(part) or part, "__name__", "") for part in parts]
        kinds[name] = TYPES[words[0] if len(words) == 1 else f"{words[0]}[{words[1]}]"]
    return kinds


def record_name(name: str) -> str:
    """Return the C type of a named tuple."""
    return "lj_" + re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def join_declaration(kind: str, name: str) -> str:
    """Return a type and a name as C declares them."""
    return f"{kind}{name}" if kind.endswith("*") else f"{kind} {name}"


def c_variable(name: str) -> str:
    """Return the name of a variable in C."""
    return name + "_" if name in RESERVED else name


def c_function(name: str) -> str:
    """Return the name of a function in C."""
    return "lj_" + name.lstrip("_")


def wrap_line(text: str, depth: int = 0) -> str:
    """Return a line of C, indented and broken at 100 characters."""
    first, later = "    " * depth, "    " * max(depth + 1, 2)
    return textwrap.fill(
        text,
        100,
        initial_indent=first,
        subsequent_indent=later,
        break_on_hyphens=False,
        break_long_words=False,
    )
