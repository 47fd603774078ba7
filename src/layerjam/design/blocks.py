"""A sweep on disk: one Parquet file a block, each whole or not there, and the manifest last.

A block's file holds the designs it keeps (its front, and what the verdict speaks of) with all their
variables and merits; what the whole block came to stands in its metadata. The same block always
gives the same bytes, wherever it was computed, so that doing one twice changes nothing.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.design.grid import Grid
from layerjam.design.merit import MERITS, VARIABLES
from layerjam.design.requirements import DesignSpecification
from layerjam.design.search import CHUNK, Search, SweepResult
from layerjam.device.load import write_whole
from layerjam.errors import FileError, MissingExtraError
from layerjam.units import QuantitySpec

MANIFEST, FRONT, NOTE = "manifest.json", "front.parquet", "sweep.json"
LOCK, FOLDER = ".lock", "blocks"
COUNTED = ("examined", "built", "feasible", "failed", "low", "high")
"""What a block's metadata says of all its designs; the rest is in its table."""


def parquet() -> Any:
    """pyarrow's Parquet; raises MissingExtraError without it."""
    with MissingExtraError.raise_if_missing("a sweep on disk (pyarrow)", "sweep"):
        import pyarrow.parquet  # type: ignore[import-untyped]
    return pyarrow.parquet


def fingerprint(spec: DesignSpecification, block: int) -> str:
    """SHA-256 of all that decides what a sweep finds: designs, requirements, inputs, version."""
    grid: Grid = spec.grid
    parts: list[Any] = [__version__, block, CHUNK, grid.names, grid.thickness.tolist()]
    parts += [[np.asarray(row).tolist() for row in grid.stock]]
    parts += [[(n, v.tolist()) for n, v in grid.axes.items()]]
    asked = spec.evaluation
    parts += [repr(asked.base), repr(asked.stick_slip), repr(asked.stop)]
    parts += [None if asked.line is None else asked.line.tolist()]
    parts += [[repr(c) for c in spec.constraints], [repr(o) for o in spec.objectives]]
    parts += [repr(asked.draw)] if spec.drawn else []
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def encoded(search: Search, index: int, found: SweepResult, mark: str) -> bytes:
    """The Parquet file of a block, the same bytes for the same block."""
    counted = {name: np.asarray(getattr(found, name)).tolist() for name in COUNTED}
    on_front = np.isin(np.arange(len(found.numbers)), search.told(found).front)
    note = {"block": index, "fingerprint": mark, "found": counted}
    return table_bytes(search, found.numbers, on_front, note)


def table_bytes(search: Search, numbers: Any, on_front: Any, note: dict[str, Any]) -> bytes:
    """Designs with all variables and merits as a Parquet file, `note` in its metadata."""
    pq = parquet()
    import pyarrow as pa  # type: ignore[import-untyped]

    grid, names = search.spec.grid, search.spec.merits
    values = np.empty((len(names), 0))
    if len(numbers):
        values = np.concatenate([search.kernel.at(numbers), search.drawn(numbers)])
    # the travel of all brakes in series is a merit; that of one is the variable
    rows = {("travel_of_one" if n in names else n): v for n, v in grid.columns(numbers).items()}
    rows |= dict(zip(names, values, strict=True))
    columns: dict[str, Any] = {
        "number": pa.array(numbers, pa.int64()),
        "on_front": pa.array(on_front, pa.bool_()),
        "film": pa.array(np.array(grid.names, object)[grid.digits(numbers)[0]], pa.string()),
        **{n: pa.array(np.asarray(row, float), pa.float64()) for n, row in rows.items()},
    }
    known: dict[str, QuantitySpec] = {**VARIABLES, **MERITS}
    schema = pa.schema(
        [
            pa.field(n, c.type, metadata={"unit": known[n].unit} if n in known else None)
            for n, c in columns.items()
        ],
        metadata={"layerjam": json.dumps(note, sort_keys=True)},
    )
    sink = io.BytesIO()
    pq.write_table(pa.table(list(columns.values()), schema=schema), sink, compression="zstd")
    return sink.getvalue()


def decoded(search: Search, data: bytes | Path, mark: str, index: int) -> SweepResult | None:
    """What a block came to, read back; None where the file is no such block."""
    pq = parquet()
    try:
        table = pq.read_table(io.BytesIO(data) if isinstance(data, bytes) else data)
        note = json.loads(table.schema.metadata[b"layerjam"])
        if note["fingerprint"] != mark or note["block"] != index:
            return None
        counted: dict[str, Any] = note["found"]
        counted |= {n: np.array(v) for n, v in counted.items() if isinstance(v, list)}
        asked = np.array([table[name].to_numpy() for name in search.wanted])
        return SweepResult(numbers=table["number"].to_numpy(), asked=asked, **counted)
    except (OSError, ValueError, KeyError, TypeError):
        return None


