"""`conditions.csv` dropped on the page: one table with the conditions of many files."""

from __future__ import annotations

from typing import Any

import tomlkit

from layerjam.errors import FileError, LayerjamError
from layerjam.measure.conditions import LIST, listed
from layerjam.measure.sidecar import Facts, facts_text, values_of
from layerjam.records.toml import MAX_BYTES
from layerjam.units import QuantitySpec, build, show, spec_of
from layerjam.workbench.uploads import Uploads, clean


def is_list(name: str) -> bool:
    """Whether a file is called as the commands look for it."""
    return clean(name).lower() == LIST


def read_list(data: bytes, name: str) -> dict[str, str]:
    """{file's name: its conditions as a sidecar's text} of a list.

    Raises FileError, with the line, for what is none.
    """
    if len(data) > MAX_BYTES:
        raise FileError(name, f"is larger than {MAX_BYTES // 1000} kB, too large for such a list")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(name, "is no text in UTF-8") from None
    found = listed(text, name)
    return {clean(file): facts_text(build(Facts, said)) for file, said in found.items()}


def attach(uploads: Uploads) -> tuple[list[str], list[str]]:
    """(names of the files that the list speaks of, contradictions), their sidecars completed.

    A file's own sidecar counts where both say something; the commands refuse that, and here a
    sentence says it. What the list says stays known for files that come later.
    """
    taken, told = [], []
    for one in uploads.files:
        of_list = uploads.listed.get(one.shown)
        if of_list is None:
            continue
        taken.append(one.shown)
        if one.shown in uploads.from_list:
            continue
        own = uploads.sidecars.get(one.shown, "")
        said, stated = values_of(of_list, LIST), _stated(own)
        for key in said.keys() & stated.keys():
            if said[key] != stated[key]:
                told.append(
                    f"{one.shown}: its sidecar states {key.replace('_', ' ')} "
                    f"{_text(key, stated[key])}, {LIST} {_text(key, said[key])}; the sidecar counts"
                )
        uploads.from_list[one.shown] = frozenset(said.keys() - stated.keys())
        uploads.sidecars[one.shown] = over(own, of_list)
    return taken, told


def over(own: str, of_all: str) -> str:
    """A sidecar's text with what another one says besides; its own words count."""
    try:
        document, more = tomlkit.parse(own), tomlkit.parse(of_all)
    except tomlkit.exceptions.TOMLKitError:
        return own or of_all
    for key, value in more.items():
        if key not in document:
            document[key] = value
    return tomlkit.dumps(document)


def _stated(own: str) -> dict[str, Any]:
    """What a sidecar states; nothing where it is refused, which is said where it is read."""
    try:
        return values_of(own, "the sidecar")
    except LayerjamError:
        return {}


def _text(key: str, value: Any) -> str:
    spec = spec_of(Facts, key)
    return show(value, spec.unit) if isinstance(spec, QuantitySpec) else f"'{value}'"
