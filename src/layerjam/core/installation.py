"""Kind of this installation, and the command that adds an optional package to it."""

import sys
from pathlib import Path
from typing import Any

NAME = "layerjam"


CHECKOUT = Path(__file__).parents[3]
"""Folder of the checkout whose files run; of an installed package, a folder without a project."""


def install_command(extra: str = "") -> str:
    """Return the command that installs layerjam, or adds an extra to this installation.

    It names the checkout, folder or wheel that layerjam runs from, or the package in an index.
    """
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    target, options = NAME, ""
    if (CHECKOUT / "pyproject.toml").is_file():
        target, options = str(CHECKOUT), "-e "
    else:
        url = str(_read_source().get("url", ""))
        path = Path(url2pathname(urlsplit(url).path))
        if url.startswith("file:") and path.exists():
            target = str(path)
    # use double quotes, because the Windows shell accepts no others
    return f'{_find_installer()} {options}"{target}{extra and f"[{extra}]"}"'


def _read_source() -> dict[str, Any]:
    """Return the record that pip keeps of an installation from a folder, a wheel or an address."""
    import importlib.metadata
    import json

    try:
        package = importlib.metadata.distribution(NAME)
        text = package.read_text("direct_url.json")
        data: dict[str, Any] = json.loads(text or "{}")
    except (importlib.metadata.PackageNotFoundError, ValueError):
        return {}
    return data


def _find_installer() -> str:
    """Return the words that install into this environment."""
    import importlib.util
    import shutil
    import sysconfig

    folder = Path(sys.executable).parent
    on_path = shutil.which("pip")
    if on_path is not None and Path(on_path).parent == folder:
        return "pip install"
    program = f'"{sys.executable}"' if " " in sys.executable else sys.executable
    marker = Path(sysconfig.get_path("stdlib")) / "EXTERNALLY-MANAGED"
    if sys.prefix == sys.base_prefix and marker.exists():  # pip refuses to install here (PEP 668)
        return f"{program} -m venv .venv && .venv/bin/python -m pip install"
    if importlib.util.find_spec("pip") is None and shutil.which("uv") is not None:
        return f"uv pip install --python {program}"
    return f"{program} -m pip install"
