"""List of commands, found by their declarations without importing code that computes.

Packages in the entry point group `layerjam.commands` contain files with `@command(`. `--help` reads
the decorator, name and first sentence of each from the source, in milliseconds. The module of a
command is imported when the command is used. Order and examples of our own are in help.toml.
"""

import ast
import functools
import importlib.util
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from layerjam.core.command.arguments import command_line_name
from layerjam.core.errors import InstallationError
from layerjam.core.plugins import find_points

GROUPS = {
    "predict": "Predict the behaviour of a brake",
    "test": "Read tests and calibrate",
    "vacuum": "Create and control the vacuum",
    "design": "Design a brake",
    "build": "Build a brake",
    "bench": "Run the bench",
    "share": "Report and share",
    "develop": "For developers of the method",
}
"""Groups of commands by task, in the order of `layerjam --help`."""
_LIST = tomllib.loads(Path(__file__).with_name("help.toml").read_text(encoding="utf-8"))
EXAMPLES: dict[str, list[str]] = _LIST["examples"]
FORMER: dict[str, str] = _LIST["former"]
"""Former names of commands, with their current names."""
HIDDEN: list[str] = _LIST["hidden"]
"""Commands that work but are not listed."""
GROUP = "layerjam.commands"
"""Entry points: packages whose modules declare commands."""
DECORATOR = re.compile(r"\n@(?:\w+\.)*command\(")
HEAD = re.compile(
    r'\n@command\(.*?^def \w+\(.*?\) -> [^\n]+:\n    """.*?"""\n', re.DOTALL | re.MULTILINE
)


@dataclass(frozen=True)
class Entry:
    """Entry of one command in the list of commands."""

    name: str
    python_name: str
    module: str
    group: str
    summary: str

    @property
    def examples(self) -> list[str]:
        """Lines to type."""
        return EXAMPLES.get(self.name, [])


DECLARED: dict[str, Entry] = {}
"""{name: Entry} of every command declared so far, which may be outside the searched folders."""


def _read_entries(path: Path, module: str) -> Iterator[Entry]:
    """Yield the entries in a file; raises RuntimeError if a command's header cannot be parsed."""
    text = path.read_text(encoding="utf-8")
    for decorator in DECORATOR.finditer(text):
        head = HEAD.match(text, decorator.start())
        body: Any = ast.parse(head[0]).body if head else ()
        if len(body) != 1:
            line = text.count("\n", 0, decorator.end()) + 1
            raise RuntimeError(
                f"{path}, line {line}: command not recognised; a command is a function of the "
                "module with @command(...), a result type and a docstring"
            )
        function = body[0]
        call = function.decorator_list[0]
        keywords = {str(k.arg): ast.literal_eval(k.value) for k in call.keywords}
        doc = (ast.get_docstring(function) or "").split("\n\n")[0].replace("\n", " ")
        yield Entry(
            name=command_line_name(function.name, keywords.get("parent", "")),
            python_name=function.name,
            module=module,
            group=ast.literal_eval(call.args[0]),
            summary=doc,
        )


@functools.cache
def _source_entries() -> tuple[Entry, ...]:
    return tuple(entry for module, path in _find_files() for entry in _read_entries(path, module))


def _find_files() -> Iterator[tuple[str, Path]]:
    """Yield (module, file) of the packages with commands."""
    for package in sorted({point.value for point in find_points(GROUP)}):
        spec = importlib.util.find_spec(package)
        for folder in map(Path, spec.submodule_search_locations or () if spec else ()):
            for path in sorted(folder.rglob("*.py")):
                inner = path.relative_to(folder).with_suffix("").parts
                yield ".".join((package, *inner)), path


def commands() -> dict[str, Entry]:
    """Return {name: Entry} of every command, ordered by group and then as in help.toml.

    Raises InstallationError if the installed entry points do not lead to all of our own commands.
    """
    entries = DECLARED | {entry.name: entry for entry in _source_entries()}
    if missing := [name for name in EXAMPLES if name not in entries]:
        raise InstallationError(f"commands such as {', '.join(missing[:3])}")
    groups, names = [*GROUPS], [*EXAMPLES, *sorted({*entries} - {*EXAMPLES})]
    return {
        name: entries[name] for name in sorted(names, key=lambda n: groups.index(entries[n].group))
    }


def find_entry(name: str) -> Entry | None:
    """Return the command of the given name, as typed or as in Python; former names work too."""
    typed_name = name.replace("_", "-")
    typed_name = FORMER.get(typed_name, typed_name)
    return next(
        (e for e in commands().values() if name == e.python_name or typed_name == e.name), None
    )


def family_names(word: str) -> tuple[str, ...]:
    """Return the names of the two-word commands that start with `word`."""
    return tuple(name for name in commands() if name.startswith(f"{word} "))
