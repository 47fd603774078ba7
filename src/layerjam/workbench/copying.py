"""Text to copy: displayed, and copied to the clipboard if the browser allows it."""

import json
from collections.abc import Mapping
from functools import partial

from nicegui import ui

from layerjam.workbench.widgets import PLAIN, dress

WORDS = {"python": "Python", "bash": "a command"}


async def copy_text(text: str) -> bool:
    """Copy the value of the JavaScript `text`; return whether the browser allowed it."""
    return await ui.run_javascript(f"layerjamCopied({text})", timeout=5.0) is True


async def show_copy(text: str, language: str, files: Mapping[str, str]) -> None:
    """Copy "python" or "bash" text and show it, with buttons to save `files` {name: content}."""
    if not text:
        ui.notify("nothing to copy on this page yet")
        return
    kind = WORDS[language]
    if await copy_text(json.dumps(text)):
        head = f"Copied as {kind}"
    else:
        head = (
            f"As {kind}. Your browser does not allow this page to copy text: select it and "
            "copy it yourself"
        )
    dialog = dress(ui.dialog(value=True), aria_label=f"Copied as {kind}")
    with dialog, ui.card().classes("w-full"):
        ui.label(head).classes("font-medium")
        lines = dress(ui.code(text, language=language), "copied", "w-full")
        dress(lines.markdown, tabindex="0", role="group", aria_label=f"Copied {kind}")
        dress(lines.copy_button, aria_label="Copy")
        if files:
            ui.label(
                "You edited or created this file here. Save it in the folder where you run "
                "these lines:"
            )
            for name, content in files.items():
                save = partial(ui.download.content, content.encode(), name, "application/toml")
                dress(ui.button(name, icon="download", on_click=save), "copied-save", look=PLAIN)
        ui.button("Close", on_click=dialog.close).props("flat autofocus")
