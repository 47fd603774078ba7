"""The pages in the order of their tabs; a page is loaded when its tab is first opened."""

import importlib
from dataclasses import dataclass

from layerjam.workbench.page import Page


@dataclass(frozen=True)
class Tab:
    """A tab; its page is the class `title` in the module `name` of this package."""

    name: str
    title: str
    light: bool = False
    """Whether its module can be imported without the numerical code, which loads in a thread."""

    def load(self) -> type[Page]:
        """Import the page and return its class; some pages take a second to import."""
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
