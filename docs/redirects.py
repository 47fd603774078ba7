"""Pages at the addresses of pages that were merged into others; a hook of mkdocs.

`extra.moved` of mkdocs.yml names, for each old page, its new page and section. A link to a section
of the old page keeps its section: merged pages keep their headings.
"""

from __future__ import annotations

import posixpath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>This page has moved</title>
<meta name="robots" content="noindex">
<script>location.replace("{page}" + (location.hash || "{section}"))</script>
<meta http-equiv="refresh" content="0; url={page}{section}">
</head>
<body><p>This page has moved to <a href="{page}{section}">{page}</a>.</p></body>
</html>
"""


def address(file: str) -> str:
    """The address of a Markdown page on the site."""
    return f"{file.removesuffix('.md')}.html"


def redirect(old: str, new: str) -> str:
    """The page at the address of `old`, which leads to `new`: a page, or a page and a section."""
    file, mark, section = new.partition("#")
    target = posixpath.relpath(address(file), posixpath.dirname(old) or ".")
    return PAGE.format(page=target, section=mark + section)


def on_files(files: Files, config: MkDocsConfig, **_of: object) -> Files:
    """Add a page for each old address; mkdocs calls this with the files of the site."""
    from mkdocs.structure.files import File

    for old, new in config.extra.get("moved", {}).items():
        files.append(File.generated(config, address(old), content=redirect(old, new)))
    return files
