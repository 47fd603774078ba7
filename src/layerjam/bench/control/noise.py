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
from collections.abc import Sequence
from typing import NamedTuple

Word = int
"""Whole number from 0 to 2^64 - 1."""
MASK = 2**64 - 1
GOLDEN = 0x9E3779B97F4A7C15
FIRST, SECOND = 0xBF58476D1CE4E5B9, 0x94D049BB133111EB
UNIT = 2.0**-53
COUNT = 256
EDGE = 3.6541528853610088
"""Right edge of the lowest layer, where the tail begins; all 256 layers then have equal areas."""


class Layers(NamedTuple):
    """Layers of the ziggurat."""

    edges: Sequence[float]
    """Right edge of each layer, and 0 at the top."""
    inner: Sequence[float]
    """Ratio of the next edge to this one."""


def compute_layers() -> Layers:
    """Return the layers, of equal areas."""
    foot = math.exp(-0.5 * EDGE * EDGE)
    area = EDGE * foot + math.sqrt(math.pi / 2) * math.erfc(EDGE / math.sqrt(2))
    x = [area / foot, EDGE]
    for i in range(2, COUNT):
        x.append(math.sqrt(-2 * math.log(area / x[i - 1] + math.exp(-0.5 * (x[i - 1] * x[i - 1])))))
    x.append(0.0)
    return Layers(x, [x[i + 1] / x[i] for i in range(COUNT)])


LAYERS = compute_layers()


def mix_bits(word: Word) -> Word:
    """Return a word mixed by the finaliser of SplitMix64."""
    word = ((word ^ (word >> 30)) * FIRST) & MASK
    word = ((word ^ (word >> 27)) * SECOND) & MASK
    return word ^ (word >> 31)


def make_key(seed: int, stream: int) -> Word:
    """Return the position at which a stream starts."""
    return mix_bits((mix_bits((seed + GOLDEN) & MASK) + stream * GOLDEN) & MASK)


def uniform(word: Word) -> float:
    """Return a uniformly distributed number in (0, 1), from the upper 53 bits of a word."""
    return (float(int(word >> 11)) + 0.5) * UNIT


def normal(key: Word, count: int, layers: Layers) -> float:
    """Return the `count`-th standard normal number of the stream at `key`."""
    word = mix_bits((key + count * GOLDEN) & MASK)
    layer = word & 255
    place = 2.0 * uniform(word) - 1.0
    if abs(place) < layers.inner[layer]:
        return place * layers.edges[layer]
    return _draw_from_tail(word, layers)


def _draw_from_tail(word: Word, layers: Layers) -> float:
    """Return a number from the tail or the edge of a layer, or from a new word."""
    while True:
        layer = word & 255
        place = 2.0 * uniform(word) - 1.0
        edge = layers.edges[layer]
        x = place * edge
        if abs(place) < layers.inner[layer]:
            return x
        if layer == 0:
            while True:
                word = mix_bits((word + GOLDEN) & MASK)
                excess = -math.log(uniform(word)) / EDGE
                word = mix_bits((word + GOLDEN) & MASK)
                if -2.0 * math.log(uniform(word)) >= excess * excess:
                    return EDGE + excess if place > 0.0 else -EDGE - excess
        word = mix_bits((word + GOLDEN) & MASK)
        next_edge = layers.edges[layer + 1]
        high = math.exp(-0.5 * (edge * edge - x * x))
        low = math.exp(-0.5 * (next_edge * next_edge - x * x))
        if low + uniform(word) * (high - low) < 1.0:
            return x
        word = mix_bits((word + GOLDEN) & MASK)
