"""`sweep`: a specification's designs on disk, in blocks that a stop does not lose."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from layerjam.commands.answer import Answer
from layerjam.commands.design import UNITS, answer, cannot
from layerjam.design.blocks import NOTE, Store, encoded
from layerjam.design.bounds import impossible
from layerjam.design.requirements import DesignSpecification
from layerjam.design.search import BLOCK, Search
from layerjam.design.specification import load_spec
from layerjam.mechanics.threads import Workers

KEYS = ("out", "complete", "blocks", "blocks_done", "blocks_found", "bytes")


def sweep(
    spec: str | Path | DesignSpecification,
    *,
    out: str | Path,
    scheduler: str | None = None,
    block: int = BLOCK,
    progress: Callable[[str, float], None] | None = None,
) -> Answer:
    """Every design of a specification, block by block into a folder; then as `design`.

    The folder is new, empty or that of the same sweep, which then goes on: `blocks_found` of its
    blocks were there already. `block` is the number of designs in one, `scheduler` the address of a
    Dask cluster. Stopped from the keyboard, `complete` is False and the same call goes on. Raises
    FileError for a folder of something else, MissingExtraError without pyarrow or Dask, and
    ClusterError.
    """
    asked = spec if isinstance(spec, DesignSpecification) else load_spec(spec)
    search = Search(asked, block)
    killed = impossible(search)
    if killed is not None:
        made = cannot(search, None, killed)
        return _with(made, str(out), False, search.blocks(), 0, 0, 0)
    total = search.blocks()
    if scheduler is not None and not (Path(out) / NOTE).exists():
        from layerjam.design.cluster import reach

        reach(scheduler)
    with Store(out, search) as store:
        todo = store.missing(total)
        found_there = total - len(todo)
        done = found_there
        try:
            made_blocks = _here(search, todo, store) if scheduler is None else _there(
                search, todo, scheduler
            )  # fmt: skip
            for index, data in made_blocks:
                store.put(index, data)
                done += 1
                if progress is not None:
                    progress("designs", done / total)
        except KeyboardInterrupt:
            return _stopped(search, store, total, found_there)
        found = store.finish(search, total)
        made = answer(search, found)
        return _with(made, str(out), True, total, total, found_there, store.bytes())


def _here(search: Search, todo: list[int], store: Store) -> Iterator[tuple[int, bytes]]:
    with Workers() as pool:
        for index in todo:
            yield index, encoded(search, index, search.block(index, pool), store.mark)


def _there(search: Search, todo: list[int], scheduler: str) -> Iterator[tuple[int, bytes]]:
    if not todo:
        return iter(())
    from layerjam.design.cluster import spread

    return spread(search, todo, scheduler)


def _stopped(search: Search, store: Store, total: int, found_there: int) -> Answer:
    done = total - len(store.missing(total))
    values = dict.fromkeys(
        ("name", "feasible", "reason", "designs", "examined", "feasible_designs", "killed_by",
         "reachable", "excludes", "chosen", "refined", "runner_up", "runner_up_lost", "binding",
         "forbidden", "front_size", "front", "sensitivities", "robustness")
    )  # fmt: skip
    values |= {"name": search.spec.name, "designs": search.spec.grid.size}  # type: ignore[dict-item]
    made = Answer(
        values=values, units=UNITS,
        warnings=[f"stopped: {done} of {total} blocks are done; the same command goes on"],
    )  # fmt: skip
    return _with(made, str(store.folder), False, total, done, found_there, store.bytes())


def _with(
    made: Answer, out: str, complete: bool, blocks: int, done: int, found: int, size: int
) -> Answer:
    more = dict(zip(KEYS, (out, complete, blocks, done, found, size), strict=True))
    return Answer(
        values={**made.values, **more}, units={**made.units, "bytes": "B"},
        warnings=made.warnings, record=made.record,
    )  # fmt: skip
