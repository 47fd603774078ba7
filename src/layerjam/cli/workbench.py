"""`workbench` on the command line."""

from __future__ import annotations

from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("workbench")(workbench)


def workbench(
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port to listen on.")] = 8321,
    host: Annotated[
        str, typer.Option(help="Address; any but this machine's own gets a token.")
    ] = "127.0.0.1",
    show: Annotated[bool, typer.Option("--show/--no-show", help="Open a browser.")] = True,
) -> int:
    """Open the workbench: the whole of layerjam on a page of your browser."""
    from layerjam.cli import options as opt
    from layerjam.workbench.server import serve

    serve(host=host, port=port, show=show, engine=opt.engine)
    return 0
