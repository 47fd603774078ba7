"""Text that the user takes along: shown, and put into the clipboard where the browser allows it."""

from __future__ import annotations

import json
from collections.abc import Sequence

from nicegui import ui

from layerjam.workbench.call import Call
from layerjam.workbench.widgets import dressed

WORDS = {"python": "Python", "bash": "a command"}


async def copied(text: str) -> bool:
    """Whether the browser let it into the clipboard; `text` is JavaScript that gives it."""
    return await ui.run_javascript(f"layerjamCopied({text})", timeout=5.0) is True


async def offer(text: str, language: str, calls: Sequence[Call]) -> None:
    """Show what was copied as "python" or "bash", and what has to be saved beside it first."""
    if not text:
        ui.notify("nothing to copy on this page yet")
        return
    what = WORDS[language]
    if await copied(json.dumps(text)):
        head = f"Copied as {what}"
    else:
        head = f"As {what}. Your browser does not let this page copy: select the text and copy it"
    dialog = dressed(ui.dialog(value=True), aria_label=f"Copied as {what}")
    with dialog, ui.card().classes("w-full"):
        ui.label(head).classes("font-medium")
        lines = dressed(ui.code(text, language=language), "copied", "w-full")
        dressed(lines.markdown, tabindex="0", role="group", aria_label=f"What was copied as {what}")
        dressed(lines.copy_button, aria_label="Copy")
        edited = [name for call in calls for name in call.to_save]
        if edited:
            ui.label(f"{edited[0]} was edited or written here: save it beside where you run this.")
        ui.button("Close", on_click=dialog.close).props("flat autofocus")
