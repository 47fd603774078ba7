"""Imports run in one direction, and a light import stays light."""

from __future__ import annotations

import ast
import functools
import json
import os
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "layerjam"
MODULES = sorted(SOURCE.rglob("*.py"))
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
    "importlinter"
]["contracts"]
FLOORS = {
    contract["containers"][0]: [layer.split(" | ") for layer in reversed(contract["layers"])]
    for contract in CONTRACTS
    if contract["type"] == "layers"
}
"""{package: its layers from the lowest, each a list of parts}, as import-linter has them."""
CORE = ("device", "mechanics", "kernel", "simulate")
BUILDERS = ("ezdxf", "OCP", "manifold3d", "typst", "matplotlib")
HEAVY = ("jax", "numpy", "pandas", "pint", "click", "scipy", "matplotlib", "xarray", "tomlkit")


def name_of(path: Path) -> str:
    parts = path.relative_to(SOURCE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@functools.cache
def imports(path: Path, *, at_import: bool = False) -> set[str]:
    """Modules a file imports; with `at_import` only those that importing the file would load."""
    found: set[str] = set()

    def visit(node: ast.AST) -> None:
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: relative import"
            found.add(str(node.module))
            found.update(f"{node.module}.{alias.name}" for alias in node.names)
        inside = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        typing_only = isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        if at_import and (inside or typing_only):
            return
        for child in ast.iter_child_nodes(node):
            visit(child)

    visit(ast.parse(path.read_text(encoding="utf-8")))
    return found


def python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True, text=True, timeout=120, check=False, env={**os.environ, **environment},
    )  # fmt: skip


def test_the_contracts_of_import_linter_hold() -> None:
    command = [str(Path(sys.executable).parent / "lint-imports"), "--no-cache"]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{len(CONTRACTS)} kept, 0 broken" in done.stdout


def test_the_contracts_cover_the_wings() -> None:
    wings = [path.parent.name for path in SOURCE.glob("*/__init__.py")]
    divided = {name.removeprefix("layerjam.") for name in FLOORS} - {"layerjam"}
    assert divided == {"core", "brake", "laboratory", "bench", "workshop"}
    assert divided <= {*wings}
    assert len(wings) <= 16 and len(FLOORS["layerjam"]) <= 13


def upward(path: Path) -> Iterator[str]:
    """Sentences about the imports of a file from a higher floor."""
    own = name_of(path).split(".")
    if own in (["layerjam"], ["layerjam", "_version"]):
        named = {m for m in imports(path) if m.startswith("layerjam.")}
        for module in named - {"layerjam._version", "layerjam._version.__version__"}:
            yield f"{name_of(path)} imports {module}"
        return
    for module in imports(path):
        if module == "layerjam":
            yield f"{name_of(path)} imports the package's root"
        other = module.split(".")
        for package, floors in FLOORS.items():
            depth = len(package.split("."))
            if own[:depth] == other[:depth] == package.split(".") and len(own) > depth < len(other):
                height = {part: n for n, layer in enumerate(floors) for part in layer}
                here, there = height[own[depth]], height.get(other[depth], -1)
                if there >= here and own[depth] != other[depth]:
                    yield f"{name_of(path)} imports {module}"


def test_no_floor_imports_a_higher_one() -> None:
    """The same once more without import-linter, so that an emptied contract is noticed."""
    assert len(MODULES) > 600
    assert [line for path in MODULES for line in upward(path)] == []


def test_no_circle() -> None:
    names = {name_of(path) for path in MODULES}
    graph = {name_of(path): imports(path) & names - {name_of(path)} for path in MODULES}
    done: set[str] = set()

    def walk(name: str, trail: tuple[str, ...]) -> None:
        assert name not in trail, " -> ".join((*trail, name))
        if name in done:
            return
        for other in graph[name]:
            walk(other, (*trail, name))
        done.add(name)

    for name in graph:
        walk(name, ())
    assert done == names


