"""Pages say what the code says: generated tables, JSON keys, version, picture, the built site."""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import click
import pytest

import json_schema
from docs import examples
from docs.examples import script
from docs.test_redirects import PUBLISHED
from layerjam import __version__
from layerjam.brake.device.load import load as load_brake
from layerjam.cli.main import app, main
from layerjam.core.command.declare import load_command
from layerjam.core.command.index import commands
from layerjam.core.command.schema import schema
from layerjam.interop.html import make_html

ROOT = examples.ROOT
MEASURED = Path("out/demo/measurements")
INSTEAD = {
    "plan": "layerjam plan choi2018 choi2018-kapton --mass 1kg --speed 2.5m/s --warning 6s "
    "--travel 40mm --samples 1000",
    "scenario": "layerjam scenario slow-stop",
    "bench check": "layerjam bench check sim:choi2018?speed=0 --vent-rest open --line choi2018",
    "bench zero": "layerjam bench zero sim:choi2018?speed=0 --vent-rest open",
    "export fmu": "layerjam export fmu choi2018-kapton --out kapton.fmu --sources-only",
    "publish": "layerjam publish campaign --brake choi2018-kapton --out campaign-dataset",
    "recompute": f"layerjam recompute {ROOT}/tests/laboratory/dataset/published-0.1.0.zip",
}
"""What is run in place of a command's first example, for it takes less time or no C compiler."""
LONG = (
    *("publish", "recompute", "report", "build", "design", "sweep", "drop", "tune", "stick-slip"),
)
WITHOUT_JSON = {"workbench", "bench serve", "bench flash"}
ELSEWHERE = {"demo", "reproduce"}
"""Commands that run for long; their own tests call `compare_keys`."""
COMMANDS = {
    name: INSTEAD.get(name, entry.examples[0])
    for name, entry in commands().items()
    if name not in WITHOUT_JSON | ELSEWHERE
}
LINKS = {
    "friction-*.csv": "friction-kapton-*.csv",
    "pull-*.csv": "validation-kapton-*-7mms-1.csv",
    "validation-*.csv": "validation-kapton-*-19mms-1.csv",
}
"""Names of the examples: measured files that stand for them."""
OTHER_LINKS = {
    "my-brake-calibrated.toml": "my-brake.toml",
    "pump-down.csv": "line.csv",
    "silicone-1.csv": "sleeve.csv",
}


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with practice files."""
    folder = tmp_path_factory.mktemp("pages") / "reader"
    examples.practice_files(folder)
    page = (ROOT / "docs" / "measurements.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    with contextlib.chdir(folder):
        for block in (blocks[0], next(b for b in blocks if "ageing.toml" in b)):
            exec(block, {})
        for name, source in LINKS.items():
            for index, path in enumerate(sorted(MEASURED.glob(source)), 1):
                _link(Path(name.replace("*", str(index))), path)
        with contextlib.redirect_stdout(io.StringIO()):
            main(_typed(COMMANDS["bench run"]))
        Path("my-brake.toml").write_text(load_brake("choi2018-kapton").text, encoding="utf-8")
        for name, source in OTHER_LINKS.items():
            _link(Path(name), Path(source))
        Path("campaign").mkdir()
        for path in (*MEASURED.glob(LINKS["friction-*.csv"]), *MEASURED.glob(LINKS["pull-*.csv"])):
            shutil.copy(path, "campaign")
            shutil.copy(f"{path}.toml", "campaign")
        main(["records", "add", "pull-2.csv", "--db", "lab.db"])
    return folder


def _link(name: Path, source: Path) -> None:
    """A file under another name, with its sidecar."""
    for ending in ("", ".toml"):
        if Path(f"{source}{ending}").exists():
            Path(f"{name}{ending}").symlink_to(Path(f"{source}{ending}"))


def _overwriting(name: str) -> list[str]:
    """The flag to replace files, of a command that has it."""
    flags = [p for p in load_command(name).parameters if p.name == "overwrite"]
    return ["--overwrite"] if flags else []


def _typed(example: str) -> list[str]:
    """The words of an example as a shell hands them on."""
    made = []
    for word in shlex.split(example)[1:]:
        made += sorted(map(str, Path().glob(word))) if "*" in word else [word]
    return made


@pytest.fixture(scope="module")
def generate() -> ModuleType:
    """docs/generate.py."""
    return script(ROOT / "docs" / "generate.py")


def test_generated_tables_are_what_the_code_says(generate: ModuleType) -> None:
    pages = generate.pages()
    assert {p.name for p in pages} == {
        "nomenclature.md",
        "file-format.md",
        "models.md",
        "commands.md",
        "reference.md",
        "scpi.md",
        "hardware.md",
        "CONTRIBUTING.md",
        "README.md",
        "AGENTS.md",
        "llms.txt",
    }
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert text.count("<!-- generated: ") == text.count("<!-- end -->")
        assert generate.generated(text) == text, f"run docs/generate.py: {page.name} differs"


def test_texts_for_assistants_are_short_and_name_the_schema(generate: ModuleType) -> None:
    for path in (ROOT / "AGENTS.md", ROOT / "docs" / "llms.txt"):
        text = path.read_text(encoding="utf-8")
        assert len(text.splitlines()) < 200 and "layerjam schema" in text
        for link in re.findall(r"\]\(([^):#]+)", text):
            assert (path.parent / link).exists(), link
    assert all(f"`{name}`" in (ROOT / "AGENTS.md").read_text("utf-8") for name in commands())


DECISIONS = sorted((ROOT / "docs" / "decisions").glob("2*.md"))


@pytest.mark.parametrize("path", DECISIONS, ids=lambda p: p.stem)
def test_decision_has_a_status_its_form_and_links_that_lead_somewhere(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert re.match(r"# \w.+\n\nStatus: (holds|superseded|proposed)\b", text)
    heads = re.findall(r"^## (.+)", text, re.M)
    assert {heads[0], "Decision", heads[-1]} == {"Context", "Decision", "Consequences"}
    for link in re.findall(r"\]\(([^)#]+)", text):
        assert (path.parent / link).exists(), link
    if "windows" not in path.name:  # that one lists files by their names of that day
        for name in re.findall(r"`([a-z_]+/[\w/-]+\.(?:py|toml))`", text):
            assert any(
                (base / name).exists() for base in (ROOT, ROOT / "src", ROOT / "src/layerjam")
            ), name


def test_the_stub_is_what_the_commands_declare(generate: ModuleType) -> None:
    stub = generate.stub
    assert stub.STUB.read_text(encoding="utf-8") == stub.stub(), "run docs/generate.py"


def test_every_table_the_generator_makes_is_used(generate: ModuleType) -> None:
    used = {m for p in generate.pages() for m in re.findall(r"generated: (\w+) -->", p.read_text())}
    assert used == set(generate.PARTS)


def test_every_command_has_its_row() -> None:
    assert set(_rows()) == set(commands())
    there = set(app.list_commands(click.Context(app)))
    assert there == {name.split()[0] for name in commands()}, (
        "give the command its section in docs/commands.md"
    )


def _rows() -> dict[str, set[str]]:
    """{command: JSON keys} of the tables on the page."""
    text = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    found = {}
    for name in re.findall(r"<!-- generated: options_(\w+) -->", text):
        part = text.split(f"<!-- generated: options_{name} -->")[1].split("<!-- end -->")[0]
        listed = part.split("\nJSON: ")[1]
        found[load_command(name).name] = set(re.findall(r"`([^`]+)`", listed))
    return found


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in COMMANDS],
)
def test_json_has_the_keys_of_the_table(
    name: str, reader: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(reader)
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = main([*_typed(COMMANDS[name]), "--json", *_overwriting(name)])
    # that dataset was published when intervals were computed in another way: it differs
    assert code == (1 if name == "recompute" else 0)
    compare_keys(name, json.loads(said.getvalue()))


def compare_keys(name: str, printed: dict[str, Any]) -> None:
    """Compare the JSON that a command prints with its table in the docs and with its schema."""
    judged = {"verdict", "failed_checks", "accepted"} if "verdict" in printed else set()
    assert set(printed) == _rows()[name] | {"units", "warnings"} | judged
    assert json_schema.problems(printed, json.loads(schema(name).json())) == []


def test_the_quarter_of_an_hour_in_the_readme_uses_one_brake() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    walk = text[text.index("## Use it on the command line") :]
    typed = " ".join(b.text for b in examples.blocks(walk) if b.kind == "console")
    states = {"my-brake.toml", "my-brake-tested.toml", "my-brake-calibrated.toml"}
    assert {*re.findall(r"[\w-]+\.toml", typed)} == states
    # friction, bench run and publish name it, and the catalogue's brake is only copied
    brakes = re.findall(r"--brake (\S+)", typed)
    assert len(brakes) == 3 and {*brakes} <= states
    assert typed.count("choi2018-kapton") == 1


def test_functions_named_on_the_nomenclature_page_exist() -> None:
    import layerjam
    from layerjam.brake.mechanics import friction

    text = (ROOT / "docs" / "nomenclature.md").read_text(encoding="utf-8")
    part = text.split("## What is computed")[1].split("## Columns")[0]
    names = {n.split("(")[0] for row in re.findall(r"^\|.*", part, re.MULTILINE)
             for n in re.findall(r"`([\w().]+)`", row.split("|")[2])}  # fmt: skip
    plain = {"vacuum", "slip", "elongation", "force", "stiffness_measured", "mass", "speed"}
    plain |= {"gravity", "rope_stiffness", "spring"}
    assert len(names) > 25
    for name in names - plain:
        assert hasattr(layerjam, name) or hasattr(friction, name), name


def test_citation_has_the_version_and_the_paper() -> None:
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {__version__}\n" in text
    assert "10.1109/LRA.2017.2761938" in text
    assert (ROOT / "LICENSE").read_text().lstrip().startswith("Apache License")
    assert f"## {__version__}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_links_between_pages_lead_somewhere() -> None:
    for page in examples.pages():
        text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text("utf-8"), flags=re.DOTALL)
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built site; no warning passes --strict."""
    pytest.importorskip("mkdocs")
    out = tmp_path_factory.mktemp("site")
    run = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", out],
        check=False,
        cwd=ROOT,
        capture_output=True,
        text=True,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        timeout=120,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert "WARNING" not in run.stdout + run.stderr
    return out


