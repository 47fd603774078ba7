"""A tab of the browser that is loaded again takes over what was dropped in it before.

After a reload the server has a new desk; the old one stays for some seconds, in which a browser may
come back. The tab's id, which the browser keeps through a reload, tells that both are one.
"""

from __future__ import annotations

from typing import Protocol

from layerjam.workbench.desk import Desk


class Connection(Protocol):
    """What is asked of NiceGUI's client."""

    tab_id: str | None
    """None while no browser is connected."""

    @property
    def is_deleted(self) -> bool:
        """Whether its page is gone for good."""


_desks: dict[str, tuple[Connection, Desk]] = {}


def take_over(client: Connection, desk: Desk) -> None:
    """Give a tab's new desk the files of the one before, with their pins and calibrations.

    A tab whose page is still open somewhere keeps its files: one that was duplicated begins anew.
    """
    tab = client.tab_id
    if tab is None:
        return
    left, before = _desks.get(tab, (client, desk))
    _desks[tab] = (client, desk)
    if before is not desk and left.tab_id is None and not left.is_deleted:
        desk.take_over(before)


def forget(desk: Desk) -> None:
    """The page of a desk is gone."""
    for tab in [tab for tab, (_, known) in _desks.items() if known is desk]:
        del _desks[tab]
