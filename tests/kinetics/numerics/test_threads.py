"""Solves with small matrices let BLAS use one thread, and give the others back."""

import numpy as np
import pytest
import threadpoolctl

from kinetics import Scene, solve, solve_field
from kinetics.numerics.threads import one_blas_thread


def used() -> list[int]:
    return [
        library["num_threads"]
        for library in threadpoolctl.threadpool_info()
        if library["user_api"] == "blas"
    ]


def test_one_thread_meanwhile_and_as_many_as_before_after_an_error() -> None:
    @one_blas_thread
    def fails() -> None:
        assert used()
        assert all(count == 1 for count in used())
        raise KeyError

    with threadpoolctl.threadpool_limits(limits=2, user_api="blas"):
        before = used()
        with pytest.raises(KeyError):
            fails()
        assert used() == before


@pytest.mark.parametrize("what", ["position", "scattering", "field", "steady"])
def test_where_matrices_are_small(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[list[int]] = []
    inverse, solved = np.linalg.inv, np.linalg.solve

    def inv(*arguments):  # type: ignore[no-untyped-def]
        seen.append(used())
        return inverse(*arguments)

    def solving(*arguments):  # type: ignore[no-untyped-def]
        seen.append(used())
        return solved(*arguments)

    monkeypatch.setattr(np.linalg, "inv", inv)
    monkeypatch.setattr(np.linalg, "solve", solving)
    with threadpoolctl.threadpool_limits(limits=2, user_api="blas"):
        if what == "steady":
            solve_field(0.7, rtol=1e-4)
        elif what == "field":
            solve(Scene(0.7, times=[10.0], outputs="mean_velocity", field=0.01), 1e-3)
        elif what == "scattering":
            scene = Scene(0.7, times=[100.0], outputs="intermediate_scattering")
            solution = solve(scene, 1e-3)
            seen.clear()
            solution.intermediate_scattering([0.1])
        else:
            solve(Scene(0.7, times=[300.0], outputs="position_density"), 1e-3)
        assert any(all(count == 1 for count in counts) for counts in seen)
