"""Figures drawn by a process beside this one, which goes on computing meanwhile.

To turn a figure into SVG takes Matplotlib a few tenths of a second and holds Python's lock. The
other process has neither JAX nor the computation: it takes figures, pickled, and returns SVG. It
ends when its pipe is closed, and hears no Ctrl-C: this process stops it.
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
from layerjam.report.style import drawn

FEW = 4
"""Figures that are drawn before another process has started."""
SERVE = "import sys; sys.path[:] = sys.argv[1:]; from layerjam.report.beside import serve; serve()"
OWN = ("backend", "backend_fallback", "interactive", "toolbar")
"""Settings of Matplotlib that are about windows."""


class Beside:
    """Draws figures in another process, and here what is left or does not work there.

    A context manager: when it is left the other process is gone. All are drawn here where fewer
    than `FEW` are to come or there is one core only.
    """

    def __init__(self, count: int) -> None:
        self._process = _started() if count >= FEW and cores() > 1 else None
        self._asking = ThreadPoolExecutor(1, thread_name_prefix="layerjam-drawing")
        self._posted: list[tuple[bytes | style.Figure, Future[str | None]]] = []
        if self._process is not None:
            self._asking.submit(_greet, self._process)

    def __enter__(self) -> "Beside":
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
                self._process.communicate()  # closes the pipes

    def post(self, figure: style.Figure) -> None:
        """Hand over a figure; what is done to it afterwards is not drawn."""
        if self._process is None:
            self._posted.append((figure, _done(drawn(figure))))
            return
        try:
            data = _pickled(figure)
        except (pickle.PicklingError, AttributeError, TypeError):  # it holds a local function
            self._posted.append((figure, _done(drawn(figure))))
            return
        self._posted.append((data, self._asking.submit(_asked, self._process, data)))

    def collect(self) -> list[str]:
        """The SVG of every figure posted, in their order; this process now draws as well."""
        texts: list[str] = []
        # the last first: the other process goes on from the front
        for posted, asked in reversed(self._posted):
            text = None if asked.cancel() else asked.result()
            if text is None:
                text = drawn(pickle.loads(posted) if isinstance(posted, bytes) else posted)
            texts.append(text)
        return texts[::-1]


def _started() -> subprocess.Popen[bytes] | None:
    """The other process, importing Matplotlib; None where there is no Python to start."""
    if not sys.executable or getattr(sys, "frozen", False):
        return None
    apart: dict[str, Any] = {"start_new_session": True}
    if sys.platform == "win32":
        apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    try:
        return subprocess.Popen(
            [sys.executable, "-c", SERVE, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            **apart,
        )
    except OSError:
        return None


def _pickled(figure: style.Figure) -> bytes:
    """Return a figure as bytes; raises what `pickle` raises."""
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
    """Give a transform its state, and its parents under the addresses that they have here.

    Matplotlib keeps the addresses from before: a new parent may get one of them, and then the old
    parent no longer hears of the layout, so that what it draws is clipped as it was before.
    """
    node.__dict__.update(state, _parents={})
    parents = node._parents
    for parent in state["_parents"].values():
        if parent is not None:
            forget = partial(_forget, parents.pop, id(parent))
            parents[id(parent)] = weakref.ref(parent, forget)


def _forget(pop: Callable[..., object], key: int, _: object) -> None:
    pop(key, None)


def _done(text: str) -> Future[str | None]:
    future: Future[str | None] = Future()
    future.set_result(text)
    return future


def _greet(process: subprocess.Popen[bytes]) -> None:
    """Say how Matplotlib is set here, and wait until the other process is ready."""
    from matplotlib import rcParams

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of settings that are on their way out
        # one by one: to read which backend there is would load one
        settings = {name: rcParams[name] for name in rcParams if name not in OWN}
    _asked(process, pickle.dumps(settings, pickle.HIGHEST_PROTOCOL))


def _asked(process: subprocess.Popen[bytes], data: bytes) -> str | None:
    """What the other process returns, None where it could not draw or is gone."""
    sent, received = process.stdin, process.stdout
    if sent is None or received is None:
        return None
    try:
        sent.write(data)
        sent.flush()
        found = pickle.load(received)
    except (OSError, ValueError, EOFError, pickle.UnpicklingError):
        return None
    return found if isinstance(found, str) else None


def serve() -> None:
    """Be the other process: settings first, then figures, until the pipe is closed.

    A figure that raises or warns is returned as None, and drawn again where that is heard.
    """
    received, sent = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no reply
    import matplotlib.backends.backend_svg

    settings: Any = pickle.load(received)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        matplotlib.rcParams.update(settings)
    warnings.simplefilter("error")
    reply: str | None = "ready"
    while True:
        pickle.dump(reply, sent)
        sent.flush()
        try:
            figure = pickle.load(received)
            reply = drawn(figure)
        except EOFError:
            return
        except Exception:
            reply = None
