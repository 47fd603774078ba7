"""Write the tables of the docs and the stub from the code, so that they cannot drift.

    python docs/generate.py           rewrite docs/*.md and src/layerjam/__init__.pyi
    python docs/generate.py --check   exit 1 where a page differs from the code

A page marks such a part with `<!-- generated: NAME -->` and `<!-- end -->`; NAME is a function
here.
"""

from __future__ import annotations

import ast
import html
import re
import sys
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import fields
from functools import partial
from pathlib import Path

from layerjam.bench.rig.circuit import load_circuit
from layerjam.bench.rig.electronics import compute_margins
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import catalogue, load, materials
from layerjam.brake.mechanics.effects import BUILT_IN
from layerjam.brake.simulate.record import DropRecord, TensileRecord
from layerjam.brake.simulate.stick_slip import StickSlipRecord
from layerjam.core.command.declare import load_command
from layerjam.core.command.index import commands
from layerjam.core.toml_files.source import KINDS
from layerjam.core.toml_files.toml import parse_toml
from layerjam.core.units import quantities, show
from layerjam.laboratory.measure.sidecar import Facts

DOCS = Path(__file__).parent
ROOT = DOCS.parent
SOURCE = ROOT / "src" / "layerjam"
sys.path.insert(0, str(DOCS))  # a test runs this file from elsewhere
import stub  # noqa: E402
from assistants import command_list, decisions, page_list  # noqa: E402
from command_tables import command_table, described, shared_options  # noqa: E402
from markdown_tables import NOTHING, SHARED, bounds_of, row, table, unit  # noqa: E402
from scpi_headers import bounds, headers  # noqa: E402

