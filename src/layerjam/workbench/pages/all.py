"""The pages in the order of their tabs; a page is loaded when its tab is first opened."""

import importlib
from dataclasses import dataclass

from layerjam.workbench.page import Page


@dataclass(frozen=True)
class Tab:
    """A tab: the class `title` in the module `name` next to this one."""

    name: str
    title: str
    light: bool = False
    """Whether it can be imported without the computing code, which another thread may be importing.
    """

    def load(self) -> type[Page]:
        """The page; some take a second to import."""
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
