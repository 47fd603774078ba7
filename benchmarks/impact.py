"""Drop tests: ours beside what a user would pick instead, on the same random drops, in one run.

`report` measures and gives the table as Markdown, and draws it. A method is one line in `ours`,
`compiled_c` or `neighbours`.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks import scaling
from benchmarks.comparators import compiled, reference
from benchmarks.comparators.drops import Answer, Drops, population

ROUNDS, MANY = 5, 4_000_000
JUDGED = 20_000
"""Drops, at most, by which a method's accuracy is judged."""
ACCURACIES = {1e-6: "1 µm", 1e-8: "10 nm"}
JUDGED_AT = 1e-8
"""Accuracy at which a neighbour is judged; ours is exact to rounding."""


@dataclass(frozen=True)
class Method:
    """One way to solve drops."""

    name: str
    count: int
    """Drops a call."""
    prepare: Callable[[Drops], Callable[[], Any]]
    """From drops to the call that is timed; it blocks until its arrays are there."""
    answer: Callable[[Any], Answer | Any] = lambda raw: raw
    """From what the call gives to an Answer, or to the travel alone; not timed."""
    kind: str = "neighbour"
    """ours, C or neighbour."""
    wanted: float | None = None
    """What we want: at least this many times our time."""


@dataclass(frozen=True)
class Measured:
    """A method's median and its errors against the reference."""

    method: Method
    seconds: float
    """Per drop."""
    median_error: float
    """Of the travel [m], over the drops that stop within it."""
    worst_error: float
    """Of the travel [m], over all drops."""
    peak_error: float | None
    """The worst [N]; None where a method gives no peak."""


def ours() -> list[Method]:
    """Our ways; the first is what all others are compared with."""
    return [
        Method("layerjam batch", MANY, in_batches, from_stop, "ours"),
        Method("layerjam stop, plain jit", 10_000, plain_jit, from_stop, "ours"),
    ]


def compiled_c() -> list[Method]:
    """The same algorithms in C; empty where there is no compiler."""
    if compiler_missing():
        return []
    return [
        Method("C, stop", MANY, compiled.prepare, _first_two, "C", wanted=1.0),
        Method(
            "C, stop, vector code (-fno-math-errno -fno-trapping-math)",
            MANY,
            lambda drops: compiled.prepare(drops, compiled.VECTOR),
            _first_two,
            "C",
            wanted=1.0,
        ),
    ]


def neighbours() -> list[Method]:
    """What a user would pick instead. Raises ImportError where one is not installed."""
    from benchmarks.comparators import diffrax_drop, mujoco_drop, scipy_drop

    found = []
    for accuracy, words in ACCURACIES.items():
        rtol = diffrax_drop.TOLERANCE[accuracy]
        found.append(Method(
            f"diffrax Tsit5, vmap, {words}", 2000,
            lambda drops, rtol=rtol: diffrax_drop.prepare(drops, rtol),
            wanted=1e3 if accuracy == JUDGED_AT else None,
        ))  # fmt: skip
        for name, want in (("LSODA", 1e5 if accuracy == JUDGED_AT else None), ("DOP853", None)):
            rtol = scipy_drop.TOLERANCE[name][accuracy]
            found.append(Method(
                f"SciPy {name}, {words}", 200,
                lambda drops, name=name, rtol=rtol: scipy_drop.prepare(drops, name, rtol),
                wanted=want,
            ))  # fmt: skip
    step = f"{mujoco_drop.STEP * 1e6:g} µs"
    found.append(Method(f"MuJoCo, step {step}", 50, mujoco_drop.prepare))
    return found


def compiler_missing() -> str:
    """Why the C rows are left out; empty where they are not."""
    return (
        "" if compiled.compiler() else "There is no C compiler (cc) here: the C rows are missing."
    )


def plain_jit(drops: Drops) -> Callable[[], Any]:
    """`layerjam.stop` on arrays, as it stands."""
    from layerjam.brake.mechanics.stop.exact import stop

    arrays = [jnp.asarray(a) for a in (drops.mass, drops.speed, drops.vacuum)]
    fixed = drops.spring, drops.gravity, drops.brake
    return lambda: jax.block_until_ready(stop(*arrays, *fixed))


def in_batches(drops: Drops) -> Callable[[], Any]:
    """`layerjam.batch` over drops with one axis, all six answers into arrays made once, as C."""
    from layerjam.brake.mechanics.stop.exact import Stop, stop
    from layerjam.brake.simulate.batch import batch

    sweep = {
        "mass": ("drop", drops.mass), "speed": ("drop", drops.speed),
        "vacuum": ("drop", drops.vacuum), "spring": drops.spring, "gravity": drops.gravity,
    }  # fmt: skip
    kept = {name: np.empty(len(drops)) for name in Stop._fields}

    def run() -> Stop:
        batch(stop, sweep, brake=drops.brake, out=kept)
        return Stop(**kept)

    return run


def from_stop(raw: Any) -> Answer:
    """Travel and peak force of our Stop."""
    return Answer(np.asarray(raw.slip), np.asarray(raw.peak_force))


def _first_two(raw: Any) -> Answer:
    return Answer(raw[0].copy(), raw[1].copy())


