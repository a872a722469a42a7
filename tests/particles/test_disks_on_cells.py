"""Answers depend neither on the units of a scene nor on how disks lie in the cells of the index."""

from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import kinetics
import particles
from kinetics import Scene, solve

few = partial(
    settings, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)  # fmt: skip
RESTITUTIONS = st.one_of(
    st.floats(0.0, 1.0),
    st.floats(-12.0, 0.0).map(lambda x: 10.0**x),
    st.floats(-12.0, 0.0).map(lambda x: 1.0 - 10.0**x),
)

# -- other units -----------------------------------------------------------------------------------

# powers of the length and of the speed that an average scales with
DIMENSIONS = {
    "thermal_speed": (0, 1),
    "temperature": (0, 2),
    "a2": (0, 0),
    "collisions": (0, 0),
    "msd": (2, 0),
    "kurtosis": (0, 0),
    "velocity_autocorrelation": (0, 2),
    "diffusion_coefficient": (1, 1),
    "mean_displacement": (1, 0),
    "mean_velocity": (0, 1),
    "velocity_tensor": (0, 2),
}


def in_units(length: int, speed: int, names: tuple[str, ...]) -> list[str]:
    """The averages that stay in the range of doubles in these units, d<r^2>/d ln t included."""
    most = {name: a * length + b * speed for name, (a, b) in DIMENSIONS.items()}
    most["diffusion_coefficient"] = max(most["diffusion_coefficient"], most["msd"])
    return [name for name in names if abs(most[name]) < 290]


@few(max_examples=25)
@given(
    e=RESTITUTIONS,
    length=st.integers(-150, 150),
    speed=st.integers(-150, 150),
    what=st.sampled_from(["number_density", "diameter"]),
)
def test_averages_do_not_depend_on_the_units(e: float, length: int, speed: int, what: str) -> None:
    """Mean free path and speeds times 1e-150 to 1e150: the answers are those of l = v = 1."""
    rtol = 1e-9
    reduced = 10.0 ** np.array([-8.0, -3.0, 0.0, 3.0])
    kept = tuple(in_units(length, speed, tuple(DIMENSIONS)))
    medium = {"number_density": 0.5, "diameter": 1.0}
    one = solve(Scene(e, **medium, initial=kinetics.Beam(0.3), times=reduced, outputs=kept), rtol)
    medium[what] *= 10.0**-length
    start = kinetics.Beam(0.3, kinetics.Monoenergetic(10.0**speed))
    times = reduced * 10.0 ** (length - speed)
    other = solve(Scene(e, **medium, initial=start, times=times, outputs=kept), rtol)
    for name in kept:
        a, b = DIMENSIONS[name]
        found, known = (np.asarray(getattr(s, name), dtype=float) for s in (other, one))
        size = np.max(np.abs(known), axis=tuple(range(1, known.ndim)), keepdims=True)
        if name == "a2":  # 1 + a2 is what it is accurate to
            size = np.ones(1)
        scaled = found / 10.0 ** (a * length) / 10.0 ** (b * speed)
        # averages are sums over ln v, which is known to 1e-16 of its size
        assert np.all(np.abs(scaled - known) <= (10.0 * rtol + 5e-13) * size), name


@pytest.mark.slow
@few(max_examples=12)
@given(
    kind=st.sampled_from(["BoltzmannGrad", "HardDisks", "Poisson"]),
    e=st.sampled_from([0.0, 0.5, 1.0]),
    length=st.integers(-498, 498),
    speed=st.integers(-498, 498),
)
def test_flights_do_not_depend_on_the_units(kind: str, e: float, length: int, speed: int) -> None:
    """Every length and speed scales with powers of two up to 2^498 = 8e149."""

    def flights(d: float, v: float) -> Any:
        count = {} if kind == "BoltzmannGrad" else {"count": 400}
        medium = getattr(particles, kind)(0.04 / d / d, diameter=d, **count)
        angle = np.linspace(0.0, 6.0, 7)
        return particles.simulate(
            medium, e, initial=v * np.stack([np.cos(angle), np.sin(angle)], axis=1),
            times=np.array([1.0, 30.0, 1e3]) * (d / v), media=2, tracers=7, seed=3, workers=1,
        )  # fmt: skip

    if length - speed > 900:  # times above 1e300 are refused
        length, speed = speed, length
    d, v = 2.0**length, 2.0**speed
    one, other = flights(1.0, 1.0), flights(d, v)
    for known, found in (
        (one.thermal_speed.value, other.thermal_speed.value / v),
        (one.collisions.value, other.collisions.value),
        (one.msd.value, other.msd.value / d / d),
    ):
        np.testing.assert_allclose(found, known, rtol=1e-9)


# -- disks where the cells of the index meet -------------------------------------------------------


def flight(disks: Any, side: float, velocity: Any, times: Any) -> Any:
    """Elastic flight from the origin among disks and their images: places at the times."""
    place, v, clock = np.zeros(2), np.array(velocity), 0.0
    out = []
    for t in times:
        while True:
            apart = disks - place
            # those near enough for the time that is left, as images around the tracer
            shifts = side * np.stack(np.meshgrid([-2, -1, 0, 1, 2], [-2, -1, 0, 1, 2]), -1)
            apart = (apart - side * np.round(apart / side))[:, None] + shifts.reshape(1, -1, 2)
            apart = apart.reshape(-1, 2)
            along = apart @ v
            impact = apart[:, 0] * v[1] - apart[:, 1] * v[0]
            square = (1.0 - impact) * (1.0 + impact)
            hit = (along > 1e-9) & (square > 0.0)
            paths = np.where(hit, along - np.sqrt(np.where(hit, square, 0.0)), np.inf)
            k = int(np.argmin(paths))
            if clock + paths[k] > t:
                place, clock = place + v * (t - clock), t
                break
            place, clock = place + v * paths[k], clock + paths[k]
            normal = apart[k] - v * paths[k]
            v = v - 2.0 * (v @ normal) * normal
        out.append(place)
    return np.array(out)


@pytest.mark.parametrize("cells", [3, 5, 7])
def test_disks_on_corners_walls_and_centres_of_cells(cells: int) -> None:
    """Against flights that know of no index. The tracers start where one disk is left out."""
    spacing = 7.2  # d; at this density a cell is twice as wide
    side = 2 * cells * spacing
    x, y = np.meshgrid(*(spacing * np.arange(-cells, cells),) * 2)
    disks = np.stack([x.ravel(), y.ravel()], axis=1)
    disks = disks[np.any(disks != 0.0, axis=1)]  # from the centre of the cell in the middle
    angles = np.linspace(0.1, 6.0, 40)
    velocity = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    times = np.array([15.0, 30.0])
    middle = 0.5 * side
    found = particles.simulate(
        particles.Positions(disks + middle, box_side=side, start=(middle, middle)), 1.0,
        initial=velocity, times=times, media=1, tracers=40, workers=1, observables=("positions",),
    )  # fmt: skip
    expected = np.stack([flight(disks, side, v, times) for v in velocity], axis=1)
    # each collision makes an error of rounding some ten times larger
    np.testing.assert_allclose(found.positions, expected, atol=1e-7, rtol=0.0)
