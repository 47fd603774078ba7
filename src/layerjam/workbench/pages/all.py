"""The pages in the order of their tabs; a page is loaded when its tab is first opened."""

import importlib
from dataclasses import dataclass

from layerjam.workbench.page import Page


@dataclass(frozen=True)
class Tab:
    """A tab; its page is the class `title` in the module `name` of this folder."""

    name: str
    title: str
    light: bool = False
    """Whether importing it does not import numerical code, which a thread may be importing."""

    def load(self) -> type[Page]:
        """Return the page; importing some pages takes a second."""
        module = importlib.import_module(f"layerjam.workbench.pages.{self.name}")
        kind: type[Page] = getattr(module, self.title)
        return kind


TABS = (
    Tab("start", "Start", light=True),
    Tab("brake", "Brake"),
    Tab("pull", "Pull"),
    Tab("drop", "Drop"),
    Tab("vacuum", "Vacuum"),
    Tab("laboratory", "Laboratory"),
    Tab("design", "Design"),
    Tab("bench", "Bench"),
)