@pytest.mark.slow
def test_site_asks_nothing_of_other_hosts(site: Path) -> None:
    loads = re.compile(
        r"<(?:script|img|iframe|source|video|audio)\b[^>]*\bsrc=\"?(?:https?:)?//"
        r"|<link\b(?![^>]*rel=\"?(?:canonical|next|prev))[^>]*href=\"?(?:https?:)?//"
    )
    pages = list(site.rglob("*.html"))
    assert len(pages) >= 10
    for page in pages:
        found = loads.search(page.read_text(encoding="utf-8"))
        assert found is None, f"{page.name}: {found.group(0) if found else ''}"
    for sheet in site.rglob("*.css"):
        assert not re.search(r"url\(\s*[\"']?(?:https?:)?//", sheet.read_text(encoding="utf-8"))
        assert not re.search(r"@import\s+[\"']?(?:url\()?[\"']?(?:https?:)?//", sheet.read_text())


@pytest.mark.slow
def test_search_works_where_the_site_is_opened_from_a_folder(site: Path) -> None:
    """A browser gives a page from a folder no worker and no index but as scripts."""
    assert (
        (site / "search" / "search_index.js").read_text(encoding="utf-8").startswith("var __index")
    )
    for page in ("index.html", "notebooks/labelled.html"):
        text = (site / page).read_text(encoding="utf-8")
        shim = re.search(r'<script src="([^"]*iframe-worker[^"]*)"', text)
        assert shim is not None and (site / page).parent.joinpath(shim.group(1)).exists(), page


