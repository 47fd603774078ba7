"""What is set on a desk as a file: brake, line, settings, pinned curves.

Of dropped files it holds those that are pinned, whole; the others stay where they are.
"""

import base64
import binascii
import json
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from layerjam.errors import FileError, QuantityError
from layerjam.workbench.state import State, Strange, read_state
from layerjam.workbench.uploads import LARGEST, Uploads

ENDING = ".json"
KIND, VERSION = "session of the layerjam workbench", 1


MANY = 64
"""Files in a session at most; the page pins fewer."""


@dataclass(frozen=True)
class KeptFile:
    """A dropped file in a session: the user's name for it, its bytes and its sidecar's text."""

    name: str
    data: bytes
    sidecar: str = ""


class Session(NamedTuple):
    """What a session's file holds."""

    state: State
    files: tuple[KeptFile, ...] = ()


def kept_files(state: State, uploads: Uploads) -> tuple[KeptFile, ...]:
    """The pinned files among those of a tab."""
    return tuple(
        KeptFile(one.shown, one.path.read_bytes(), uploads.sidecars.get(one.shown, ""))
        for one in list(uploads.files)
        if one.key in state.files
    )


def to_session(state: State, files: Sequence[KeptFile] = ()) -> str:
    """The file's text; QuantityError where pinned files make it larger than what is opened."""
    whole: dict[str, Any] = {"kind": KIND, "version": VERSION, **asdict(state)}
    if files:
        whole["files"] = [
            {
                "name": f.name,
                "sidecar": f.sidecar,
                "content": base64.b64encode(zlib.compress(f.data)).decode(),
            }
            for f in files
        ]
    text = json.dumps(whole, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    size = max(len(text.encode()), sum(len(f.data) for f in files))
    if files and size > LARGEST:
        raise QuantityError(
            f"session: the pinned files make it {size / 2**20:.0f} MB; at most "
            f"{LARGEST // 2**20} MB are opened again, so unpin one"
        )
    return text


def from_session(data: bytes, name: str) -> Session:
    """What a file of this `name` holds; FileError says why it holds no session."""
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
        return Session(read_state(text), tuple(_unpacked(whole.get("files", []))))
    except Strange as err:
        raise FileError(name, f"holds what no session has: {err}") from None


def _unpacked(held: Any) -> list[KeptFile]:
    """The files of a session, together no larger than one that may be dropped; raises Strange."""
    if not isinstance(held, list) or len(held) > MANY:
        raise Strange(f"files: a list of at most {MANY} is due")
    made, left = [], LARGEST
    for place, one in enumerate(held):
        given = one if isinstance(one, dict) else {}
        name, sidecar, content = (given.get(key) for key in ("name", "sidecar", "content"))
        if not (isinstance(name, str) and isinstance(sidecar, str) and isinstance(content, str)):
            raise Strange(f"files.{place}: name, sidecar and content are texts")
        reader = zlib.decompressobj()
        try:
            data = reader.decompress(base64.b64decode(content, validate=True), left + 1)
        except (binascii.Error, zlib.error, ValueError):
            raise Strange(f"files.{place}.content: it cannot be unpacked") from None
        left -= len(data)
        if left < 0:
            raise Strange(f"files: together they are larger than {LARGEST // 2**20} MB")
        if not reader.eof:
            raise Strange(f"files.{place}.content: it is cut off")
        made.append(KeptFile(name, data, sidecar))
    return made
