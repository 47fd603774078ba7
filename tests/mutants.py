"""Does a test notice when a law, a reader or a fit is changed? One random change at a time.

Every mutant is a copy of the package in a temporary folder; the working tree is never touched.
mutmut and cosmic-ray change files in place or fork a process that runs JAX threads; this does
neither. A change is tried with the quick tests of its folder.
A sample drawn by `--seed` changes with every edit of the source. mutants.json therefore keeps one,
drawn with seed 2018 on 28 November 2026, and the reason for each change that may survive.
Usage: python tests/mutants.py [--list] [--sample N] [--only memory,pull] [--seed S]
"""

from __future__ import annotations

import argparse
import ast
import collections
import difflib
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import Queue

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "layerjam"
FOLDERS = ("mechanics", "measure", "identify")
FILES = [p for folder in FOLDERS for p in sorted((SOURCE / folder).rglob("*.py"))]
LIST = ROOT / "tests" / "mutants.json"
PASS_MARK = 0.95
HISTORY = ("test_memory.py", "test_cycle.py", "test_strip.py")
ORDER = (
    "test_closed_forms.py",
    "test_calibration.py",
    "test_inverse.py",
    "test_law.py",
    "test_gradients.py",
)
OTHER = ("heat", "motion", "stack", "stack_batch", "stickslip", "stop", "tune")
"""Modules with tests of their own: run last for everything else, first for themselves."""
FURTHER = {
    "mechanics/stick_slip": ("simulate/test_stick_slip.py",),
    "mechanics/stop": ("simulate/test_drop_in_time.py", "simulate/test_speed_law.py"),
}
"""Tests of integrators of mechanics that stand with the simulation that calls them."""

SWAP = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
KEEP = {"minimum": (0, 1), "maximum": (0, 1), "where": (1, 2), "clip": (0,), "keep_if": (1,)}
KEEP |= {"safe_sqrt": (0,), "cbrt": (0,), "floor": (0,), "ceil": (0,), "abs": (0,), "roll": (0,)}


EQUIVALENT = {
    ("energy.py", "return (work)"): "negative slip or vacuum is NaN by safe_sqrt already",
    ("energy.py", "return keep_if(((slip >= 0) | (vacuum >= 0)), work)"): "as above",
    ("energy.py", "return (heat)"): "as above",
    ("energy.py", "return keep_if(((slip >= 0) | (vacuum >= 0)), heat)"): "as above",
    (
        "hysteresis.py",
        "slack=(state.force <= (1)) & (target < enclosure.slip),",
    ): "a force above zero means an elongation beyond the slip",
    (
        "hysteresis.py",
        "returns = (0.0) < memory.force - hold",
    ): "the root is clipped to the present slip, so that nothing moves",
    ("hysteresis.py", "returns = (trial) < memory.force - hold"): "as above",
    (
        "roots.py",
        "return jax.lax.stop_gradient(jax.lax.fori_loop((1), halvings, bisect, (low, high))[1])",
    ): "one halving more or less is below rounding",
    (
        "roots.py",
        "slope = jax.lax.stop_gradient((slope))",
    ): "a slope that does not rise belongs to an answer that is infinite",
    (
        "limits.py",
        "return keep_if(slip >= 0, jnp.where(slip == (1), 0.0, closing))",
    ): "at zero slip the halving ends at 1e-13 of the atmosphere, which is what zero means here",
    (
        "enclosure.py",
        "return jnp.where(root**2 < self.saturation, root**2, (linear))",
    ): "the linear branch is never negative where it is used",
    (
        "leak.py",
        "guess = np.log((3)) / max(float(t[int(np.argmax(half))]), span / len(t))",
    ): "where a fit begins: in a log that resolves the fall its rate changes by under a millionth",
    (
        "workbook.py",
        'f"unpacks to {size / 1e6:.0f} MB; at most {MAX_UNPACKED / (1000001.0):.0f} MB can be "',
    ): "250 000 000 bytes are 250 MB with either divisor, to the digits shown",
    (
        "pull.py",
        "above = above / (3) if side == -1 else above",
    ): "how a search proceeds: it ends within 1e-11 of the same static bound",
    (
        "laws.py",
        "slope = -jnp.sin(theta) / (root**2 * (room))",
    ): "where the step is discarded the bisection has ended just above zero, so nothing is NaN",
    (
        "slide.py",
        "sooner = jnp.minimum(jnp.where(stops, stop_at, h), (turn_at))",
    ): "without a turn the search for it ends at h; sooner would only shorten a step to repeat",
    (
        "slide.py",
        "growth = (0.9 * (case.tolerance / jnp.maximum(error, 1e-300)) ** 0.2)",
    ): "how fast the length of steps changes: each is still held to the tolerance and to 0.2/omega",
}
"""Mutants that compute the same numbers; they count neither as killed nor as survivors."""


