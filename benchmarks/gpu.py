"""The drops on a GPU: `python -m benchmarks.gpu` prints the same table where JAX sees one.

It needs a JAX with CUDA (`pip install "jax[cuda12]"`); nothing else of `make bench` does.
"""

from __future__ import annotations

import sys

import jax

from benchmarks.impact import Method, from_stop, markdown, measure, plain_jit

COUNTS = (100_000, 1_000_000, 10_000_000)


def methods() -> list[Method]:
    """Our stop, jitted over arrays of growing length; the first is what ratios are to."""
    return [Method(f"layerjam stop, jit, {n:,}", n, plain_jit, from_stop, "ours") for n in COUNTS]


def gpus() -> list[jax.Device]:
    """The GPUs JAX sees."""
    try:
        return list(jax.devices("gpu"))
    except RuntimeError:
        return []


def main() -> int:
    """The table, or one sentence where there is no GPU."""
    jax.config.update("jax_enable_x64", True)
    found = gpus()
    if not found:
        print("JAX sees no GPU here: nothing was measured.")
        return 0
    print(f"{found[0].device_kind}, JAX {jax.__version__}, double precision")
    with jax.default_device(found[0]):
        print(markdown(measure(methods())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
