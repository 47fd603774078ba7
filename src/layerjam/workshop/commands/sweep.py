"""`sweep`: all designs of a specification, on disk in blocks that survive an interrupt."""

import functools
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from layerjam.brake.commands.arguments import Accept, Interval
from layerjam.core.command.declare import Help, Progress, PythonOnly, command
from layerjam.core.command.results import STOPPED, fact, number, result
from layerjam.core.errors import Notice
from layerjam.core.evolve import evolve
from layerjam.core.units import QuantitySpec
from layerjam.workshop.commands.design import (
    BrakeShare,
    DesignResult,
    SpecInput,
    best_result,
    infeasible_result,
)

if TYPE_CHECKING:
    from layerjam.workshop.design.blocks import Store
    from layerjam.workshop.design.search import Search

BLOCK_SIZE = QuantitySpec("1", "number of designs per block", lo=1, hi=1e9, whole=True)


@result
class DesignSweep(DesignResult):
    """Result of a design, and the blocks of the sweep on disk."""

    out: str = fact("folder with the blocks")
    complete: bool = fact("whether all blocks are done")
    blocks: int = number("1", "blocks of the sweep")
    blocks_done: int = number("1", "blocks completed")
    blocks_found: int = number("1", "blocks completed in earlier runs")
    bytes: int = number("B", "size of the folder", shown=lambda size: f"{size / 1e6:.3g} MB")

    @property
    def exit_code(self) -> int:
        """Exit code: as for `design`; 130 if stopped."""
        return STOPPED if self.feasible is None else super().exit_code


@command("design")
def sweep(
    spec: SpecInput,
    *,
    out: Annotated[
        str | Path, Help("Folder for the blocks. Give the same folder to resume.", metavar="DIR")
    ],
    scheduler: Annotated[
        str | None, Help("Dask cluster, e.g. tcp://10.0.0.1:8786.", metavar="ADDRESS")
    ] = None,
    block: Annotated[int, BLOCK_SIZE, PythonOnly("Number of designs per block.")] | None = None,
    accept: Accept = None,
    confidence: BrakeShare = 0.95,
    interval: Interval = "next",
    progress: Progress | None = None,
) -> DesignSweep:
    """Compute every design of a specification, in blocks on disk.

    The folder is new, empty or that of the same sweep. Such a sweep is resumed: `blocks_found` is
    the number of blocks that already exist. `block` is the number of designs in a block,
    `scheduler` the address of a Dask cluster. If interrupted, `complete` is False and the same call
    resumes. Raises FileError for a folder with other content, MissingExtraError if pyarrow or Dask
    is missing, and ClusterError.
    """
    from layerjam.workshop.design.blocks import NOTE, Store
    from layerjam.workshop.design.bounds import prove_impossible
    from layerjam.workshop.design.search import BLOCK, Search

    search = Search(evolve(spec, confidence=confidence or 0.0), BLOCK if block is None else block)
    total = search.count_blocks()
    make = functools.partial(DesignSweep.create, out=str(out), blocks=total)
    conflict = prove_impossible(search)
    if conflict is not None:
        never = functools.partial(make, complete=False, blocks_done=0, blocks_found=0, bytes=0)
        return infeasible_result(never, search, conflict)
    if scheduler is not None and not (Path(out) / NOTE).exists():
        from layerjam.workshop.design.cluster import check_cluster

        check_cluster(scheduler)
    with Store(out, search) as store:
        todo = store.find_missing_blocks(total)
        designs_done = before = total - len(todo)
        try:
            for index, data in _compute_blocks(search, todo, store, scheduler):
                store.write_block(index, data)
                designs_done += 1
                if progress is not None:
                    progress("designs", designs_done / total)
        except KeyboardInterrupt:
            designs_done = total - len(store.find_missing_blocks(total))
            text = f"stopped: {designs_done} of {total} blocks are done; run the same command to "
            facts = {"name": spec.name, "designs": spec.grid.size, "complete": False}
            facts |= {"blocks_done": designs_done, "blocks_found": before}
            size, notice = store.size_in_bytes(), Notice(f"{text}resume", "stopped")
            return make(**facts, bytes=size, warnings=[notice])
        sweep_result = store.write_manifest(total)
        whole_chunk = functools.partial(
            make, complete=True, blocks_done=total, blocks_found=before, bytes=store.size_in_bytes()
        )
        return best_result(whole_chunk, search, sweep_result, accept, interval == "mean")


def _compute_blocks(
    search: "Search", todo: list[int], store: "Store", scheduler: str | None
) -> Iterator[tuple[int, bytes]]:
    """Yield (index, content) of the blocks, computed here or on the cluster."""
    from layerjam.core.threads import Workers
    from layerjam.workshop.design.blocks import encode_block

    if scheduler is not None:
        from layerjam.workshop.design.cluster import compute_blocks

        yield from compute_blocks(search, todo, scheduler) if todo else ()
        return
    with Workers() as pool:
        for index in todo:
            yield index, encode_block(search, index, search.run_block(index, pool), store.mark)
