"""Kind of this installation, and the command that adds an optional package to it."""

import sys
from pathlib import Path
from typing import Any

NAME = "layerjam"


def install_command(extra: str) -> str:
    """Return the command that adds an extra to this installation.

    It names the folder or wheel from which layerjam was installed, or the package in an index.
    """
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    target, options = NAME, ""
    source = _read_source()
    path = Path(url2pathname(urlsplit(str(source.get("url", ""))).path))
    if str(source.get("url", "")).startswith("file:") and path.exists():
        target = str(path)
        is_editable = bool(source.get("dir_info", {}).get("editable"))
        options = "-e " if is_editable else ""
    # use double quotes, because the Windows shell accepts no others
    return f'{_find_installer()} {options}"{target}[{extra}]"'


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

    folder = Path(sys.executable).parent
    on_path = shutil.which("pip")
    if on_path is not None and Path(on_path).parent == folder:
        return "pip install"
    program = f'"{sys.executable}"' if " " in sys.executable else sys.executable
    if importlib.util.find_spec("pip") is None and shutil.which("uv") is not None:
        return f"uv pip install --python {program}"
    return f"{program} -m pip install"
