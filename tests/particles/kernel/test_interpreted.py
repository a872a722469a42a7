"""The kernels run uncompiled too, and give the same bits: the vector code is the loop it says."""

import contextlib
import io
import os
import subprocess
import sys
import textwrap

import pytest

PROGRAM = """
    import hashlib
    from particles import (
        OBSERVABLES, BoltzmannGrad, HardDisks, HardSpheres, Poisson,
        PoissonSpheres, simulate,
    )
    media = {
        "box": HardDisks(0.2, 60), "chains": Poisson(2.0, 80), "gas": BoltzmannGrad(0.1),
        "spheres": BoltzmannGrad(0.1, dimension=3),
        "plane": Poisson(0.3, box=None), "hard plane": HardDisks(0.3, box=None),
        "equilibrium": HardDisks(0.4, 50, equilibrate=2),
        "hard spheres": HardSpheres(0.4, count=40, equilibrate=2),
        "space": PoissonSpheres(0.5, count=None),
    }
    in_field = sorted({*OBSERVABLES} - {"velocity_component_histogram"})
    laws = ((0.3, 0.8), (0.5, 1.0), (0.0, 1.0), (1.0, 1.0), (0.9, 0.4))[:how_many]
    size = {"media": 2, "tracers": tracers, "workers": 1, "max_collisions": 12}
    for kind, (e, et) in ((kind, law) for kind in media for law in laws):
        ensemble = simulate(
            media[kind], e, times=[0.0, 1.0, 7.0], observables=OBSERVABLES,
            tangential_restitution=et, **size,
        )
        for name in sorted(ensemble.arrays):
            array = ensemble.arrays[name]
            print(kind, e, et, name, array.shape, hashlib.sha256(array.tobytes()).hexdigest())
        if kind not in ("gas", "spheres", "box", "hard plane"):
            continue
        ensemble = simulate(
            media[kind], e, "rest", [0.0, 1.0, 7.0], field=2.0, observables=in_field,
            tangential_restitution=et, **size,
        )
        for name in sorted(ensemble.arrays):
            array = ensemble.arrays[name]
            print("in a field", kind, e, et, name, hashlib.sha256(array.tobytes()).hexdigest())
"""


def program(laws: int, tracers: int) -> str:
    return f"how_many, tracers = {laws}, {tracers}\n{textwrap.dedent(PROGRAM)}"


def compiled(laws: int, tracers: int) -> list[str]:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(program(laws, tracers), {})
    return printed.getvalue().splitlines()


def interpreted(laws: int, tracers: int) -> list[str]:
    # Integers wrap around: meant, and only the interpreter warns of it.
    command = [sys.executable, "-W", "ignore::RuntimeWarning", "-c", program(laws, tracers)]
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, check=True
    ).stdout.splitlines()


@pytest.mark.parametrize(("laws", "tracers"), [(1, 9), pytest.param(5, 18, marks=pytest.mark.slow)])
def test_interpreted_and_compiled_kernels_give_the_same_bits(laws: int, tracers: int) -> None:
    found = compiled(laws, tracers)
    assert len(found) == 9 * laws * 15 + 4 * laws * 14
    assert interpreted(laws, tracers) == found