PART = re.compile(r"(<!-- generated: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
GREEK = {"delta", "mu", "rho", "tau"}
TABLES = {
    "": "The brake itself, top of the file",
    "sheets": "[sheets]",
    "film": "[film]",
    "enclosure": "[enclosure]",
    "mount": "[mount]",
    "speed_law": "[speed_law], may be left out",
    "hyperelastic": "[hyperelastic], may be left out",
    "rope": "[rope], may be left out",
    "site": "[site], may be left out",
}


def symbol(text: str) -> str:
    """`mu_k` as an equation, μ with a subscript."""
    if not text:
        return ""
    base, _, low = text.partition("_")
    if not low and text[1:].isdigit():
        base, low = text[0], text[1:]
    base = f"\\{base}" if base in GREEK else base
    low = f"{{{low}}}" if low.isdigit() and len(low) > 1 else low
    low = f"\\text{{{low}}}" if low.isalpha() else low
    return f"${base}_{low}$" if low else f"${base}$"


def brake_fields() -> str:
    """Every quantity of a brake."""
    defaults = {}
    for place in fields(Brake):
        inner = place.metadata.get("record")
        for f in fields(inner) if inner else (place,):
            path = f"{place.name}.{f.name}" if inner else f.name
            defaults[path] = f.default
    groups: dict[str, list[str]] = {name: [] for name in TABLES}
    for path, spec, due in quantities(Brake):
        head, _, key = path.rpartition(".")
        default = defaults[path]
        unless = "" if due else NOTHING
        if not due and isinstance(default, int | float):
            unless = show(float(default), spec.unit, 6)
        groups[head].append(
            row(symbol(spec.symbol), f"`{key}`", unit(spec), spec.text,
                bounds_of(spec), unless)
        )  # fmt: skip
    head_row = ("symbol", "name in code and file", "SI unit", "meaning", "allowed", "default")
    return "\n\n".join(
        f"### {TABLES[name]}\n\n{table(head_row, rows)}" for name, rows in groups.items()
    )


def brake_effects() -> str:
    """The effects that a brake may state: their laws, and where they apply."""
    rows = []
    for effect in BUILT_IN:
        answers = ("yes" if answer else "no" for answer in (effect.in_kernel, effect.in_fmu))
        rejected = ", ".join(effect.rejected_by) or NOTHING
        rows.append(row(effect.title, effect.condition, effect.law, rejected, *answers))
    further = "[Other packages](file-format.md#effects-of-other-packages)"
    law = r"$\mu$ times a factor of vacuum, slip and speed"
    rows.append(row(further, "`[effects.NAME]`", law, NOTHING, "if the package says so", "no"))
    exports = ("C kernel, `export c`, `export mujoco`", "`export fmu`")
    return table(("effect", "stated by", "law", "rejected by", *exports), rows)


def sidecar_fields() -> str:
    """Fields that NAME.csv.toml may hold."""
    rows = []
    for place in fields(Facts):
        spec = place.metadata.get("quantity")
        if spec is None:
            kind = "true or false" if place.name == "synthetic" else "text"
            kind = "table" if place.metadata.get("table") else kind
            rows.append(row(f"`{place.name}`", kind, place.metadata["value"].text))
        else:
            kind = "whole number" if spec.whole else unit(spec)
            rows.append(row(f"`{place.name}`", kind, spec.text))
    return table(("key", "kind or unit", "meaning"), rows)


PULLS_AND_STOPS = (
    ("A pull", TensileRecord), ("A stop", DropRecord), ("A pull with stick–slip", StickSlipRecord)
)  # fmt: skip


def record_columns() -> str:
    """Columns of simulated pulls and stops."""
    parts = []
    for name, record in PULLS_AND_STOPS:
        rows = [
            row(f"`{f.name}`", unit(f.metadata["quantity"]), f.metadata["quantity"].text)
            for f in fields(record)
            if "quantity" in f.metadata
        ]
        parts.append(f"### {name}\n\n{table(('column', 'SI unit', 'meaning'), rows)}")
    return "\n\n".join(parts)


def source_kinds() -> str:
    """Values that `kind` may have."""
    return table(("kind", "meaning"), [row(f"`{k}`", text) for k, text in KINDS.items()])


def _entry(value: object) -> tuple[str, str]:
    """(value, where from) of one number of a material's file."""
    if not isinstance(value, dict):
        return str(value), ""
    words = [f"{value.get('kind', 'unstated')}: {value.get('source', '')}".rstrip(": ")]
    words += [f"{k}: {value[k]}" for k in ("spread", "conflict") if value.get(k)]
    said = value["value"]
    shown = ", ".join(map(str, said)) if isinstance(said, list) else str(said)
    return shown, html.escape("; ".join(words), quote=False)


def _materials(folder: str) -> Iterator[str]:
    """A table for each material; a source of three numbers and more has a number, listed last."""
    names = BrakeFile.fields
    head = "film." if folder == "films" else "enclosure."
    files = {name: parse_toml(text, name) for name, text in materials()[folder].items()}
    rows_of = {
        name: [(key, *_entry(value)) for key, value in tables.items() if head + key in names]
        for name, tables in files.items()
    }

    def source(number: str, words: str) -> str:
        return words.replace(f" {number}", "")  # a source that quotes the number is still the same

    counts = Counter(source(*cells) for rows in rows_of.values() for _, *cells in rows)
    often = [words for words, count in counts.items() if count >= SHARED]
    for name, rows in rows_of.items():
        shown = []
        for key, number, words in rows:
            same = source(number, words)
            told = f"({often.index(same) + 1})" if same in often else words
            shown.append(row(f"`{key}`", number, told))
        title = files[name].get("name", name)
        yield f"#### `{name}`: {title}\n\n{table(('key', 'value', 'where from'), shown)}"
    if often:
        yield table(("", "source"), [row(f"({i})", words) for i, words in enumerate(often, 1)])


def films() -> str:
    """The films of the catalogue."""
    return "\n\n".join(_materials("films"))


def silicones() -> str:
    """The silicones of the catalogue."""
    return "\n\n".join(_materials("silicones"))


def brakes() -> str:
    """The brakes of the catalogue."""
    rows = []
    for name in catalogue():
        file = load(name)
        cells = [f"`{name}`", file.title]
        for path, value, si in (
            ("film.static", file.brake.film.static, "1"),
            ("film.kinetic", file.brake.film.kinetic, "1"),
            ("scale_factor", file.brake.scale_factor, "1"),
            ("stiffness_measured", file.brake.stiffness_measured, "N/m"),
        ):
            kind = file.sources[path].kind if path in file.sources else ""
            cells.append(f"{show(value, si)} ({kind})" if kind else show(value, si))
        rows.append(row(*cells))
    head = ("name", "title", "static friction", "kinetic friction", "scale factor", "stiffness")
    return table(head, rows)


def command_quantities() -> str:
    """Units and bounds of quantities that commands take; their tables state the meanings."""
    found: set[tuple[str, str, str, str]] = set()
    for entry in commands().values():
        for p in load_command(entry.name).parameters:
            if p.spec is not None:
                found.add((symbol(p.spec.symbol), p.name, unit(p.spec), bounds_of(p.spec)))
    rows = [
        row(mark, f"`{name}`", si, allowed)
        for mark, name, si, allowed in sorted(found, key=lambda each: each[1:])
    ]
    return table(("symbol", "name", "SI unit", "allowed"), rows)


def command_functions() -> str:
    """A place in the reference for the function and the result of every command."""
    members: dict[str, list[str]] = {}
    for entry in commands().values():
        declared = load_command(entry.name)
        named = [*members.get(declared.module, ()), declared.python_name, declared.result.__name__]
        members[declared.module] = list(dict.fromkeys(named))
    return "\n\n".join(
        f"::: {module}\n    options:\n      members: [{', '.join(names)}]"
        for module, names in members.items()
    )


def scpi_headers() -> str:
    """Every header of the instrument, from the firmware's own table."""
    groups: dict[str, list[str]] = {}
    for one in headers():
        given = one.command if one.command is not None else one.query
        argument = ", ".join(bounds(param) for param in given or ())
        who = ", ".join(letter for letter in "SL" if letter in one.flags)
        groups.setdefault(one.group, []).append(
            row(f"`{one.shown}`", argument.replace("`", ""), who, one.note)
        )
    head = ("header", "parameters", "", "what it does")
    return "\n\n".join(f"### {name}\n\n{table(head, rows)}" for name, rows in groups.items())


def wiring_parts() -> str:
    """Parts to buy for a bench; a mark repeats the data sheet of the row above."""
    rows, above = [], ("", "")
    for p in load_circuit("pico").parts:
        told = (p.sheet, p.read)
        sheet, read = (
            "″" if now == before else now for now, before in zip(told, above, strict=True)
        )
        number = "<br>".join((p.number, *p.alternatives))
        rows.append(row(p.refs, p.name, number, sheet, p.ours, read))
        above = told
    return table(("", "part", "order number, any of", "data sheet", "here", "read there"), rows)


def electronics_margins() -> str:
    """The worst case of each quantity next to its limit."""
    rows = []
    for m in compute_margins(load_circuit("pico")):
        most = m.most < float("inf")
        limit = f"{'≤' if most else '≥'} {m.most if most else m.least:.3g} {m.unit}"
        rows.append(row(m.name, f"{m.value:.3g} {m.unit}", limit))
    return table(("quantity", "worst case", "limit"), rows)


def source_map() -> str:
    """The folders of the source in the order of the import contracts, with their first lines."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "importlinter"
    ]["contracts"]
    floors = {c["containers"][0]: c["layers"] for c in contracts if c["type"] == "layers"}

    def describe(name: str) -> str:
        place = SOURCE.joinpath(*name.split("."))
        path = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
        doc = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        return doc.split("\n\n")[0].replace("\n", " ")

    def shown(name: str) -> str:
        leaf = name.rpartition(".")[2]
        return f"`{leaf}/`" if SOURCE.joinpath(*name.split(".")).is_dir() else f"`{leaf}.py`"

    rows = []
    for layer in reversed(floors["layerjam"]):
        if layer.startswith("_"):
            continue
        rows.append(row(f"**{shown(layer)}**", describe(layer)))
        inner = [name for group in reversed(floors.get(f"layerjam.{layer}", []))
                 for name in group.split(" | ")]  # fmt: skip
        rows += [
            row(f"&nbsp;&nbsp;{shown(f'{layer}.{n}')}", describe(f"{layer}.{n}")) for n in inner
        ]
    return table(("folder or file", "content"), rows)


PARTS: dict[str, Callable[[], str]] = {
    f.__name__: f
    for f in (
        source_map,
        decisions,
        page_list,
        command_list,
        brake_fields,
        brake_effects,
        sidecar_fields,
        record_columns,
        source_kinds,
        films,
        silicones,
        brakes,
        command_table,
        shared_options,
        command_quantities,
        command_functions,
        scpi_headers,
        wiring_parts,
        electronics_margins,
    )
}
PARTS |= {
    f"options_{entry.python_name}": partial(described, name) for name, entry in commands().items()
}


def generated(text: str) -> str:
    """A page with its generated parts as the code gives them now."""
    return PART.sub(lambda m: f"{m.group(1)}{PARTS[m.group(2)]()}\n{m.group(3)}", text)


def pages() -> list[Path]:
    """Pages with generated parts."""
    places = [*sorted(DOCS.glob("*.md")), DOCS / "decisions" / "README.md"]
    places += [ROOT / "CONTRIBUTING.md", ROOT / "AGENTS.md", DOCS / "llms.txt"]
    return [p for p in places if PART.search(p.read_text(encoding="utf-8"))]


def main() -> int:
    """Write or check all pages and the stub."""
    differ = []
    for path in pages():
        old = path.read_text(encoding="utf-8")
        new = generated(old)
        if new != old:
            differ.append(path.name)
            if "--check" not in sys.argv:
                path.write_text(new, encoding="utf-8")
    text = stub.stub()
    if text != stub.STUB.read_text(encoding="utf-8"):
        differ.append(stub.STUB.name)
        if "--check" not in sys.argv:
            stub.STUB.write_text(text, encoding="utf-8")
    print(", ".join(differ) or "nothing", "differs" if "--check" in sys.argv else "rewritten")
    return 1 if differ and "--check" in sys.argv else 0


if __name__ == "__main__":
    sys.exit(main())