def measure(methods: Sequence[Method], rounds: int = ROUNDS) -> list[Measured]:
    """Medians over rounds in which every method runs once, after one uncounted call of each."""
    drops = population(max(m.count for m in methods))
    judged = drops.first(min(JUDGED, len(drops)))
    right = reference.solve(judged)
    calls = [m.prepare(drops.first(m.count)) for m in methods]
    errors = [
        _errors(judged.first(m.count), m.answer(call()), right)
        for m, call in zip(methods, calls, strict=True)
    ]
    times = np.zeros((rounds, len(methods)))
    for row in times:
        for i, call in enumerate(calls):
            start = time.perf_counter()
            call()
            row[i] = time.perf_counter() - start
    each = np.median(times, axis=0) / [m.count for m in methods]
    return [Measured(m, float(t), *e) for m, t, e in zip(methods, each, errors, strict=True)]


def _errors(drops: Drops, raw: Any, right: Answer) -> tuple[float, float, float | None]:
    """Median and worst error of the travel, worst of the peak force where it is given."""
    n = len(drops)
    travel = np.asarray(raw.travel if isinstance(raw, Answer) else raw)[:n]
    off = np.abs(travel - right.travel[:n])
    stops = right.travel[:n] < drops.travel
    peak = None
    if isinstance(raw, Answer):
        peak = float(np.abs(np.asarray(raw.peak)[:n] - right.peak[:n]).max())
    return float(np.median(off[stops])), float(off.max()), peak


def per_drop(seconds: float) -> str:
    """Three digits and the unit that suits."""
    for unit, factor in (("ns", 1e9), ("µs", 1e6), ("ms", 1e3)):
        if seconds * factor < 1000:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds:.3g} s"


def distance(metres: float) -> str:
    """How far off: one digit and the unit that suits; below a picometre it is rounding."""
    for unit, factor in (("mm", 1e3), ("µm", 1e6), ("nm", 1e9), ("pm", 1e12)):
        if metres * factor >= 0.95:
            return f"{float(f'{metres * factor:.1g}'):g} {unit} off"
    return "exact to rounding"


def markdown(rows: Sequence[Measured]) -> str:
    """The table; ratios are to the first row."""
    base = rows[0].seconds
    head = ("method", "drops a call", "travel error, median / worst [m]", "peak error, worst [N]",
            "time a drop", "times ours", "wanted")  # fmt: skip
    lines = ["| " + " | ".join(head) + " |", "|---|---:|---:|---:|---:|---:|---|"]
    for row in rows:
        ratio, want = row.seconds / base, row.method.wanted
        goal = ""
        if want is not None:
            goal = f"at least {want:,g}: {'met' if ratio >= want else 'MISSED'}"
        cells = (
            row.method.name,
            f"{row.method.count:,}",
            f"{row.median_error:.0e} / {row.worst_error:.0e}",
            "" if row.peak_error is None else f"{row.peak_error:.0e}",
            per_drop(row.seconds),
            f"{ratio:,.3g}" if ratio < 1000 else f"{ratio:,.0f}",
            goal,
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def machine() -> str:
    """Processor and cores."""
    name = platform.processor() or platform.machine()
    if (info := Path("/proc/cpuinfo")).exists():
        models = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        name = models[0].split(":")[1].strip() if models else name
    return f"{name}, {compiled.cores()} of {os.cpu_count()} cores"


def draw(rows: Sequence[Measured], where: str) -> Any:
    """Time a drop on a logarithmic axis, slowest at the top, with its accuracy beside it."""
    from layerjam.core.drawing import style

    rows = sorted(rows, key=lambda row: row.seconds)
    colors = {"ours": style.BLUE, "C": style.ORANGE, "neighbour": style.FAINT}
    with style.apply_style():
        figure, (axes,) = style.make_axes(width=8.2, height=1.3 + 0.36 * len(rows))
        low = 10 ** np.floor(np.log10(rows[0].seconds) - 0.3)
        high = rows[-1].seconds
        for i, row in enumerate(rows):
            mine = row.method.kind == "ours"
            axes.barh(i, row.seconds - low, left=low, height=0.68, color=colors[row.method.kind])
            words = f"{per_drop(row.seconds)}, {distance(row.worst_error)}"
            axes.text(
                row.seconds * 1.12, i, words, va="center", fontsize=8.8,
                fontweight="bold" if mine else "normal", color=style.BLUE if mine else style.INK,
            )  # fmt: skip
        axes.set_yticks(range(len(rows)), [row.method.name for row in rows])
        for tick, row in zip(axes.get_yticklabels(), rows, strict=True):
            if row.method.kind == "ours":
                tick.set(fontweight="bold", color=style.BLUE)
        axes.tick_params(axis="y", length=0)
        axes.grid(visible=False, axis="y")
        axes.set(xscale="log", xlim=(low, high * 40), xlabel="time a drop")
        axes.xaxis.set_major_formatter(lambda x, _: per_drop(x))
        style.add_title(axes, "Drop tests: time a drop, and the worst error of its travel", where)
    return figure


def report(folder: Path) -> str:
    """Measure, write drops.svg and drops.png into `folder`, and give the table as Markdown."""
    from layerjam.core.drawing import style

    notes = [compiler_missing()]
    try:
        others = neighbours()
    except ImportError as error:
        others = []
        notes.append(
            f"{error.name} is not installed: the neighbours are missing; use `make bench`."
        )
    rows = measure(ours() + compiled_c() + others)
    folder.mkdir(parents=True, exist_ok=True)
    figure = draw(rows, f"medians of {ROUNDS} rounds in one run; {machine()}")
    for ending in ("svg", "png"):
        style.save(figure, folder / f"drops.{ending}", overwrite=True)
    notes.append(f"Picture: {folder / 'drops.svg'}")
    return "\n".join([markdown(rows), "", *filter(None, notes), "", *scaling.report()])