class Store:
    """The folder of one sweep; use as a context, which keeps a second process out."""

    def __init__(self, folder: str | Path, search: Search) -> None:
        self.folder, self.search, self.spec = Path(folder), search, search.spec
        self.mark = fingerprint(search.spec, search.size)
        self.handle: int | None = None

    def __enter__(self) -> Store:
        parquet()
        self._foreign()
        try:
            (self.folder / FOLDER).mkdir(parents=True, exist_ok=True)
            self.handle = handle = os.open(self.folder / LOCK, os.O_RDWR | os.O_CREAT)
        except OSError as err:
            raise FileError(self.folder, f"cannot be written: {err.strerror or err}") from None
        try:
            self._locked(handle)
            self._claim()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self.handle is not None:
            os.close(self.handle)
            self.handle = None

    def _locked(self, handle: int) -> None:
        """The lock ends with the process, however that ends."""
        try:
            import fcntl
        except ImportError:  # pragma: no cover  (elsewhere than on POSIX nobody is kept out)
            return
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise FileError(self.folder, "another sweep is at work in this folder") from None

    def _foreign(self) -> None:
        """Refuse a folder whose files would be replaced, before anything is written there."""
        if (self.folder / NOTE).exists():
            return
        try:
            theirs = any((self.folder / name).exists() for name in (MANIFEST, FRONT))
            theirs = theirs or any((self.folder / FOLDER).glob("*"))
        except OSError as err:
            raise FileError(self.folder, f"cannot be read: {err.strerror or err}") from None
        if theirs:
            raise FileError(self.folder, "holds files of something else; give an empty folder")

    def _claim(self) -> None:
        """Make the folder this sweep's; clear away what a killed one left half written."""
        note = self.folder / NOTE
        if note.exists():
            with contextlib.suppress(OSError, ValueError, KeyError):
                if json.loads(note.read_text(encoding="utf-8"))["fingerprint"] == self.mark:
                    for rest in (*self.folder.glob(".*-*"), *(self.folder / FOLDER).glob(".*-*")):
                        rest.unlink()
                    return
            raise FileError(
                self.folder,
                "holds a sweep of another specification or version; give an empty folder",
            )
        said = {
            "name": self.spec.name,
            "fingerprint": self.mark,
            "designs": self.spec.grid.size,
            "block": self.search.size,
            "specification": self.spec.text,
        }
        put(note, (json.dumps(said, indent=1) + "\n").encode())

    def path(self, index: int) -> Path:
        """Where block `index` lies."""
        return self.folder / FOLDER / f"block-{index:07d}.parquet"

    def read(self, index: int) -> SweepResult | None:
        """A block that was done before, None where it is missing or not whole."""
        path = self.path(index)
        return decoded(self.search, path, self.mark, index) if path.is_file() else None

    def missing(self, total: int) -> list[int]:
        """Numbers of the blocks still to do."""
        return [i for i in range(total) if self.read(i) is None]

    def put(self, index: int, data: bytes) -> None:
        """Write a block, whole or not at all."""
        put(self.path(index), data)

    def blocks(self, total: int) -> Iterator[SweepResult]:
        """All blocks in their order; raises FileError where one is missing."""
        for index in range(total):
            found = self.read(index)
            if found is None:
                raise FileError(self.path(index), "is missing or not whole; sweep again")
            yield found

    def finish(self, total: int) -> SweepResult:
        """Sum of all blocks, the front of all designs, and the manifest, which comes last."""
        search = self.search
        rows: list[dict[str, Any]] = []

        def parts() -> Iterator[SweepResult]:
            for index, found in enumerate(self.blocks(total)):
                path = self.path(index)
                rows.append(
                    {
                        "file": f"{FOLDER}/{path.name}",
                        "rows": len(found.numbers),
                        "designs": found.examined,
                        "feasible": found.feasible,
                        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
                    }
                )
                yield found

        found = search.sum(parts())
        front = found.numbers[search.told(found).front]
        whole = table_bytes(search, front, np.ones(len(front), bool), {"fingerprint": self.mark})
        put(self.folder / FRONT, whole)
        manifest = {
            "name": self.spec.name,
            "fingerprint": self.mark,
            "layerjam": __version__,
            "designs": self.spec.grid.size,
            "block": search.size,
            "front": FRONT,
            "front_rows": len(front),
            "front_sha256": hashlib.sha256(whole).hexdigest(),
            "constraints": [str(c) for c in self.spec.constraints],
            "objectives": [str(o) for o in self.spec.objectives],
            "found": search.summary(found),
            "blocks": rows,
        }
        put(self.folder / MANIFEST, (json.dumps(manifest, indent=1) + "\n").encode())
        return found

    def bytes(self) -> int:
        """What the sweep takes on disk."""
        return sum(p.stat().st_size for p in self.folder.rglob("*") if p.is_file())


def put(path: Path, data: bytes) -> None:
    """A file that appears whole or not at all, and stays after a loss of power."""

    def write(temporary: Path) -> None:
        with temporary.open("wb") as handle:
            handle.write(data)
            handle.flush()
            os.fsync(handle.fileno())

    write_whole(path, write, force=True)
