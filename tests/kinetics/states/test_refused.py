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


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: SpeedTable(V, 2 * V - 0.5), "density"),
        (lambda: SpeedTable(V, np.full(11, np.nan)), "density"),
        (lambda: SpeedTable(V, np.full(11, np.inf)), "density"),
        (lambda: SpeedTable(V, 2.0 * np.ones(11)), "density"),
        (lambda: SpeedTable(V, np.zeros(11)), "density"),
        (lambda: SpeedTable(V, np.ones(10)), "density"),
        (lambda: SpeedTable(V, np.ones((11, 1))), "density"),
        (lambda: SpeedTable(V, "flat"), "density"),
        (lambda: SpeedTable(V, V * 1j), "density"),
        (lambda: SpeedTable(V[::-1], np.ones(11)), "speed"),
        (lambda: SpeedTable(V - 0.5, np.ones(11)), "speed"),
        (lambda: SpeedTable([1.0], [1.0]), "speed"),
        (lambda: SpeedTable([0.0, 0.5, 0.5, 1.0], np.ones(4)), "speed"),
        (lambda: SpeedTable([0.0, np.nan, 1.0], np.ones(3)), "speed"),
        (lambda: SpeedTable("fast", np.ones(3)), "speed"),
        (lambda: SpeedSamples([]), "speed"),
        (lambda: SpeedSamples([1.0, 0.0]), "speed"),
        (lambda: SpeedSamples([1.0, -1.0]), "speed"),
        (lambda: SpeedSamples([1.0, np.nan]), "speed"),
        (lambda: SpeedSamples([[1.0, 2.0]]), "speed"),
        (lambda: SpeedSamples("slow"), "speed"),
        (lambda: SpeedSamples([1.0 + 1.0j]), "speed"),
        (lambda: Monoenergetic(0.0), "speed"),
        (lambda: Monoenergetic(-1.0), "speed"),
        (lambda: Monoenergetic(np.nan), "speed"),
        (lambda: Monoenergetic("one"), "speed"),
        (lambda: Monoenergetic(1j), "speed"),
        (lambda: Monoenergetic([1.0, 2.0]), "speed"),
        (lambda: Gaussian(0.0, 1.0), "deviation_x"),
        (lambda: VelocitySamples([1.0, 2.0]), "velocity"),
        (lambda: VelocitySamples([[1.0, 2.0, 3.0]]), "velocity"),
        (lambda: VelocitySamples([[1.0, np.nan]]), "velocity"),
        (lambda: VelocitySamples([[0.0, 0.0]]), "velocity"),
        (lambda: VelocitySamples([]), "velocity"),
        (lambda: VelocitySamples("north"), "velocity"),
        (lambda: VelocitySamples([[1.0, 1.0j]]), "velocity"),
        (lambda: Beam(direction=np.nan), "direction"),
        (lambda: Beam(direction="up"), "direction"),
        (lambda: Beam(speeds=Gaussian(1.0, 2.0)), "speeds"),
        (lambda: Beam(speeds="warm"), "speeds"),
        (lambda: Gaussian(-1.0, 1.0), "deviation_x"),
        (lambda: Gaussian(1.0, np.inf), "deviation_y"),
        (lambda: Gaussian("a", 1.0), "deviation_x"),
        (lambda: AngularHarmonics({1: np.exp}), "terms"),
        (lambda: AngularHarmonics({0: np.exp, -1: np.exp}), "terms"),
        (lambda: AngularHarmonics({0: np.exp, 0.5: np.exp}), "terms"),
        (lambda: AngularHarmonics({0: np.exp, "a": np.exp}), "terms"),
        (lambda: AngularHarmonics({0: 1.0}), "terms"),
        (lambda: AngularHarmonics(3.0), "terms"),
        (lambda: PolarGrid(GRID, np.ones((4, 8))), "values"),
        (lambda: PolarGrid(GRID, np.ones(5)), "values"),
        (lambda: PolarGrid(GRID, np.full((5, 8), np.nan)), "values"),
        (lambda: PolarGrid(GRID, "flat"), "values"),
        (lambda: PolarGrid(GRID, np.ones((5, 0))), "values"),
        (lambda: PolarGrid(GRID[::-1], np.ones((5, 8))), "speed"),
        (lambda: PolarGrid(GRID, -np.ones((5, 8)) / np.pi), "values"),
        (lambda: PolarGrid(GRID, np.ones((5, 8))), "values"),
    ],
)
def test_bad_states(make: Callable[[], Any], name: str) -> None:
    with pytest.raises(InputError) as error:
        make()
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


def test_second_moments_are_asked_for_by_name() -> None:
    with pytest.raises(InputError, match="second moment"):
        solve(Scene(restitution=0.5, initial=lambda v: 2.0 * v / (1.0 + v * v) ** 2, times=[1.0]))


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
