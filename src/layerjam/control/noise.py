"""Counter-based Gaussian noise: the n-th number of a stream depends only on (seed, stream, n).

A 64-bit counter, multiplied by the golden ratio, is mixed by the finaliser of SplitMix64 (Steele,
Lea and Flood 2014). One word yields one number by the ziggurat method with 256 layers (Marsaglia
and Tsang 2000, in the form of Doornik 2005). Eight bits select the layer and 53 others the position
in it. About one word in a hundred is rejected and mixed again. The distribution is therefore
exactly the standard normal distribution, including its tails. Streams are sections of one sequence
of period 2^64 that start at scattered positions: for 10,000 streams of 3.6e5 numbers the
probability that any two overlap is 2e-6.
"""

import math
from typing import Any

import numba
import numpy as np

_LOOP: dict[str, Any] = {"error_model": "numpy", "_nrt": False}
_INLINE: dict[str, Any] = {"forceinline": True, **_LOOP}
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_LAYER = np.uint64(255)
LAYERS = 256
EDGE = 3.6541528853610088
"""Right edge of the lowest layer, where the tail begins; all 256 layers then have equal areas."""


def _compute_layers() -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return (right edge of each layer, ratio of the next edge to this one)."""
    foot = math.exp(-0.5 * EDGE * EDGE)
    area = EDGE * foot + math.sqrt(math.pi / 2) * math.erfc(EDGE / math.sqrt(2))
    x = np.zeros(LAYERS + 1)
    x[0], x[1] = area / foot, EDGE
    for i in range(2, LAYERS):
        x[i] = math.sqrt(-2 * math.log(area / x[i - 1] + math.exp(-0.5 * x[i - 1] ** 2)))
    return x, x[1:] / x[:-1]


EDGES, INNER = _compute_layers()


@numba.njit(**_INLINE)  # type: ignore[untyped-decorator]
def mix_bits(word: np.uint64) -> np.uint64:  # pragma: no cover
    """Return a word mixed by the finaliser of SplitMix64."""
    word = (word ^ (word >> _S30)) * _FIRST
    word = (word ^ (word >> _S27)) * _SECOND
    return word ^ (word >> _S31)


@numba.njit(**_INLINE)  # type: ignore[untyped-decorator]
def make_key(seed: int, stream: int) -> np.uint64:  # pragma: no cover
    """Return the position at which a stream starts."""
    return mix_bits(mix_bits(np.uint64(seed) + _GOLDEN) + np.uint64(stream) * _GOLDEN)


@numba.njit(**_INLINE)  # type: ignore[untyped-decorator]
def uniform(word: np.uint64) -> float:  # pragma: no cover
    """Return a uniformly distributed number in (0, 1), from the upper 53 bits of a word."""
    return (np.float64(np.int64(word >> _S11)) + 0.5) * 2.0**-53


@numba.njit(**_INLINE)  # type: ignore[untyped-decorator]
def normal(key: np.uint64, count: int) -> float:  # pragma: no cover
    """Return the `count`-th standard normal number of the stream at `key`."""
    word = mix_bits(key + np.uint64(count) * _GOLDEN)
    layer = np.int64(word & _LAYER)
    place = 2.0 * uniform(word) - 1.0
    if abs(place) < INNER[layer]:
        return place * EDGES[layer]
    return _draw_from_tail(word)


@numba.njit(**_LOOP)  # type: ignore[untyped-decorator]
def _draw_from_tail(word: np.uint64) -> float:  # pragma: no cover
    """Return a number from the tail or the edge of a layer, or from a new word."""
    while True:
        layer = np.int64(word & _LAYER)
        place = 2.0 * uniform(word) - 1.0
        x = place * EDGES[layer]
        if abs(place) < INNER[layer]:
            return x
        if layer == 0:
            while True:
                word = mix_bits(word + _GOLDEN)
                excess = -math.log(uniform(word)) / EDGE
                word = mix_bits(word + _GOLDEN)
                if -2.0 * math.log(uniform(word)) >= excess * excess:
                    return EDGE + excess if place > 0 else -EDGE - excess
        word = mix_bits(word + _GOLDEN)
        high = math.exp(-0.5 * (EDGES[layer] ** 2 - x * x))
        low = math.exp(-0.5 * (EDGES[layer + 1] ** 2 - x * x))
        if low + uniform(word) * (high - low) < 1.0:
            return x
        word = mix_bits(word + _GOLDEN)
