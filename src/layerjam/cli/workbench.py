"""`workbench` on the command line."""

from typing import Annotated

from layerjam.commands.declare import Help, command
from layerjam.commands.results import Result, fact, result
from layerjam.errors import MissingExtraError
from layerjam.units import QuantitySpec

PORT = QuantitySpec("1", "port to listen on", lo=1, hi=65535, whole=True)


@result
class WorkbenchResult(Result):
    """Address of the page."""

    port: int = fact("port of the server", listed=False)


@command("share", computes=False)
def workbench(
    *,
    port: Annotated[int, PORT] = 8321,
    host: Annotated[str, Help("Address to listen on. Remote clients need a token.")] = "127.0.0.1",
    show: Annotated[bool, Help("Open a browser.", option="--show/--no-show")] = True,
) -> WorkbenchResult:
    """Open the workbench: all of layerjam on a page of your browser."""
    from layerjam.cli.engine import enable_double_precision

    with MissingExtraError.raise_if_missing("the workbench (nicegui)", "workbench"):
        import nicegui  # noqa: F401

        from layerjam.workbench.server import serve
    serve(host=host, port=port, show=show, engine=enable_double_precision)
    return WorkbenchResult(port=port)
