r"""The equations of the docs as MathML, made while the site is built; a hook of mkdocs.

A page holds LaTeX, `$c (L_2 - x)$` in a line or `$$...$$` in a paragraph of its own, which GitHub
typesets as well. The browser gets MathML: no script, nothing from outside. The build stops at LaTeX
that the converter does not know or that GitHub would read as Markdown.

    python docs/equations.py       every equation of README and docs, or the first that fails
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from latex2mathml.converter import convert

DOCS = Path(__file__).parent
FENCED = re.compile(r"^```.*?^```[ ]*$|`[^`\n]*`", re.MULTILINE | re.DOTALL)
EQUATION = re.compile(
    r"(?<![\\$])\$\$\s*(?P<block>.+?)\s*\$\$|(?<![\\$\w])\$(?=\S)(?P<line>[^$\n]+?)(?<=\S)\$(?![\w$])",
    re.DOTALL,
)
PLACED = re.compile(
    r'(?P<before>\(?)<(?P<tag>span|div) class="arithmatex">\\(?:\(|\[)(?P<latex>.*?)'
    r"\\(?:\)|\])</(?P=tag)>(?P<after>[),.;:’′]*)",
    re.DOTALL,
)
MARKDOWN = re.compile(r"\\[^a-zA-Z]|\*|<|>(?=\S*>)")
"""Characters that Markdown changes before GitHub's typesetter reads them."""
UPRIGHT = re.compile(r"\\mathrm\b\s*(?=\{)")
"""The converter sets single upright letters in italics; as text they stay upright."""
LONG = 24
"""Characters of LaTeX from which an equation within a line may be broken."""
CLOSE = '<mo lspace="0" rspace="0" stretchy="false">{}</mo>'
THIN = '<mspace width="0.17em"/>'
FUNCTION = re.compile(
    r"(?P<before></mo>|<mrow>)?(?<!<msub>)<m[io]>(?P<name>ln|exp|erf|log|min|max)</m[io]>"
)
BASE = re.compile(r"<msub>(?=<m[io]>log</m[io]>)")
PRIME = re.compile(r"<msup>(<mi>[^<]*</mi>)<mi>&#x02032;</mi></msup>")
INTEGRAL = re.compile(r"(<msubsup><mo>&#x0222B;</mo><mn>0</mn>)(<mi>[^<]*</mi>|<mn>[^<]*</mn>)")


class EquationError(ValueError):
    """An equation that cannot be typeset."""


def mathml(latex: str, *, block: bool = False) -> str:
    """One equation as a MathML element."""
    plain = latex.strip()
    odd = MARKDOWN.search(plain)
    if odd is not None:
        raise EquationError(f"{odd.group(0)!r} means something else in Markdown: {plain}")
    if plain.count("{") != plain.count("}"):
        raise EquationError(f"a brace is missing: {plain}")
    try:
        made = convert(UPRIGHT.sub(r"\\text", plain), display="block" if block else "inline")
        tree = ElementTree.fromstring(made)
    except Exception as error:  # the converter has a class for every mistake
        raise EquationError(f"not LaTeX ({error!r}): {plain}") from error
    for part in tree.iter():
        if "\\" in (part.text or "") or part.text in {"&", "$"}:
            raise EquationError(f"{part.text} is not known: {plain}")
    return spaced(made)


def spaced(made: str) -> str:
    """The MathML with the spaces that TeX sets by itself."""

    def function(found: re.Match[str]) -> str:
        before = found["before"] or THIN
        return f"{before}<mi>{found['name']}</mi>{THIN}"

    made = FUNCTION.sub(function, made).replace(f"{THIN}<mo stretchy", "<mo stretchy")
    made = BASE.sub(f"{THIN}<msub>", made)
    made = PRIME.sub(rf"<mrow>\1{CLOSE.format('&#x02032;')}</mrow>", made)
    made = INTEGRAL.sub(r'\1<mrow><mspace width="0.4em"/>\2</mrow>', made)
    for operator in ("&#x0002F;", "&#x0007C;"):  # a slash and bars are close to their neighbours
        made = made.replace(f"<mo>{operator}</mo>", CLOSE.format(operator))
    return made


def pieces(latex: str) -> list[str]:
    """A long equation of a line, cut after its relations and sums, where TeX may break it too."""
    if len(latex) <= LONG:
        return [latex]
    found, start, depth = [], 0, 0
    for one in re.finditer(r"\\left|\\right|[{}()]|(?<= )(?:=|\+|-|\\le|\\ge)(?= )", latex):
        if one.group(0) in {"\\left", "{", "("}:
            depth += 1
        elif one.group(0) in {"\\right", "}", ")"}:
            depth -= 1
        elif depth == 0:
            found.append(latex[start : one.end()])
            start = one.end()
    return [*found, latex[start:]]


def equations(text: str) -> Iterator[tuple[str, bool]]:
    """(LaTeX, in a paragraph of its own) of every equation of a Markdown page."""
    for found in EQUATION.finditer(FENCED.sub("", text)):
        yield found["block"] or found["line"], found["block"] is not None


def typeset(page: str) -> str:
    """A page's HTML with its equations as MathML."""

    def one(found: re.Match[str]) -> str:
        latex = html.unescape(found["latex"])
        if found["tag"] == "div":
            return f'<div class="equation">{mathml(latex, block=True)}</div>'
        mathml(latex)  # sound as a whole
        parts = [mathml(piece) for piece in pieces(latex)]
        parts[0] = found["before"] + parts[0]
        parts[-1] += found["after"]
        return "<wbr>".join(f'<span class="kept">{part}</span>' for part in parts)

    return PLACED.sub(one, page)


def on_page_content(content: str, **_of: object) -> str:
    """Return the HTML of a page with its equations; mkdocs calls this for every page."""
    return typeset(content)


def main() -> None:
    """Convert all of them."""
    count = 0
    for path in [DOCS.parent / "README.md", *sorted(DOCS.rglob("*.md"))]:
        for latex, block in equations(path.read_text(encoding="utf-8")):
            try:
                mathml(latex, block=block)
            except EquationError as error:
                raise SystemExit(f"{path.name}: {error}") from error
            count += 1
    print(f"{count} equations")


if __name__ == "__main__":
    main()
