"""The page of `layerjam export html` for the paper's brake; a hook of mkdocs.

`index.md` shows it in a frame that loads when a reader opens it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from layerjam.brake.device.load import load
from layerjam.interop.html import make_html

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

NAME = "try-it.html"


def on_files(files: Files, config: MkDocsConfig, **_of: object) -> Files:
    """Add the brake's page to the files of the site; mkdocs calls this."""
    from mkdocs.structure.files import File

    files.append(File.generated(config, NAME, content=make_html(load("choi2018-kapton"))))
    return files
