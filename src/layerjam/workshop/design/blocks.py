"""Sweep stored on disk: one complete Parquet file per block and, written last, a manifest.

The file of a block contains the designs kept from the block (its Pareto front, and those the
verdict mentions) with all variables and merits; its metadata contains the totals of the whole
block. The same block always produces the same bytes on any machine, so a repeat is harmless.
"""

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
from layerjam.core.errors import FileError, MissingExtraError
from layerjam.core.store import store_file
from layerjam.core.system import check_file_name, lock_file, report_failure
from layerjam.core.units import QuantitySpec
from layerjam.workshop.design.grid import Grid
from layerjam.workshop.design.merit import MERITS, VARIABLES
from layerjam.workshop.design.requirements import DesignSpecification
from layerjam.workshop.design.search import CHUNK, Search, SweepResult

MANIFEST, FRONT, NOTE = "manifest.json", "front.parquet", "sweep.json"
LOCK, FOLDER, PROBABILITY = ".lock", "blocks", "probability"
COUNTED = ("examined", "built", "feasible", "failed", "low", "high")
"""Totals over all designs of a block, stored in its metadata; the table has the other fields."""


def import_parquet() -> Any:
    """Return pyarrow's Parquet module; raises MissingExtraError if it is not installed."""
    with MissingExtraError.raise_if_missing("a sweep on disk (pyarrow)", "sweep"):
        import pyarrow.parquet  # type: ignore[import-untyped]
    return pyarrow.parquet


def fingerprint(spec: DesignSpecification, block: int) -> str:
    """Return the SHA-256 of everything that affects the result: designs, inputs and version."""
    grid: Grid = spec.grid
    parts: list[Any] = [__version__, block, CHUNK, grid.names, grid.thickness.tolist()]
    parts += [[np.asarray(row).tolist() for row in grid.stock]]
    parts += [[(n, v.tolist()) for n, v in grid.axes.items()]]
    parts += [grid.fittings_length, grid.link_gap]
    evaluation = spec.evaluation
    parts += [repr(evaluation.base), repr(evaluation.stick_slip), repr(evaluation.stop)]
    parts += [None if evaluation.line is None else evaluation.line.tolist()]
    parts += [spec.confidence, repr(spec.scatter)] if spec.confidence else []
    parts += [[repr(c) for c in spec.constraints], [repr(o) for o in spec.objectives]]
    parts += [repr(evaluation.draw)] if spec.drawn_merits else []
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def encode_block(search: Search, index: int, result: SweepResult, mark: str) -> bytes:
    """Return the Parquet file of a block, with the same bytes for the same block."""
    totals = {name: np.asarray(getattr(result, name)).tolist() for name in COUNTED}
    on_front = np.isin(np.arange(len(result.numbers)), search.find_highlights(result).front)
    note = {"block": index, "fingerprint": mark, "found": totals}
    return table_bytes(search, result.numbers, result.asked[-1], on_front, note)


def table_bytes(
    search: Search, numbers: Any, chances: Any, on_front: Any, note: dict[str, Any]
) -> bytes:
    """Return designs with all variables and merits as a Parquet file; `note` becomes metadata.

    `chances` are the probabilities that they meet all constraints.
    """
    pq = import_parquet()
    import pyarrow as pa  # type: ignore[import-untyped]

    grid, names = search.spec.grid, search.spec.merits
    values = np.empty((len(names), 0))
    if len(numbers):
        values = np.concatenate([search.kernel.all_merits(numbers), search.drawn_merits(numbers)])
    # the merit is the travel of all brakes in series, but the variable is the travel of one brake
    rows = {("travel_of_one" if n in names else n): v for n, v in grid.columns(numbers).items()}
    rows |= dict(zip(names, values, strict=True))
    columns: dict[str, Any] = {
        "number": pa.array(numbers, pa.int64()),
        "on_front": pa.array(on_front, pa.bool_()),
        PROBABILITY: pa.array(chances, pa.float64()),
        "film": pa.array(np.array(grid.names, object)[grid.digits(numbers)[0]], pa.string()),
        **{n: pa.array(np.asarray(row, float), pa.float64()) for n, row in rows.items()},
    }
    specs: dict[str, QuantitySpec] = {**VARIABLES, **MERITS}
    schema = pa.schema(
        [
            pa.field(n, c.type, metadata={"unit": specs[n].unit} if n in specs else None)
            for n, c in columns.items()
        ],
        metadata={"layerjam": json.dumps(note, sort_keys=True)},
    )
    sink = io.BytesIO()
    pq.write_table(pa.table(list(columns.values()), schema=schema), sink, compression="zstd")
    return sink.getvalue()


def decode_block(search: Search, data: bytes | Path, mark: str, index: int) -> SweepResult | None:
    """Return the result of a block from its file, or None if the file is of a different block."""
    pq = import_parquet()
    try:
        table = pq.read_table(io.BytesIO(data) if isinstance(data, bytes) else data)
        note = json.loads(table.schema.metadata[b"layerjam"])
        if note["fingerprint"] != mark or note["block"] != index:
            return None
        totals: dict[str, Any] = note["found"]
        totals |= {n: np.array(v) for n, v in totals.items() if isinstance(v, list)}
        quantities = np.array([table[n].to_numpy() for n in (*search.wanted, PROBABILITY)])
        return SweepResult(numbers=table["number"].to_numpy(), asked=quantities, **totals)
    except (OSError, ValueError, KeyError, TypeError):
        return None