LAWLESS = (
    ("rise", "choi2018", "--target", "60kPa"),
    ("regulate", "choi2018", "--target", "60kPa", "--safe-state", "release", "--sensor-range",
     "103kPa", "--duration", "20s", "--figure", "{folder}/a.svg"),
    ("bench", "run", "sim:choi2018?speed=0", "--procedure", "evacuate to 20 kPa; vent", "--brake",
     "choi2018-kapton", "--line", "choi2018", "--safe-state", "release", "--vent-rest", "open",
     "--sensor-range", "103kPa", "--out", "{folder}/a.ljrun"),
    ("parts",),
    ("records", "list", "--db", "{folder}/a.db"),
    ("leak", "{folder}/log.csv", "--volume", "120mL", "--reading", "gauge"),
    ("pump-down", "{folder}/rise.csv", "--volume", "120mL", "--reading", "gauge"),
    ("crash", "{folder}/crash.csv", "--range", "250 g"),
)  # fmt: skip
"""Commands that compute no law."""


def test_what_computes_no_law_loads_neither_jax_nor_pint(tmp_path: Path) -> None:
    """Its outcome does not matter, only that it does not end in a wrong option."""
    rows = [f"{0.1 * n:.1f},{-50 * 0.99**n:.3f}" for n in range(300)]
    (tmp_path / "log.csv").write_text("time [s],pressure [kPa]\n" + "\n".join(rows))
    rows = [f"{0.1 * n:.1f},{-90 * (1 - 0.98**n):.3f}" for n in range(300)]
    (tmp_path / "rise.csv").write_text("time [s],pressure [kPa]\n" + "\n".join(rows))
    rows = [f"{1e-4 * n:.4f},{200 * (0 < n - 900 < 300)}" for n in range(2000)]
    (tmp_path / "crash.csv").write_text("time [s],acceleration [m/s^2]\n" + "\n".join(rows))
    commands = [[word.format(folder=tmp_path) for word in command] for command in LAWLESS]
    done = python(
        "import sys; from layerjam.cli.main import main\n"
        f"for command in {commands}:\n"
        "    code = main(command)\n"
        "    print('LOADED', code, [n for n in ('jax', 'pint') if n in sys.modules])"
    )
    said = [line for line in done.stdout.splitlines() if line.startswith("LOADED")]
    assert len(said) == len(LAWLESS), done.stdout + done.stderr
    for command, line in zip(commands, said, strict=True):
        assert line in ("LOADED 0 []", "LOADED 4 []"), (command, done.stdout + done.stderr)


def test_the_core_neither_draws_nor_talks() -> None:
    loud = {"matplotlib", "click", "jinja2", "serial", "socket", "http", "urllib"}
    for path in (p for room in CORE for p in sorted((SOURCE / "brake" / room).rglob("*.py"))):
        assert not {module.split(".")[0] for module in imports(path)} & loud, path
        early = {m.split(".")[0] for m in imports(path, at_import=True)}
        assert not early & {"pandas", "xarray"}, path


def test_importing_the_package_loads_nothing_heavy_nor_does_help() -> None:
    heavy = {*HEAVY, *BUILDERS}
    code = f"""
import contextlib, io, sys
import layerjam
assert layerjam.__version__
print(*(name for name in {heavy!r} if name in sys.modules))
from layerjam.cli.main import main
with contextlib.redirect_stdout(io.StringIO()):
    assert main(["--help"]) == 0
print(*(name for name in {heavy - {"click"}!r} if name in sys.modules))
"""
    done = python(code)
    assert (done.returncode, done.stdout.split(), done.stderr) == (0, [], "")


@pytest.mark.parametrize("words", [("build", "--help"), ("show", "choi2018-kapton")], ids=" ".join)
def test_only_a_build_pays_for_what_it_writes_with(words: tuple[str, ...]) -> None:
    code = f"""
import contextlib, io, sys
from layerjam.cli.main import main
with contextlib.redirect_stdout(io.StringIO()):
    assert main({list(words)!r}) == 0
print(*(name for name in {BUILDERS!r} if name in sys.modules))
"""
    done = python(code)
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, "", "")


BLOCKED = """
import sys

class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {blocked!r}:
            raise ImportError("blocked: " + name)

sys.meta_path.insert(0, Block())
from layerjam.cli.main import main
"""
EXTRAS = ("matplotlib", "xarray", "jinja2", "schemdraw")


