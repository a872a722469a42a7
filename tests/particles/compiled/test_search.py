"""The search of a cell: vectors and loop give the same bits; the loop takes over where needed."""

import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from numba import njit

from particles.compiled import search, slots

CELLS = 3000


def many_cells() -> np.ndarray:
    """Return cells with some slots free, some struck at equal paths, some grazed."""
    rng = np.random.default_rng(8)
    found = rng.uniform(-3, 3, (CELLS, 2 * slots.SLOTS))
    free = rng.random((CELLS, slots.SLOTS)) < 0.3
    found[np.concatenate([free, free], axis=1)] = 1e150
    # The same scatterer twice, and mirror images about the x-axis, which tracers follow below.
    found[:600, 3], found[:600, slots.SLOTS + 3] = found[:600, 1], found[:600, slots.SLOTS + 1]
    found[600:1200, 3] = found[600:1200, 1]
    found[600:1200, slots.SLOTS + 3] = -found[600:1200, slots.SLOTS + 1]
    found[1200:1500, slots.SLOTS + 2] = 1.0
    return found


@njit
def _compiled_strike(cells, k, x, y, ux, uy):  # type: ignore[no-untyped-def]
    return search.strike(cells, k, x, y, ux, uy)


@njit
def _compiled_crowd(cells, k, x, y):  # type: ignore[no-untyped-def]
    return search.crowd(cells, k, x, y)


@njit
def _compiled_near_chord(cells, k, place, chord, reach2):  # type: ignore[no-untyped-def]
    return search.near_chord(cells, k, place, chord, reach2)


def test_the_vector_form_is_the_one_in_use() -> None:
    # Should numba or llvmlite change so that it fails, this test says so: half the speed is gone.
    assert (search.FORM, search.NOTE) == ("vectors", "")


def test_compiled_and_loop_give_the_same_bits() -> None:
    cells = many_cells()
    angles = np.random.default_rng(9).uniform(0, 2 * np.pi, CELLS)
    angles[:1500] = 0.0
    struck = near = beside = 0
    for k, angle in enumerate(angles):
        at = (0.0, 0.0, float(np.cos(angle)), float(np.sin(angle)))
        path, slot = slots.strike(cells, k, *at)
        found = _compiled_strike(cells, k, *at)
        assert (np.float64(path).tobytes(), slot) == (np.float64(found[0]).tobytes(), found[1])
        mask = slots.crowd(cells, k, 0.3, -0.2)
        assert _compiled_crowd(cells, k, 0.3, -0.2) == mask
        chord = 2.0 * at[2], 2.0 * at[3]
        reached = slots.near_chord(cells, k, (0.1, -0.3), chord, 0.5)
        assert _compiled_near_chord(cells, k, (0.1, -0.3), chord, 0.5) == reached
        beside += reached > 0
        struck += path < 1e100
        near += mask > 0
    assert struck > 1000
    assert near > 500
    assert beside > 500


@njit
def _compiled_in_space(cells, k, place, direction):  # type: ignore[no-untyped-def]
    return search.strike_in_space(cells, k, place, direction)


def test_compiled_and_loop_give_the_same_bits_in_space() -> None:
    rng = np.random.default_rng(10)
    cells = rng.uniform(-2, 2, (CELLS, 3 * slots.SLOTS))
    free = rng.random((CELLS, slots.SLOTS)) < 0.3
    cells[np.concatenate([free] * 3, axis=1)] = 1e150
    for axis in range(3):  # the same sphere twice
        cells[:600, axis * slots.SLOTS + 3] = cells[:600, axis * slots.SLOTS + 1]
    struck = 0
    for k, u in enumerate(rng.normal(size=(CELLS, 3))):
        direction = tuple((u / np.linalg.norm(u)).tolist())
        path, slot = slots.strike_in_space(cells, k, (0.1, -0.2, 0.3), direction)
        found = _compiled_in_space(cells, k, (0.1, -0.2, 0.3), direction)
        assert (np.float64(path).tobytes(), slot) == (np.float64(found[0]).tobytes(), found[1])
        struck += path < 1e100
    assert struck > 1000


PROGRAM = """
    import hashlib, sys, warnings
    {before}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        from particles.compiled.search import FORM, NOTE
    print(FORM, [w.category.__name__ for w in caught])
    import numpy as np
    from particles import Poisson, simulate
    for medium in (Poisson(0.3, 200), Poisson(2.0, 80)):
        e = simulate(medium, 0.5, times=[0.0, 1.0, 50.0], media=3, tracers=20, workers=1)
        print([hashlib.sha256(e.arrays[n].tobytes()).hexdigest() for n in sorted(e.arrays)])
    print(NOTE)
"""


def run(before: str = "", **environment: str) -> list[str]:
    program = textwrap.dedent(PROGRAM).format(before=before)
    return subprocess.run(
        [sys.executable, "-c", program], env=os.environ | environment, capture_output=True,
        text=True, check=True,
    ).stdout.splitlines()  # fmt: skip


@pytest.fixture(scope="module")
def normal() -> list[str]:
    return run()


@pytest.mark.slow
def test_the_loop_takes_over_and_says_so_once(normal: list[str]) -> None:
    assert normal[0] == "vectors []"
    found = run("sys.modules['particles.compiled.vectors'] = None  # as where llvmlite is missing")
    assert found[0] == "loop ['RuntimeWarning']"
    assert found[1:3] == normal[1:3]
    assert "the vector form fails here: ModuleNotFoundError" in found[3]


@pytest.mark.slow
def test_a_processor_without_extensions_gives_the_same_bits(normal: list[str]) -> None:
    assert run(NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="") == normal
