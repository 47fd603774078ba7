"""Brakes and lines of one name and other content, told apart in what is copied."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from layerjam.workbench.call import Call, Subject


@dataclass(frozen=True)
class Apart:
    """Calls whose files are named each under its own name.

    `texts` is {file name: content} of what is in no catalogue and has to be saved.
    """

    calls: Sequence[Call]
    pinned: Mapping[str, Call]
    texts: dict[str, str] = field(default_factory=dict)


def apart(calls: Sequence[Call], pinned: Mapping[str, Call] = MappingProxyType({})) -> Apart:
    """The calls with their files named apart.

    Two brakes may have one name: the edited one, and the one that was pinned before. A file that
    the call before writes keeps its name.
    """
    texts: dict[str, str] = {}
    named = [_own(call, texts) for call in calls]
    return Apart(named, {label: _own(call, texts) for label, call in pinned.items()}, texts)


def _own(call: Call, texts: dict[str, str]) -> Call:
    """The call, its files named as `texts` keeps them."""

    def kept(subject: Subject) -> Subject:
        if subject.file is None or call.made:
            return subject
        stem, name, count = subject.name.removesuffix(".toml"), subject.name, 1
        while texts.setdefault(name, subject.file.text) != subject.file.text:
            count += 1
            name = f"{stem}-{count}.toml"
        return replace(subject, name=name)

    options = {k: kept(v) if isinstance(v, Subject) else v for k, v in call.options.items()}
    return replace(call, subjects=tuple(map(kept, call.subjects)), options=options)
