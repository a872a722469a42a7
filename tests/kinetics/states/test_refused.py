"""Arguments of initial states that are refused, each in one line that names the argument."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from kinetics import (
    AngularHarmonics,
    Beam,
    Gaussian,
    InputError,
    Monoenergetic,
    PolarGrid,
    Scene,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
    VelocitySamples,
    solve,
)


def at_start(initial: Any) -> Any:
    return solve(Scene(restitution=0.5, initial=initial, times=[0.0]))


V = np.linspace(0.0, 1.0, 11)
GRID = np.linspace(0.0, 1.0, 5)


ONES, NAN, AN_EXP = np.ones(11), np.nan, np.exp
BAD: dict[Any, dict[str, list[tuple[Any, ...]]]] = {
    SpeedTable: {
        "density": [
            *((V, f) for f in (2 * V - 0.5, NAN * ONES, np.inf * ONES, 2 * ONES, 0 * ONES)),
            *((V, f) for f in (np.ones(10), np.ones((11, 1)), "flat", V * 1j)),
        ],
        "speed": [
            (V[::-1], ONES), (V - 0.5, ONES), ([1.0], [1.0]), ([0.0, 0.5, 0.5, 1.0], np.ones(4)),
            ([0.0, NAN, 1.0], np.ones(3)), ("fast", np.ones(3)),
        ],
    },
    SpeedSamples: {
        "speed": [([],), ([1.0, 0.0],), ([1.0, -1.0],), ([1.0, NAN],), ([[1.0, 2.0]],), ("slow",),
                  ([1.0 + 1.0j],)],
    },
    Monoenergetic: {"speed": [(0.0,), (-1.0,), (NAN,), ("one",), (1j,), ([1.0, 2.0],)]},
    Gaussian: {
        "deviation_x": [(0.0, 1.0), (-1.0, 1.0), ("a", 1.0)],
        "deviation_y": [(1.0, np.inf)],
    },
    VelocitySamples: {
        "velocity": [([1.0, 2.0],), ([[1.0, 2.0, 3.0]],), ([[1.0, NAN]],), ([[0.0, 0.0]],), ([],),
                     ("north",), ([[1.0, 1.0j]],)],
    },
    Beam: {"direction": [(NAN,), ("up",)], "speeds": [(0.0, Gaussian(1.0, 2.0)), (0.0, "warm")]},
    AngularHarmonics: {
        "terms": [({1: AN_EXP},), ({0: AN_EXP, -1: AN_EXP},), ({0: AN_EXP, 0.5: AN_EXP},),
                  ({0: AN_EXP, "a": AN_EXP},), ({0: 1.0},), (3.0,)],
    },
    PolarGrid: {
        "values": [
            *((GRID, f) for f in (np.ones((4, 8)), np.ones(5), np.full((5, 8), NAN), "flat")),
            *((GRID, f) for f in (np.ones((5, 0)), -np.ones((5, 8)) / np.pi, np.ones((5, 8)))),
        ],
        "speed": [(GRID[::-1], np.ones((5, 8)))],
    },
}  # fmt: skip


@pytest.mark.parametrize(
    ("make", "name", "arguments"),
    [(make, n, a) for make, names in BAD.items() for n, rows in names.items() for a in rows],
)
def test_bad_states(make: Callable[..., Any], name: str, arguments: tuple[Any, ...]) -> None:
    with pytest.raises(InputError) as error:
        make(*arguments)
    message = str(error.value)
    assert message.startswith(f"{name}:")
    assert "\n" not in message


@pytest.mark.parametrize(
    "initial",
    [
        lambda v: v * np.exp(-0.5 * v * v) - 0.1 * np.exp(-v),  # negative
        lambda v: 2 * v * np.exp(-0.5 * v * v),  # not normalised
        lambda v: np.zeros_like(v),
        lambda v: v * np.nan,
        lambda v: np.where(v > 1.0, np.nan, v),
        lambda v: 2.0 * v / (1.0 + v * v) ** 2,  # tail v^-3: <v^2> diverges
        lambda v: 1.0 / (1.0 + v),  # does not normalise at all
        lambda v: np.ones(3),
        lambda v: "much",
        lambda v: None,
        lambda v: v * np.exp(-0.5 * v * v) * (1.0 + 1.0j),
        lambda: 1.0,
        lambda v: 1.0 if v > 1 else 0.0,  # not made for arrays
        SpeedDensity(lambda v: -v),
        "maxwell",
        None,
        3.0,
        [1.0, 2.0],
    ],
)
def test_bad_initial(initial: Any) -> None:
    with pytest.raises(InputError) as error:
        solve(Scene(restitution=0.5, initial=initial, times=[0.0, 1.0]))
    message = str(error.value)
    assert message.startswith(("initial:", "density:"))
    assert "\n" not in message


def test_a_peak_too_narrow_to_find() -> None:
    """One part in 10^6 wide: a function cannot be searched for it, a table can give it."""

    def peak(v: Any) -> Any:
        with np.errstate(under="ignore"):
            return np.exp(-0.5 * ((v - 2.0) / 2e-6) ** 2) / (2e-6 * np.sqrt(2 * np.pi))

    with pytest.raises(InputError, match=r"SpeedTable$"):
        solve(Scene(restitution=0.5, initial=peak, times=[1.0]))
    v = 2.0 + 2e-6 * np.linspace(-8.0, 8.0, 401)
    table = SpeedTable(v, peak(v) / np.trapezoid(peak(v), v))
    assert np.isclose(at_start(table).thermal_speed[0], np.sqrt(4.0 + 4e-12), rtol=1e-9)


def test_a_speed_density_that_is_not_callable() -> None:
    with pytest.raises(InputError, match=r"^\w+: .*$"):
        solve(Scene(restitution=0.5, initial=SpeedDensity(3.0), times=[1.0]))


@pytest.mark.parametrize(("p", "m"), [("x", 1), (np.nan, 1), (50, 1), (1, -1), (1, 300), (1, 0.5)])
def test_bad_harmonics(p: Any, m: Any) -> None:
    solution = solve(Scene(0.5, initial=Beam(), times=[1.0]))
    with pytest.raises(InputError, match=r"^(p|m): got"):
        solution.harmonic(p, m)