class Store:
    """Folder of one sweep; as a context manager, it locks out other processes."""

    def __init__(self, folder: str | Path, search: Search) -> None:
        self.folder, self.search, self.spec = Path(folder), search, search.spec
        self.mark = fingerprint(search.spec, search.size)
        self.handle: int | None = None

    def __enter__(self) -> "Store":
        import_parquet()
        check_file_name(self.folder)
        self._reject_foreign_folder()
        with report_failure(self.folder, "cannot be written"):
            (self.folder / FOLDER).mkdir(parents=True, exist_ok=True)
            self.handle = handle = os.open(self.folder / LOCK, os.O_RDWR | os.O_CREAT)
        try:
            if not lock_file(handle):
                raise FileError(self.folder, "another sweep is running in this folder")
            self._claim_folder()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self.handle is not None:
            os.close(self.handle)
            self.handle = None

    def _reject_foreign_folder(self) -> None:
        """Reject a folder whose files would be replaced, before anything is written to it."""
        if (self.folder / NOTE).exists():
            return
        with report_failure(self.folder, "cannot be read"):
            has_files = any((self.folder / name).exists() for name in (MANIFEST, FRONT))
            has_files = has_files or any((self.folder / FOLDER).glob("*"))
        if has_files:
            raise FileError(self.folder, "contains other files; choose an empty folder")

    def _claim_folder(self) -> None:
        """Claim the folder for this sweep, and remove incomplete files left by a killed one."""
        note = self.folder / NOTE
        if note.exists():
            with contextlib.suppress(OSError, ValueError, KeyError):
                if json.loads(note.read_text(encoding="utf-8"))["fingerprint"] == self.mark:
                    for path in (*self.folder.glob(".*-*"), *(self.folder / FOLDER).glob(".*-*")):
                        path.unlink()
                    return
            raise FileError(
                self.folder,
                "contains a sweep of a different specification or version; choose an empty folder",
            )
        header = {
            "name": self.spec.name,
            "fingerprint": self.mark,
            "designs": self.spec.grid.size,
            "block": self.search.size,
            "specification": self.spec.text,
        }
        write_block(note, (json.dumps(header, indent=1) + "\n").encode())

    def path(self, index: int) -> Path:
        """Return the path of block `index`."""
        return self.folder / FOLDER / f"block-{index:07d}.parquet"

    def read_block(self, index: int) -> SweepResult | None:
        """Return a block stored earlier, or None if it is missing or incomplete."""
        path = self.path(index)
        return decode_block(self.search, path, self.mark, index) if path.is_file() else None

    def find_missing_blocks(self, total: int) -> list[int]:
        """Return the numbers of the blocks that are still to be computed."""
        return [i for i in range(total) if self.read_block(i) is None]

    def write_block(self, index: int, data: "bytes") -> None:
        """Write a block, completely or not at all."""
        write_block(self.path(index), data)

    def read_blocks(self, total: int) -> Iterator[SweepResult]:
        """Yield all blocks in order; raises FileError if one is missing."""
        for index in range(total):
            result = self.read_block(index)
            if result is None:
                raise FileError(self.path(index), "is missing or incomplete; run the sweep again")
            yield result

    def write_manifest(self, total: int) -> SweepResult:
        """Write the front of all designs and then the manifest; return the sum of all blocks."""
        search = self.search
        rows: list[dict[str, Any]] = []

        def list_blocks() -> Iterator[SweepResult]:
            for index, result in enumerate(self.read_blocks(total)):
                path = self.path(index)
                rows.append(
                    {
                        "file": f"{FOLDER}/{path.name}",
                        "rows": len(result.numbers),
                        "designs": result.examined,
                        "feasible": result.feasible,
                        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
                    }
                )
                yield result

        result = search.add_runs(list_blocks())
        places = search.find_highlights(result).front
        front, chances = result.numbers[places], result.asked[-1, places]
        every, note = np.ones(len(front), bool), {"fingerprint": self.mark}
        table = table_bytes(search, front, chances, every, note)
        write_block(self.folder / FRONT, table)
        manifest = {
            "name": self.spec.name,
            "fingerprint": self.mark,
            "layerjam": __version__,
            "designs": self.spec.grid.size,
            "block": search.size,
            "front": FRONT,
            "front_rows": len(front),
            "front_sha256": hashlib.sha256(table).hexdigest(),
            "constraints": [str(c) for c in self.spec.constraints],
            "objectives": [str(o) for o in self.spec.objectives],
            "found": search.summary(result),
            "blocks": rows,
        }
        write_block(self.folder / MANIFEST, (json.dumps(manifest, indent=1) + "\n").encode())
        return result

    def size_in_bytes(self) -> int:
        """Return the size of the sweep on disk."""
        return sum(p.stat().st_size for p in self.folder.rglob("*") if p.is_file())


def write_block(path: Path, data: bytes) -> None:
    """Write a file so that it appears completely or not at all, and survives a power failure."""

    def write_content(temporary: Path) -> None:
        with temporary.open("wb") as handle:
            handle.write(data)
            handle.flush()
            os.fsync(handle.fileno())

    store_file(path, write_content, overwrite=True)