@pytest.mark.slow
def test_the_first_page_opens_the_papers_brake_in_a_frame(site: Path) -> None:
    """The frame has no source until a reader opens it."""
    page = (site / "try-it.html").read_text(encoding="utf-8")
    assert page == make_html(load_brake("choi2018-kapton")) and len(page) < 150_000
    text = (site / "index.html").read_text(encoding="utf-8")
    frame = re.search(r'<details[^>]*ontoggle="([^"]*)".*?<iframe([^>]*)>', text, re.DOTALL)
    assert frame is not None and "src" not in frame[2] and "'try-it.html'" in frame[1]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert "export html choi2018-kapton" in readme


def test_the_first_screen_says_the_same_in_readme_and_docs() -> None:
    """One sentence, the moving picture, two lines to install, one command, three doors, limits."""
    readme, index = ((ROOT / p).read_text("utf-8") for p in ("README.md", "docs/index.md"))
    here = index[: index.index("**No hardware")]
    there = readme[: readme.index("**No hardware")]
    assert there.replace("docs/images/", "images/").replace("](docs/", "](") == here
    parts = ("`layerjam` is", "stop.svg)", "make demo", "$ layerjam tune", "safe vacuum",
             "Friction scatters", "- **Calculate",
             "- **Test", "- **Build")  # fmt: skip
    places = [here.index(part) for part in parts]
    assert places == sorted(places) and len(readme.split()) <= 1300


@pytest.mark.slow
def test_site_has_every_published_address(site: Path) -> None:
    for name in PUBLISHED:
        page = name.partition("#")[0].replace(".md", ".html")
        text = (site / page).read_text(encoding="utf-8")
        target = re.search(r'http-equiv="refresh" content="0; url=([^"#]+)(?:#([^"]+))?"', text)
        if target is not None:
            there = ((site / page).parent / target[1]).read_text(encoding="utf-8")
            section = name.partition("#")[2] or target[2]
            assert not section or re.search(f'id="?{re.escape(section)}["> ]', there), name


@pytest.mark.slow
def test_site_shows_every_equation(site: Path) -> None:
    """As MathML, and none in another way: the site finds those that the finder finds."""
    equations = script(ROOT / "docs" / "equations.py")
    for page in (ROOT / "docs").glob("*.md"):
        made = (site / f"{page.stem}.html").read_text(encoding="utf-8")
        assert "arithmatex" not in made, page.name
        wanted = list(equations.equations(page.read_text(encoding="utf-8")))
        assert made.count('display="block"') == sum(block for _, block in wanted), page.name
        pieces = [1 if block else len(equations.pieces(latex)) for latex, block in wanted]
        assert made.count("<math ") == sum(pieces), page.name


@pytest.mark.slow
def test_reference_shows_what_is_public(site: Path) -> None:
    import layerjam

    text = (site / "reference.html").read_text(encoding="utf-8")
    missing = [
        name
        for name in layerjam.__all__
        if not name.startswith("__")
        and not re.search(rf'id="layerjam\.[\w.]+\.{layerjam._EXPORTS[name][1]}"', text)
    ]
    assert not missing
