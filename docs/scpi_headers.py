"""The headers of the instrument's firmware, with their functions: the SCPI reference."""

import json
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from layerjam.bench.rig.board import write_firmware

NOTES = Path(__file__).with_name("scpi_headers.toml")
REACH = "reach"
"""A bound that depends on the regulator."""
SCRIPT = f"""
import json, sys
sys.path.insert(0, sys.argv[1])
import commands
def bound(value):
    return {REACH!r} if callable(value) else value
def said(param):
    out = {{"name": param.name}}
    for key in ("unit", "lo", "hi", "default", "whole", "words", "most"):
        if hasattr(param, key):
            out[key] = bound(getattr(param, key))
    return out
def rule(made):
    if made is None:
        return None
    params = [said(param) for param in made.params]
    return {{"params": params, "least": made.least, "flags": made.flags}}
rows = [(header, rule(command), rule(query)) for header, command, query in commands.TABLE]
print(json.dumps(rows))
"""


@dataclass(frozen=True)
class Header:
    """One header: parameters of its command and of its query (None if it has none), and a note.

    `flags` are those of the command: L is rejected for others while locked; S is allowed only in
    SAFE.
    """

    header: str
    command: Sequence[Mapping[str, Any]] | None
    query: Sequence[Mapping[str, Any]] | None
    least: int
    """Required parameters."""
    flags: str
    group: str
    note: str

    @property
    def shown(self) -> str:
        """The header with `?` if it has only a query, `(?)` if it has both forms."""
        return self.header + (
            "" if self.query is None else "(?)" if self.command is not None else "?"
        )


def headers() -> list[Header]:
    """Return all headers, in the order of NOTES; KeyError for one that has no note."""
    with tempfile.TemporaryDirectory(prefix="layerjam-headers-") as folder:
        write_firmware(Path(folder))
        process = subprocess.run(
            [sys.executable, "-S", "-E", "-s", "-B", "-c", SCRIPT, folder],
            capture_output=True,
            text=True,
            check=True,
        )
    table = {header: (command, query) for header, command, query in json.loads(process.stdout)}
    out = []
    for group, notes in tomllib.loads(NOTES.read_text("utf-8")).items():
        for header, note in notes.items():
            command, query = table.pop(header)
            first = command or query
            out.append(
                Header(
                    header=header,
                    command=None if command is None else command["params"],
                    query=None if query is None else query["params"],
                    least=first["least"],
                    flags="" if command is None else command["flags"],
                    group=group,
                    note=note,
                )
            )
    if table:
        raise KeyError(f"{NOTES.name}: no note for {', '.join(table)}")
    return out


def bounds(param: Mapping[str, Any]) -> str:
    """Return the allowed values as a phrase: `0 to reach Pa`, `RELease or HOLD`."""
    if "words" in param:
        return " or ".join(f"`{word}`" for word in param["words"])
    if "most" in param:
        return f"{param['name']}, a quoted string"
    if "lo" not in param:
        return "`MIN`, `MAX` or `DEF`"
    unit = f" {param['unit']}" if param["unit"] else ""
    default = param["default"]
    text = f"{param['name']} {_format_number(param['lo'])} to {_format_number(param['hi'])}{unit}"
    return text if default is None else f"{text}, default {_format_number(default)}"


def _format_number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.10g}".replace("-", "−")
