"""Counter-based random streams: one per (seed, purpose, configuration, tracer or cell).

A stream is a pair (state, gamma) hashed from its key; draw number k is a hash of state + k gamma.
So results do not depend on the order in which tracers, cells or configurations are visited. The
hash is the SplitMix64 finaliser, with an odd gamma of its own for each stream (Steele, Lea & Flood,
OOPSLA 2014), which keeps streams from being shifted copies of one another. Begin reading with
`open_stream` and `bits`.
"""

import numpy as np
from numba import njit, uint64

# The purpose is part of a stream's key, so streams of different purposes differ. Other numbers
# would be other random numbers of the same kind.
START = 1  # the velocity that a tracer starts with
PLACEMENT = 2  # the places of scatterers
FLIGHTS = 3  # free paths and impact parameters, and noise
PLACES = 6  # where tracers start in a field from rest

#: The odd number nearest to 2^64 / (golden ratio), as SplitMix64 has it: its multiples are spread
#: evenly.
GOLDEN = 0x9E3779B97F4A7C15


@njit(inline="always")
def mix(z: np.uint64) -> np.uint64:
    """Return the SplitMix64 finaliser of a 64-bit integer, a bijection."""
    z = uint64(z)
    z = (z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> uint64(27))) * uint64(0x94D049BB133111EB)
    return z ^ (z >> uint64(31))


@njit(inline="always")
def open_stream(
    seed: np.uint64, purpose: int, configuration: int, number: int
) -> tuple[np.uint64, np.uint64]:
    """Return (state, odd gamma) of the stream with this key; number: of a tracer, or 0."""
    golden = uint64(GOLDEN)
    key = mix(uint64(seed) + golden)
    key = mix(key + uint64(purpose) * golden)
    key = mix(key ^ (uint64(configuration) * golden))
    key = mix(key + uint64(number) * golden)
    return key, mix(key ^ golden) | uint64(1)


@njit(inline="always")
def bits(state: np.uint64, gamma: np.uint64, counter: int) -> np.uint64:
    """Return draw number `counter` of a stream as 64 random bits."""
    return mix(uint64(state) + uint64(counter) * uint64(gamma))


@njit(inline="always")
def to_unit(word: np.uint64) -> float:
    """Return 64 random bits as an odd multiple of 2**-53 in (0, 1)."""
    return (float(uint64(word) >> uint64(12)) + 0.5) * 2.0**-52


@njit(inline="always")
def in_disk(word: np.uint64) -> tuple[float, float]:
    """Return a place made of 64 random bits, uniform in the disk of radius 1, never its centre.

    The halves of the word are its coordinates in the square around the disk. Outside the disk, the
    word is hashed once more.
    """
    while True:
        x = (float(uint64(word) >> uint64(32)) + 0.5) * 2.0**-31 - 1.0
        y = (float(uint64(word) & uint64(0xFFFFFFFF)) + 0.5) * 2.0**-31 - 1.0
        if x * x + y * y < 1.0:
            return x, y
        word = mix(uint64(word) + uint64(GOLDEN))


@njit(inline="always")
def uniform(state: np.uint64, gamma: np.uint64, counter: int) -> float:
    """Return draw number `counter` as an odd multiple of 2**-53 in (0, 1)."""
    return to_unit(bits(state, gamma, counter))