@dataclass(frozen=True)
class Mutant:
    """One change of one file below SOURCE: the span that is replaced, and by what."""

    file: str
    line: int
    start: int
    end: int
    text: str

    def apply(self, source: str) -> str:
        raw = source.encode()
        return (raw[: self.start] + f"({self.text})".encode() + raw[self.end :]).decode()


def replacements(node: ast.AST) -> Iterator[ast.expr]:
    """What an expression may be changed into."""
    if isinstance(node, ast.BinOp) and type(node.op) in SWAP:
        yield ast.BinOp(node.left, SWAP[type(node.op)](), node.right)
    elif isinstance(node, ast.BoolOp):
        yield ast.BoolOp(SWAP[type(node.op)](), node.values)
    elif isinstance(node, ast.Compare) and type(node.ops[0]) in SWAP:
        ops = [SWAP[type(node.ops[0])](), *node.ops[1:]]
        yield ast.Compare(node.left, ops, node.comparators)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Invert | ast.Not):
        yield node.operand
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield ast.Constant(node.value + 1)
    elif isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ""
        name = node.func.id if isinstance(node.func, ast.Name) else name
        for place in KEEP.get(name, ()):
            if place < len(node.args):
                yield node.args[place]


def expressions(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes inside functions and module constants, without annotations."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "type_comment", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield child
                yield from expressions(child)


def fillers(tree: ast.AST) -> set[ast.AST]:
    """The 1.0 of `jnp.where(condition, value, 1.0)`: keeps a gradient finite, is never used."""
    calls = (n for n in ast.walk(tree) if isinstance(n, ast.Call) and len(n.args) == 3)
    last = (n.args[2] for n in calls if getattr(n.func, "attr", "") == "where")
    return {n for n in last if isinstance(n, ast.Constant) and n.value == 1.0}


def mutants_of(path: Path) -> Iterator[tuple[Mutant, str, str]]:
    """Yield each mutant of a file, its line, and that line changed; equivalent ones too."""
    source = path.read_text(encoding="utf-8")
    tree = ast.parse(source)
    unused, place = fillers(tree), path.relative_to(SOURCE).as_posix()
    starts, lines = [0], source.splitlines()
    for line in source.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    for node in expressions(tree):
        for new in replacements(node) if node not in unused else ():
            start = starts[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
            end = starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
            text = ast.unparse(ast.fix_missing_locations(new))
            mutant = Mutant(place, node.lineno, start, end, text)  # type: ignore[attr-defined]
            changed = mutant.apply(source).splitlines()[mutant.line - 1].strip()
            yield mutant, lines[mutant.line - 1].strip(), changed


def listed(entries: Sequence[dict[str, str]]) -> list[Mutant]:
    """Return the mutants of mutants.json that exist, in any file, and are not equivalent."""
    known: dict[tuple[str, str], list[Mutant]] = {}
    for path in FILES:
        for mutant, line, changed in mutants_of(path):
            if (path.name, changed) not in EQUIVALENT:
                known.setdefault((line, changed), []).append(mutant)
    picked: dict[Mutant, None] = {}
    for entry in entries:
        there = known.get((entry["line"], entry["changed"]), [])
        if not there:
            print(f"equivalent, or no longer in the source: {entry['file']}: {entry['changed']}")
            continue
        near = [m for m in there if m.file == entry["file"] and m not in picked]
        picked[(near or [m for m in there if m not in picked] or there)[0]] = None
    return list(picked)


def test_files(tests: Path, changed: str) -> list[str]:
    """Check values first, then what is nearest to the changed module, then the rest."""
    further = FURTHER.get(changed.rpartition("/")[0], ())
    return [*(str(tests / name) for name in further), *own_tests(tests, changed)]


def own_tests(tests: Path, changed: str) -> list[str]:
    """Return the tests in the changed folder, in order."""
    folder, changed = changed.split("/", maxsplit=1)[0], changed.rsplit("/", maxsplit=1)[-1]
    tests = tests / folder
    there = sorted(p.name for p in tests.glob("test_*.py"))
    if folder != "mechanics":
        words = set(Path(changed).stem.split("_"))
        there.sort(key=lambda name: not words & set(Path(name).stem.split("_")))
        return [str(tests / name) for name in there]
    near = HISTORY if changed in ("memory.py", "hysteresis.py") else ORDER
    far = ORDER if near is HISTORY else HISTORY
    stem = Path(changed).stem
    own = stem if stem in OTHER else stem.split("_")[0]
    first = [f"test_{own}.py"] if own in OTHER else []
    order = [*first, "test_values.py", *near, *far, *there]
    return [str(tests / name) for name in dict.fromkeys(order) if name in there]


def environment(home: Path, cache: Path) -> dict[str, str]:
    return os.environ | {
        "PYTHONPATH": str(home),
        "PYTHONDONTWRITEBYTECODE": "1",
        "JAX_PLATFORMS": "cpu",
        "JAX_COMPILATION_CACHE_DIR": str(cache),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
        "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
        "OMP_NUM_THREADS": "1",
        "XLA_FLAGS": f"--xla_cpu_multi_thread_eigen=false {os.environ.get('XLA_FLAGS', '')}",
    }


def run_tests(home: Path, cache: Path, changed: str, limit: float) -> tuple[str, str]:
    """Run the tests against the package in `home`: "passed", "failed" or "timeout", and output."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m"]
    command += ["not slow", "-o", "xfail_strict=false", "--tb=line"]
    place = home.parent
    try:
        run = subprocess.run(
            [*command, *test_files(place / "tests", changed)],
            cwd=place,
            env=environment(home, cache),
            capture_output=True,
            text=True,
            timeout=limit,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "timeout", ""
    return "failed" if run.returncode else "passed", run.stdout[-1500:]


def difference(mutant: Mutant, source: str) -> str:
    lines = difflib.unified_diff(
        source.splitlines(), mutant.apply(source).splitlines(), lineterm="", n=0
    )
    return "\n".join(line for line in lines if not line.startswith(("---", "+++", "@@")))


def survivor(mutant: Mutant, sources: dict[str, str]) -> str:
    where = f"src/layerjam/{mutant.file}:{mutant.line}"
    return f"\nsurvived: {where}\n{difference(mutant, sources[mutant.file])}\n"


class Farm:
    """Copies of package and tests as they are now; each package holds one mutant at a time."""

    def __init__(self, place: Path, workers: int, limit: float) -> None:
        self.limit = limit
        self.cache = place / "jax"
        ignore = shutil.ignore_patterns("__pycache__")
        for name in ("tests", "docs", "examples"):
            shutil.copytree(ROOT / name, place / name, ignore=ignore)
        shutil.copy(ROOT / "pyproject.toml", place)
        self.homes: Queue[Path] = Queue()
        self.sources = {p.relative_to(SOURCE).as_posix(): p.read_text("utf-8") for p in FILES}
        for number in range(workers):
            home = place / f"copy{number}"
            shutil.copytree(SOURCE, home / "layerjam", ignore=ignore)
            self.homes.put(home)

    def imported_from(self) -> str:
        home = self.homes.get()
        try:
            code = "import layerjam; print(layerjam.__file__)"
            env = environment(home, self.cache)
            out = subprocess.run(
                [sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True
            )
            return out.stdout.strip() if str(home) in out.stdout else ""
        finally:
            self.homes.put(home)

    def find_failure(self, folders: set[str]) -> str:
        """Output of the first folder whose tests fail without a mutant: they would kill each."""
        home = self.homes.get()
        try:
            for folder in sorted(folders):
                outcome, output = run_tests(home, self.cache, f"{folder}/pull.py", self.limit)
                if outcome != "passed":
                    return f"{folder}: {outcome}\n{output}"
            return ""
        finally:
            self.homes.put(home)

    def try_out(self, mutant: Mutant) -> str:
        home = self.homes.get()
        place = home / "layerjam" / mutant.file
        try:
            place.write_text(mutant.apply(self.sources[mutant.file]), encoding="utf-8")
            self.print_loops(home, mutant)
            return run_tests(home, self.cache, mutant.file, self.limit)[0]
        finally:
            place.write_text(self.sources[mutant.file], encoding="utf-8")
            self.print_loops(home, mutant)
            self.homes.put(home)

    def print_loops(self, home: Path, mutant: Mutant) -> None:
        """Print the loops of the stack again, because the compiled kernel has those in C."""
        if mutant.file.startswith("mechanics/stack/"):
            words = [sys.executable, str(Path(__file__).with_name("print_c.py"))]
            env = environment(home, self.cache)
            subprocess.run(words, env=env, capture_output=True, check=False)


def select(args: argparse.Namespace) -> list[Mutant]:
    names = args.only.split(",") if args.only else [path.stem for path in FILES]
    if args.list:
        picked = [m for m in listed(json.loads(LIST.read_text("utf-8"))) if stem(m) in names]
    else:
        picked = [
            mutant
            for path in FILES
            if path.stem in names
            for mutant, _, changed in mutants_of(path)
            if (path.name, changed) not in EQUIVALENT
        ]
    if args.sample and args.sample < len(picked):
        picked = random.Random(args.seed).sample(picked, args.sample)
    picked = sorted(picked, key=lambda m: (m.file, m.line, m.start))
    return [picked[int(i)] for i in args.pick.split(",")] if args.pick else picked[args.skip :]


def stem(mutant: Mutant) -> str:
    return Path(mutant.file).stem


def reasons(sources: dict[str, str]) -> Callable[[Mutant], str]:
    """Return a function that gives the reason why a mutant may survive, or ""."""
    chosen = {(e["line"], e["changed"]): e["reason"]
              for e in json.loads(LIST.read_text("utf-8")) if "reason" in e}  # fmt: skip

    def reason(mutant: Mutant) -> str:
        source = sources[mutant.file]
        line = source.splitlines()[mutant.line - 1].strip()
        changed = mutant.apply(source).splitlines()[mutant.line - 1].strip()
        return chosen.get((line, changed), "")

    return reason


def report(results: list[tuple[Mutant, str]], sources: dict[str, str], seconds: float) -> int:
    killed: collections.Counter[str] = collections.Counter()
    total: collections.Counter[str] = collections.Counter()
    for mutant, outcome in results:
        total[mutant.file] += 1
        killed[mutant.file] += outcome != "passed"
    print("\n")
    reason = reasons(sources)
    for mutant, outcome in results:
        if outcome == "passed":
            print(survivor(mutant, sources), reason(mutant) or "no reason is known", sep="")
    for name in sorted(total):
        print(f"{name:40} {killed[name]:4} of {total[name]:4} killed")
    share = sum(killed.values()) / max(1, len(results))
    late = sum(outcome == "timeout" for _, outcome in results)
    print(f"{sum(killed.values())} of {len(results)} mutants killed, {share:.1%}, {seconds:.0f} s")
    print(f"{late} of them by the limit of time")
    return 0 if share >= PASS_MARK else 1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--list", action="store_true", help="the changes of mutants.json")
    parser.add_argument("--sample", type=int, default=0, help="only N mutants, drawn at random")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="modules, e.g. memory,pull")
    parser.add_argument("--skip", type=int, default=0, help="leave the first N out")
    parser.add_argument("--pick", default="", help="only these numbers of the list, e.g. 3,17")
    parser.add_argument("--trust", action="store_true", help="no run without a mutant first")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--limit", type=float, default=900.0, help="seconds for one mutant")
    args = parser.parse_args()
    begun = time.monotonic()
    picked = select(args)
    with tempfile.TemporaryDirectory(prefix="layerjam-mutants-") as folder:
        farm = Farm(Path(folder), args.jobs, args.limit)
        if not farm.imported_from():
            print("the copy of the package is not the one that is imported")
            return 2
        folders = set() if args.trust else {m.file.split("/")[0] for m in picked}
        if failure := farm.find_failure(folders):
            print(f"the tests fail without any mutant in {failure}")
            return 2
        print(f"{len(picked)} mutants, baseline {time.monotonic() - begun:.0f} s", flush=True)

        def trial(mutant: Mutant) -> tuple[Mutant, str]:
            outcome = farm.try_out(mutant)
            marks = {"passed": survivor(mutant, farm.sources), "failed": ".", "timeout": "T"}
            print(marks[outcome], end="", flush=True)
            return mutant, outcome

        with ThreadPoolExecutor(args.jobs) as pool:
            results = list(pool.map(trial, picked))
        return report(results, farm.sources, time.monotonic() - begun)


if __name__ == "__main__":
    sys.exit(main())
