"""What is set on a desk as a file: brake, line, settings, pinned curves; without dropped data."""

from __future__ import annotations

import json
from dataclasses import asdict

from layerjam.errors import FileError
from layerjam.workbench.state import State, Strange, read_state
from layerjam.workbench.uploads import LARGEST

ENDING = ".json"
KIND, VERSION = "session of the layerjam workbench", 1


def to_session(state: State) -> str:
    """The file's text."""
    whole = {"kind": KIND, "version": VERSION, **asdict(state)}
    return json.dumps(whole, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def from_session(data: bytes, name: str) -> State:
    """The state that a file of this `name` holds; FileError says why it holds none."""
    if len(data) > LARGEST:  # what the page writes is smaller: of each brake in it 1 MB are read
        raise FileError(name, f"is larger than {LARGEST // 2**20} MB, too large for a session")
    try:
        text = data.decode("utf-8-sig")
        whole = json.loads(text)
    except (ValueError, RecursionError):
        raise FileError(name, "is not JSON, so it is no session") from None
    if not isinstance(whole, dict) or whole.get("kind") != KIND:
        raise FileError(name, f'is no session: its "kind" is not "{KIND}"')
    if whole.get("version") != VERSION:
        said = "a session of another version; open it with the layerjam that wrote it"
        raise FileError(name, f"is {said}")
    try:
        return read_state(text)
    except Strange as err:
        raise FileError(name, f"holds what no session has: {err}") from None
