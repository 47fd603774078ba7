"""Text, tables and charts that change without a new page layout.

On a NiceGUI update, the browser processes every element of the page and every number in a chart's
options. While a slider moves, this takes most of the time. Content that changes with every move
bypasses it, in one message per drawing. The server's elements are kept up to date, so a reload or a
later update shows the same content.

This file, and the boxes of `scene`, are the only code that uses undocumented parts of NiceGUI. The
`workbench` extra therefore limits its version, and `check_version` checks it before the server
starts.
"""

import asyncio
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Self
from weakref import WeakKeyDictionary

from nicegui import Client, json, ui

from layerjam.core.errors import MissingExtraError
from layerjam.workbench.spoken import typeset_text

NEEDED = (
    (ui.label, "_handle_text_change"),
    (ui.label, "_text_to_model_text"),
    (ui.html, "_handle_content_change"),
    (ui.slider, "LOOPBACK"),
    (ui.scene, "_batch_calls"),
)
"""Parts of NiceGUI that the classes below override."""


def check_version() -> None:
    """Raise MissingExtraError if the installed NiceGUI is not the supported version."""
    if not all(hasattr(kind, name) for kind, name in NEEDED):
        raise MissingExtraError("the workbench (nicegui 3.18 or later, but below 4)", "workbench")


KINDS = ("texts", "contents", "charts", "spoken", "spaces", "fields")
"""Kinds of change, in the order in which `layerjamLive` processes them."""

_waiting: WeakKeyDictionary[Client, dict[str, dict[int, Any]]] = WeakKeyDictionary()


def _queue_change(element: ui.element, kind: str, value: Any) -> None:
    """Queue a change, to be sent with others after the current event-loop task."""
    client = element.client
    if client not in _waiting:
        try:
            asyncio.get_running_loop().call_soon(_send_changes, client)
        except RuntimeError:  # without an event loop there is no browser
            return
        _waiting[client] = defaultdict(dict)
    _waiting[client][kind][element.id] = value


def _send_changes(client: Client) -> None:
    messages = _waiting.pop(client, None)
    if messages and not client.is_deleted:
        parts = (json.dumps(messages[kind]) for kind in KINDS)
        client.run_javascript(f"layerjamLive({', '.join(parts)})")


class Words(ui.label):
    """A label whose text changes with every move of a slider."""

    def set_text(self, text: str) -> Self:
        """Show a sentence, in the page's terms."""
        return super().set_text(typeset_text(text))

    def _handle_text_change(self, text: str) -> None:
        self._text_to_model_text(text)
        _queue_change(self, "texts", text)


class Table(ui.html):
    """HTML that changes with every move of a slider; it must not contain unescaped user text."""

    def __init__(self) -> None:
        super().__init__("", sanitize=False)

    def _handle_content_change(self, content: str) -> None:
        with self.props.suspend_updates():
            super()._handle_content_change(content)
        _queue_change(self, "contents", content)


class Space(ui.scene):
    """A 3-D view whose changes are sent in one message with those of the charts.

    NiceGUI itself would send a message for each object: dozens per move of a slider.
    """

    @contextmanager
    def batch_changes(self) -> "Iterator[Space]":
        """Send all creations, moves and deletions inside the `with` block together."""
        with self:
            self._batched_calls = []
            try:
                yield self
            finally:
                calls, self._batched_calls = self._batched_calls, None
        if calls:
            old_lines = _waiting.get(self.client, {}).get("spaces", {}).get(self.id, [])
            _queue_change(self, "spaces", [*old_lines, *calls])

    def describe_scene(self, words: str) -> None:
        """Set the description for screen readers."""
        if self.props.get("aria-label") == words:
            return
        with self.props.suspend_updates():
            self.props["aria-label"] = words
        _queue_change(self, "spoken", words)


class Bar(ui.slider):
    """A slider whose moves the server does not confirm, because the browser has already shown them.

    NiceGUI would reply with the slider itself, and the browser would lay out the page again.
    """

    LOOPBACK = None

    def mirror_value(self, field: ui.input) -> None:
        """Show the dragged value in a field, without a message to the server."""
        self.on(
            "update:model-value",
            js_handler=f"(value) => layerjamSlid({self.id}, {field.id}, value)",
        )

    def set_range(self, low: float, high: float, step: float, digits: int) -> None:
        """Set both ends; `digits` is the number of decimals needed to distinguish the steps."""
        self.props.update({"min": low, "max": high, "step": step, "data-digits": digits})
        self.update()


class Field(ui.input):
    """A field whose text may change with every move of a slider."""

    def show_text(self, text: str) -> None:
        """Show a text that the user did not type."""
        self._send_update_on_value_change = False
        self.set_value(text)
        self._send_update_on_value_change = True
        _queue_change(self, "fields", text)


def draw_chart(chart: ui.echart, options: dict[str, Any]) -> None:
    """Update a chart's options; replace all of them only if its series or cursor have changed."""
    old = chart.options
    # NiceGUI's own method would wrap every number for change tracking and send it at once
    dict.__setitem__(chart.props, "options", options)
    changes = {key: value for key, value in options.items() if old.get(key) != value}
    has_same_parts = old.keys() == options.keys() and "tooltip" not in changes
    if has_same_parts and len(old["series"]) == len(options["series"]):
        _queue_change(chart, "charts", changes)
    else:
        chart.update()
