"""Words, tables and charts that change without the page being laid out anew.

An update of NiceGUI lets the browser go through every element of the page and through every number
of a chart's options; under a slider that is most of the time. What changes with every move goes
past it, all of one drawing in one message; the server's elements are the same as ever, so that a
reload or a later update shows the same.
"""

from __future__ import annotations

import asyncio
from collections import defaultdict
from typing import Any
from weakref import WeakKeyDictionary

from nicegui import Client, json, ui

SCRIPT = """<script>
window.layerjamLive = (texts, contents, charts) => {
  const raw = (id) => Vue.toRaw(Vue.toRaw(mounted_app.elements)[id]);
  for (const id in texts) {
    if (raw(id)) raw(id).text = texts[id];
    const node = document.getElementById('c' + id)?.firstChild;
    if (node) node.nodeValue = texts[id];
  }
  for (const id in contents) {
    if (raw(id)) raw(id).props.innerHTML = contents[id];
    const element = document.getElementById('c' + id);
    if (element) element.innerHTML = contents[id];
  }
  for (const id in charts) {
    if (raw(id)) Object.assign(Vue.toRaw(raw(id).props.options), charts[id]);
    getElement(id)?.chart?.setOption(charts[id]);
  }
};
window.layerjamSlid = (bar, field, value) => {
  const digits = document.getElementById('c' + bar).dataset.digits;
  getElement(field).inputValue = String(+(+value.toFixed(digits)).toPrecision(6));
  // the slider tells nothing where it comes back to what it takes for its value
  getElement(bar).$.props.modelValue = value;
  Vue.toRaw(Vue.toRaw(mounted_app.elements)[bar]).props['model-value'] = value;
};
</script>"""
"""For the page's body, once."""

_waiting: WeakKeyDictionary[Client, dict[str, dict[int, Any]]] = WeakKeyDictionary()


def _tell(element: ui.element, kind: str, value: Any) -> None:
    """Send when what runs now on the event loop is done, together with what else it changes."""
    client = element.client
    if client not in _waiting:
        try:
            asyncio.get_running_loop().call_soon(_send, client)
        except RuntimeError:  # no browser without an event loop
            return
        _waiting[client] = defaultdict(dict)
    _waiting[client][kind][element.id] = value


def _send(client: Client) -> None:
    told = _waiting.pop(client, None)
    if told and not client.is_deleted:
        parts = (json.dumps(told[kind]) for kind in ("texts", "contents", "charts"))
        client.run_javascript(f"layerjamLive({', '.join(parts)})")


class Words(ui.label):
    """A label for what changes with every move."""

    def _handle_text_change(self, text: str) -> None:
        self._text_to_model_text(text)
        _tell(self, "texts", text)


class Table(ui.html):
    """HTML made by us, never from a user's words unescaped, that changes with every move."""

    def __init__(self) -> None:
        super().__init__("", sanitize=False)

    def _handle_content_change(self, content: str) -> None:
        with self._props.suspend_updates():
            super()._handle_content_change(content)
        _tell(self, "contents", content)


class Bar(ui.slider):
    """A slider that the server does not answer: it has moved already.

    NiceGUI answers every move with the slider itself, and the page is laid out anew.
    """

    LOOPBACK = None

    def beside(self, field: ui.input) -> None:
        """Write what is dragged into a field, in the browser."""
        self.on(
            "update:model-value",
            js_handler=f"(value) => layerjamSlid({self.id}, {field.id}, value)",
        )

    def way(self, low: float, high: float, step: float, digits: int) -> None:
        """From where to where; `digits` behind the point tell the steps apart."""
        self.props.update({"min": low, "max": high, "step": step, "data-digits": digits})
        self.update()


def draw(chart: ui.echart, made: dict[str, Any]) -> None:
    """Give a chart new options; as a whole only where its series or its cursor are others."""
    old = chart.options
    # set as NiceGUI sets it, every number would be wrapped to be watched, and sent at once
    dict.__setitem__(chart.props, "options", made)
    changed = {key: value for key, value in made.items() if old.get(key) != value}
    alike = old.keys() == made.keys() and "tooltip" not in changed
    if alike and len(old["series"]) == len(made["series"]):
        _tell(chart, "charts", changed)
    else:
        chart.update()