def without_extras(
    *commands: tuple[str, ...], blocked: tuple[str, ...] = EXTRAS
) -> list[tuple[int, str, str]]:
    """Return code, output and error output of some commands, all run in one process."""
    code = f"""
import contextlib, io, json

said = []
for words in {[list(words) for words in commands]!r}:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(words)
    said.append((code, out.getvalue(), err.getvalue()))
print(json.dumps(said))
"""
    done = python(BLOCKED.format(blocked=blocked) + code)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return [tuple(row) for row in json.loads(done.stdout)]


FORCE = ("force", "choi2018-kapton", "--slip", "20mm", "--vacuum", "94.5kPa")


def test_the_core_works_without_extras_and_pandas() -> None:
    [(code, out, err)] = without_extras((*FORCE, "--json"), blocked=(*EXTRAS, "pandas"))
    assert code == 0 and '"force": 133.9427' in out and err == ""


def test_show_knows_the_drawn_mass_without_what_build_needs() -> None:
    words = ("show", "choi2018-kapton", "--json")
    [(code, out, err)] = without_extras(words, blocked=BUILDERS)
    assert code == 0 and err == "" and '"drawn_mass": 0.0209057' in out


@pytest.mark.slow
def test_a_build_without_step_says_so_and_goes_on(tmp_path: Path) -> None:
    place = tmp_path / "made"
    words = ("build", "choi2018-kapton", "--out", str(place), "--json")
    [(code, out, err)] = without_extras(words, blocked=("OCP",))
    assert code == 0 and (place / "print" / "print.3mf").is_file()
    assert not (place / "cad").exists() and "cad/" not in json.loads(out)["files"]
    said = [w for w in json.loads(out)["warnings"] if "[step]" in w]
    assert len(said) == 1 and "Traceback" not in err


@pytest.mark.parametrize(
    "missing",
    [*(pytest.param(name, marks=pytest.mark.slow) for name in ("ezdxf", "manifold3d")), "typst"],
)
def test_a_build_without_its_libraries_writes_nothing(missing: str, tmp_path: Path) -> None:
    """The quick test of `manifold3d` is with those of a build."""
    words = ("build", "choi2018-kapton", "--out", str(tmp_path / "made"), "--json")
    [(code, out, err)] = without_extras(words, blocked=(missing,))
    assert code == 2 and out == "" and list(tmp_path.iterdir()) == []
    assert err.count("\n") == 1 and err.startswith("layerjam: ") and "[build]" in err


TENSILE = ("tensile", "choi2018-kapton", "--vacuum", "50kPa", "--speed", "1mm/s")
TENSILE += ("--elongation", "4mm")
WANTING = (
    ((*FORCE, "--figure", "{at}/x.svg"), "[figures]"),
    ((*TENSILE, "--out", "{at}/x.nc"), "[labelled]"),
    ((*TENSILE, "--out", "{at}/x.csv", "--figure", "{at}/x.svg"), "[figures]"),
    (("bench", "wiring", "pico", "--out", "{at}/x.svg"), "[bench]"),
)
REPORT = ((("reproduce", "--out", "{at}/folder"), "[report]"),)


@pytest.mark.parametrize(
    ("wanting", "blocked"),
    # the report needs figures too; without jinja2 alone it must not have begun to write
    [(WANTING, EXTRAS), (REPORT, ("jinja2",))],
    ids=["each extra", "reproduce"],
)
def test_a_missing_extra_is_one_sentence(
    wanting: tuple[tuple[tuple[str, ...], str], ...], blocked: tuple[str, ...], tmp_path: Path
) -> None:
    commands = [(*(word.format(at=tmp_path) for word in words), "--json") for words, _ in wanting]
    said = without_extras(*commands, blocked=blocked)
    for (code, out, err), (words, what) in zip(said, wanting, strict=True):
        assert code == 2 and out == "", words
        assert err.count("\n") == 1 and err.startswith("layerjam: ") and what in err, err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_to_xarray_without_xarray() -> None:
    code = (
        BLOCKED.format(blocked=("xarray",))
        + """
import jax
jax.config.update("jax_enable_x64", True)
import layerjam
record = layerjam.tensile("choi2018-kapton", vacuum=5e4, speed=1e-3, travel=4e-3).record
try:
    record.to_xarray()
except layerjam.LayerjamError as error:
    print(type(error).__name__, error)
"""
    )
    done = python(code)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("MissingExtraError") and "[labelled]" in done.stdout
