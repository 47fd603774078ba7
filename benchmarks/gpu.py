"""Drops, force law and designs on a GPU: `python -m benchmarks.gpu` where JAX sees one.

Each as one array and in blocks, with the memory that its arrays move a second beside what a plain
copy moves there. It needs a JAX with CUDA (`pip install "jax[cuda12]"`); nothing else of
`make bench` does.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.comparators.drops import population
from benchmarks.impact import Method, from_stop, markdown, measure, plain_jit
from benchmarks.timing import median
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stop.exact import stop
from layerjam.workshop.design.merit import make_point, merits

COUNTS = (100_000, 1_000_000, 10_000_000)
BLOCKS = 10
OUT = Path("out/bench")
Law = Callable[..., Any]


@dataclass(frozen=True)
class Moved:
    """One law over arrays: seconds, and the bytes that its arrays in and out have."""

    name: str
    count: int
    blocks: int
    seconds: float
    bytes: int
    copied: float
    """Bytes a second that a plain copy of as many numbers moves, in and out counted."""

    @property
    def rate(self) -> float:
        """Bytes a second."""
        return self.bytes / self.seconds

    @property
    def share(self) -> float:
        """Of what the copy moves."""
        return self.rate / self.copied


def methods() -> list[Method]:
    """Our stop, jitted over arrays of growing length; the first is what ratios are to."""
    return [Method(f"layerjam stop, jit, {n:,}", n, plain_jit, from_stop, "ours") for n in COUNTS]


def gpus() -> list[jax.Device]:
    """The GPUs JAX sees."""
    try:
        return list(jax.devices("gpu"))
    except RuntimeError:
        return []


def laws(count: int) -> dict[str, tuple[Law, tuple[np.ndarray, ...]]]:
    """What is measured by its name: a function of arrays, and `count` of each."""
    random, brake = np.random.default_rng(2018), load("choi2018-kapton").brake
    drops, start = population(count), make_point(brake)

    def designs(width: Any, overlap: Any, vacuum: Any) -> Any:
        return merits(start._replace(width=width, overlap=overlap, vacuum=vacuum), brake)

    return {
        "drops": (
            lambda mass, speed, vacuum: stop(
                mass, speed, vacuum, drops.spring, drops.gravity, drops.brake
            ),
            (drops.mass, drops.speed, drops.vacuum),
        ),
        "force law": (
            lambda slip, vacuum: brake_force(slip, vacuum, brake),
            (random.uniform(0, 0.06, count), random.uniform(0, 94.5e3, count)),
        ),
        "designs": (
            designs,
            (
                random.uniform(0.01, 0.03, count),
                random.uniform(0.04, 0.08, count),
                random.uniform(40e3, 100e3, count),
            ),
        ),
    }


def moved(count: int) -> list[Moved]:
    """Every law over `count` cases, as one array and in blocks."""
    copied = 16 * count / _seconds(lambda a: a + 1.0, (np.zeros(count),), 1)
    rows = []
    for name, (law, arrays) in laws(count).items():
        shapes = jax.eval_shape(law, *arrays)
        long = [leaf for leaf in jax.tree.leaves(shapes) if leaf.shape == (count,)]
        size = sum(a.nbytes for a in arrays) + sum(a.size * a.dtype.itemsize for a in long)
        for blocks in (1, BLOCKS):
            rows.append(Moved(name, count, blocks, _seconds(law, arrays, blocks), size, copied))
    return rows


def _seconds(law: Law, arrays: Sequence[np.ndarray], blocks: int) -> float:
    """Median seconds of a law over arrays that lie on the device, in so many equal blocks."""
    run = jax.jit(law)
    pieces = [
        tuple(jnp.asarray(a) for a in piece)
        for piece in zip(*(np.split(a, blocks) for a in arrays), strict=True)
    ]
    return median(lambda: jax.block_until_ready([run(*piece) for piece in pieces]), 5)


def table(rows: Sequence[Moved]) -> str:
    """The rows as Markdown."""
    lines = [
        "| law | cases | blocks | ns a case | GB/s of its arrays | share of a plain copy |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row.name} | {row.count:,} | {row.blocks} | {row.seconds / row.count * 1e9:.3g} "
        f"| {row.rate / 1e9:.3g} | {row.share:.0%} |"
        for row in rows
    ]
    return "\n".join(lines)


def draw(rows: Sequence[Moved], where: str) -> Any:
    """The share of a plain copy, a bar each."""
    from layerjam.core.drawing import style

    with style.apply_style():
        figure, (axes,) = style.make_axes(width=7.2, height=1.3 + 0.36 * len(rows))
        names = [f"{row.name}, {row.count:,}, {_blocks(row.blocks)}" for row in rows]
        colors = [style.BLUE if row.blocks == 1 else style.ORANGE for row in rows]
        axes.barh(names, [100 * row.share for row in rows], color=colors)
        axes.invert_yaxis()
        axes.set_xlabel("memory moved, of what a plain copy moves [%]")
        axes.set_title(where)
    return figure


def _blocks(count: int) -> str:
    return "one array" if count == 1 else f"{count} blocks"


def main() -> int:
    """The tables and the picture, or one sentence where there is no GPU."""
    jax.config.update("jax_enable_x64", True)
    found = gpus()
    if not found:
        print("JAX sees no GPU here: nothing was measured.")
        return 0
    where = f"{found[0].device_kind}, JAX {jax.__version__}, double precision"
    print(where)
    with jax.default_device(found[0]):
        print(markdown(measure(methods())))
        rows = [row for count in COUNTS for row in moved(count)]
    print()
    print(table(rows))
    OUT.mkdir(parents=True, exist_ok=True)
    draw(rows, where).savefig(OUT / "gpu.svg", metadata={"Date": None})
    print(f"picture: {OUT / 'gpu.svg'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
