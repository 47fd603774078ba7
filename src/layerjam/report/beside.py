"""Figures drawn by another process while this one continues to compute.

Matplotlib needs a few tenths of a second to turn a figure into SVG, and holds Python's lock. The
other process loads neither JAX nor the computing code: it receives pickled figures and returns SVG.
It ends when its pipe is closed, and ignores Ctrl-C because this process stops it.
"""

import contextlib
import io
import os
import pickle
import subprocess
import sys
import warnings
import weakref
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from types import TracebackType
from typing import Any

from layerjam.mechanics.threads import cores
from layerjam.report import style
from layerjam.report.style import svg_text

FEW = 4
"""Number of figures that are drawn here before another process has started."""
SERVE = "import sys; sys.path[:] = sys.argv[1:]; from layerjam.report.beside import serve; serve()"
WINDOW_SETTINGS = ("backend", "backend_fallback", "interactive", "toolbar")
"""Matplotlib's settings for windows, which are not sent to the other process."""


class DrawingProcess:
    """Draws figures in another process; this process draws the remaining and the failed ones.

    It is a context manager; the other process ends on exit. All figures are drawn here if there are
    fewer than `FEW`, or only one core.
    """

    def __init__(self, count: int) -> None:
        self._process = _start() if count >= FEW and cores() > 1 else None
        self._asking = ThreadPoolExecutor(1, thread_name_prefix="layerjam-drawing")
        self._posted: list[tuple[bytes | style.Figure, Future[str | None]]] = []
        if self._process is not None:
            self._asking.submit(_greet, self._process)

    def __enter__(self) -> "DrawingProcess":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._process is not None:
            self._process.terminate()
            self._process.wait()
        self._asking.shutdown(wait=True, cancel_futures=True)
        if self._process is not None:
            with contextlib.suppress(OSError):
                self._process.communicate()  # this closes the pipes

    def post(self, figure: style.Figure) -> None:
        """Submit a figure; later changes to it are not drawn."""
        if self._process is None:
            self._posted.append((figure, _complete(svg_text(figure))))
            return
        try:
            data = _pickle_figure(figure)
        except (pickle.PicklingError, AttributeError, TypeError):  # the figure has a local function
            self._posted.append((figure, _complete(svg_text(figure))))
            return
        self._posted.append((data, self._asking.submit(_request, self._process, data)))

    def collect(self) -> list[str]:
        """Return the SVGs of all posted figures in order; this process now draws figures too."""
        texts: list[str] = []
        # start from the last figure, because the other process starts from the first
        for item, future in reversed(self._posted):
            text = None if future.cancel() else future.result()
            if text is None:
                text = svg_text(pickle.loads(item) if isinstance(item, bytes) else item)
            texts.append(text)
        return texts[::-1]


def _start() -> subprocess.Popen[bytes] | None:
    """Start the other process, which imports Matplotlib; None if Python cannot be started."""
    if not sys.executable or getattr(sys, "frozen", False):
        return None
    options: dict[str, Any] = {"start_new_session": True}
    if sys.platform == "win32":
        options = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    try:
        return subprocess.Popen(
            [sys.executable, "-c", SERVE, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            **options,
        )
    except OSError:
        return None


def _pickle_figure(figure: style.Figure) -> bytes:
    from matplotlib.transforms import TransformNode

    class Pickler(pickle.Pickler):
        def reducer_override(self, item: object) -> Any:
            if not isinstance(item, TransformNode):
                return NotImplemented
            return (*item.__reduce_ex__(pickle.HIGHEST_PROTOCOL)[:3], None, None, _with_parents)

    buffer = io.BytesIO()
    Pickler(buffer, pickle.HIGHEST_PROTOCOL).dump(figure)
    return buffer.getvalue()


def _with_parents(node: Any, state: dict[str, Any]) -> None:
    """Restore a transform with its parents under their addresses in this process.

    Matplotlib keeps the old addresses. If a new parent gets one of them, the old parent is no
    longer notified of the layout and clips its drawing as before.
    """
    node.__dict__.update(state, _parents={})
    parents = node._parents
    for parent in state["_parents"].values():
        if parent is not None:
            forget = partial(_forget, parents.pop, id(parent))
            parents[id(parent)] = weakref.ref(parent, forget)


def _forget(pop: Callable[..., object], key: int, _: object) -> None:
    pop(key, None)


def _complete(text: str) -> Future[str | None]:
    future: Future[str | None] = Future()
    future.set_result(text)
    return future


def _greet(process: subprocess.Popen[bytes]) -> None:
    """Send Matplotlib's current settings, and wait until the other process is ready."""
    from matplotlib import rcParams

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # deprecated settings warn
        # one at a time, because a query of the current backend would load one
        settings = {name: rcParams[name] for name in rcParams if name not in WINDOW_SETTINGS}
    _request(process, pickle.dumps(settings, pickle.HIGHEST_PROTOCOL))


def _request(process: subprocess.Popen[bytes], data: bytes) -> str | None:
    """Return the reply of the other process, or None if it could not draw or has ended."""
    requests, replies = process.stdin, process.stdout
    if requests is None or replies is None:
        return None
    try:
        requests.write(data)
        requests.flush()
        reply = pickle.load(replies)
    except (OSError, ValueError, EOFError, pickle.UnpicklingError):
        return None
    return reply if isinstance(reply, str) else None


def serve() -> None:
    """Run the other process: settings first, then figures, until the pipe is closed.

    A figure that raises or warns is returned as None, and drawn again in the caller.
    """
    requests, replies = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # printed output of libraries must not count as a reply
    import matplotlib.backends.backend_svg

    settings: Any = pickle.load(requests)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        matplotlib.rcParams.update(settings)
    warnings.simplefilter("error")
    reply: str | None = "ready"
    while True:
        pickle.dump(reply, replies)
        replies.flush()
        try:
            figure = pickle.load(requests)
            reply = svg_text(figure)
        except EOFError:
            return
        except Exception:
            reply = None
