"""Inputs by hypothesis: bad ones are refused, extreme ones are answered, units do not matter."""

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import kinetics
import particles
from kinetics import InputError, Scene, solve, solve_scaled
from kinetics.crosscheck.stress.limits import (
    GROWTH,
    ROUNDING,
    below,
    growth,
    limit_errors,
)

few = partial(
    settings, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)  # fmt: skip

# -- bad input: one line that names the argument ---------------------------------------------------

NOT_FINITE = st.sampled_from([math.nan, math.inf, -math.inf])
NOT_POSITIVE = st.floats(max_value=0.0, allow_nan=False) | NOT_FINITE
NEGATIVE = st.floats(max_value=-1e-300, allow_nan=False, allow_infinity=False)
OUTSIDE_0_1 = NEGATIVE | st.floats(1.0, exclude_min=True, allow_infinity=False) | NOT_FINITE
WORDS = st.sampled_from(["one", "0.7 or so", ""])
BAD_TIMES = st.one_of(
    NEGATIVE.map(lambda t: [t]),
    st.floats(0.0, 1e9).map(lambda t: [t + 1.0, 0.5 * t]),
    st.sampled_from([[], [math.nan], [math.inf], [[1.0]], [1j], "soon"]),
)
NOT_A_COUNT = st.integers(max_value=0) | st.sampled_from([1.5, 0.0])


def scene(**changes: Any) -> Scene:
    return Scene(**{"restitution": 0.7, "times": [1.0], **changes})


def of_scene(name: str) -> Callable[[Any], Any]:
    return lambda value: scene(**{name: value})


def of_solve(name: str) -> Callable[[Any], Any]:
    return lambda value: solve(scene(), **{name: value})


@cache
def solved(output: str) -> Any:
    return solve(scene(outputs=(output,)), 1e-3)


def ask(method: str, output: str = "thermal_speed") -> Callable[[Any], Any]:
    """Ask this of a solution that has the output."""
    return lambda value: getattr(solved(output), method)(value)


def run(name: str) -> Callable[[Any], Any]:
    given: dict[str, Any] = {"times": [1.0], "media": 1, "tracers": 2, "workers": 1}
    medium = particles.BoltzmannGrad(0.04)
    return lambda value: particles.simulate(medium, **{"restitution": 0.5, **given, name: value})


ORDERS = NEGATIVE | st.floats(41.0, 1e300) | st.sampled_from([math.nan, math.inf, "two"])
ELSEWHERE = NEGATIVE.map(lambda x: [x]) | st.just([math.nan])
SHAPES = st.sampled_from([(2, 2), (3, 2)])
# argument, what is called with the value, bad values
BAD: list[tuple[str, Callable[[Any], Any], st.SearchStrategy[Any]]] = [
    ("restitution", of_scene("restitution"), OUTSIDE_0_1 | WORDS | st.none()),
    ("number_density", of_scene("number_density"), NOT_POSITIVE | WORDS),
    ("diameter", of_scene("diameter"), NOT_POSITIVE | WORDS),
    ("number_density", lambda rho: scene(number_density=rho, diameter=2.0),
     st.sampled_from([1e-310, 1.7e308])),
    ("times", of_scene("times"), BAD_TIMES),
    ("outputs", of_scene("outputs"), st.sampled_from([(), ("speed",), (1,)])),
    ("harmonics", of_scene("harmonics"),
     st.integers(max_value=-1) | st.integers(257) | st.sampled_from([1.5, True])),
    ("initial", of_scene("initial"), st.sampled_from(["bimodal", ""])),
    ("rtol", of_solve("rtol"),
     NOT_POSITIVE | st.floats(0.5, allow_infinity=False) | st.just(1e-15) | WORDS),
    ("nodes", of_solve("nodes"),
     st.integers(max_value=7) | st.integers(8193) | st.sampled_from([16.5, True])),
    ("method", of_solve("method"), st.sampled_from(["finite volumes", "", 3])),
    ("method", lambda v: solve(scene(initial="monoenergetic", outputs=("speed_density",)),
                               method=v), st.just("spectral")),
    ("scene", solve, st.none()),
    ("times", lambda t: solve(scene(restitution=1.0, times=[t], number_density=1e150,
                                    outputs=("collisions",))), st.just(1e300)),
    ("p", ask("moment"), st.floats(41.0, 1e300) | st.sampled_from([-2.0, math.nan, math.inf, "a"])),
    ("m", lambda m: solve(scene()).harmonic(1.0, m),
     st.integers(max_value=-1) | st.integers(257) | st.just(0.5)),
    ("outputs", ask("speed_density"), st.just([1.0])),
    ("v", ask("speed_density", "speed_density"), ELSEWHERE | st.just("fast")),
    ("r", ask("position_density", "position_density"), ELSEWHERE | st.sampled_from([[], [1e400]])),
    ("edges", ask("position_fraction", "position_density"),
     st.sampled_from([[1.0], [1.0, 1.0], [2.0, 1.0], [-1.0, 1.0]])),
    ("wave_numbers", ask("intermediate_scattering", "intermediate_scattering"),
     ELSEWHERE | st.sampled_from([[], [1e150]])),
    ("direction", lambda d: solve(scene(outputs=("intermediate_scattering",)), 1e-3)
     .intermediate_scattering([1.0], direction=d), st.just(math.nan)),
    ("restitution", solve_scaled, OUTSIDE_0_1 | st.just(1.0)),
    ("nodes", lambda n: solve_scaled(0.7, nodes=n), st.sampled_from([7, 10**6, 16.5])),
    ("p", lambda p: solve_scaled(0.7, 1e-3).moment(p), st.just(301.0)),
    ("c", lambda c: solve_scaled(0.7, 1e-3).vdf(c), NEGATIVE),
    ("deviation_x", lambda d: kinetics.Gaussian(d, 1.0), NOT_POSITIVE),
    ("speed", kinetics.Monoenergetic, NOT_POSITIVE),
    ("speed", kinetics.SpeedSamples, st.sampled_from([[], [0.0], [1.0, math.nan], [-1.0]])),
    ("speed", lambda v: kinetics.SpeedTable(v, [0.0, 1.0]), st.just([1.0, 1.0])),
    ("density", lambda f: kinetics.SpeedTable([0.0, 1.0, 2.0], f),
     st.sampled_from([[2.0, -1.0, 1.0], [2.0, 2.0, 2.0]])),
    ("direction", kinetics.Beam, NOT_FINITE),
    ("number_density", particles.BoltzmannGrad, NOT_POSITIVE),
    ("number_density", particles.Poisson, NOT_POSITIVE | st.just(1e-11)),
    ("number_density", particles.HardDisks, NOT_POSITIVE | st.sampled_from([0.7, 1e-11])),
    ("number_density", lambda d: particles.BoltzmannGrad(0.04, diameter=d), st.just(1e-300)),
    ("count", lambda n: particles.HardDisks(0.1, count=n), st.just(1)),
    ("positions", lambda x: particles.Positions(np.array([[x, 5.0]]), 10.0),
     st.sampled_from([5.0, math.nan])),
    ("box_side", lambda side: particles.Positions(np.zeros((1, 2)), side),
     st.sampled_from([3.0, 1e6])),
    ("restitution", run("restitution"), OUTSIDE_0_1),
    ("times", run("times"), st.sampled_from([None, [1.0, 1.0], [-1.0], [math.nan], [2e300]])),
    ("media", run("media"), NOT_A_COUNT),
    ("tracers", run("tracers"), NOT_A_COUNT | st.just(2**40)),
    ("max_collisions", run("max_collisions"), st.integers(max_value=0)),
    ("seed", run("seed"), st.integers(max_value=-1) | st.integers(2**64)),
    ("workers", run("workers"), NOT_A_COUNT),
    ("observables", run("observables"), st.just(("speed",))),
    ("initial", run("initial"), st.sampled_from(["bimodal", np.zeros((3, 2))])
     | st.sampled_from([0.0, 1e-151, 1e151, math.nan]).map(lambda v: np.full((2, 2), v))),
]  # fmt: skip
FUNCTIONS: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "negative": ("density", lambda v: np.cos(v) * np.exp(-v)),
    "of norm 1/2": ("density", lambda v: 0.5 * v * np.exp(-0.5 * v * v)),
    "NaN": ("initial", lambda v: np.full(np.shape(v), math.nan)),
    "without second moment": ("initial", lambda v: 1.0 / (1.0 + v) ** 2),
    "of another shape": ("initial", lambda v: 1.0),
}


def refused(argument: str, work: Callable[[], Any]) -> None:
    """One line that begins with the argument, meant as an answer to bad input.

    A ValueError from deep inside, of numpy say, is none.
    """
    with pytest.raises(ValueError, match=f"^{argument}") as met:
        work()
    where = met.traceback[-1].frame.f_globals["__name__"]
    assert isinstance(met.value, InputError) or where.startswith("particles.")
    assert "\n" not in str(met.value)


@pytest.mark.parametrize("k", range(len(BAD)), ids=lambda k: f"{BAD[k][0]}-{k}")
@few(max_examples=15)
@given(data=st.data())
def test_bad_input_is_refused(k: int, data: st.DataObject) -> None:
    argument, call, values = BAD[k]
    value = data.draw(values)
    refused(argument, lambda: call(value))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_bad_functions_are_refused(name: str) -> None:
    argument, function = FUNCTIONS[name]
    refused(argument, lambda: solve(scene(initial=function)))


def test_a_negative_moment_that_does_not_exist_is_refused() -> None:
    refused("p", lambda: solve(scene(restitution=0.0)).moment(-1.0))


# -- random scenes ---------------------------------------------------------------------------------

SIZES = st.floats(-100.0, 100.0).map(lambda x: 10.0**x)
RESTITUTIONS = st.one_of(
    st.floats(0.0, 1.0),
    st.floats(-12.0, 0.0).map(lambda x: 10.0**x),
    st.floats(-12.0, 0.0).map(lambda x: 1.0 - 10.0**x),
)
SPEEDS = np.array([1.0, 2.0, 4.0, 4.5826])


@pytest.mark.slow
@few(max_examples=40)
@given(
    e=RESTITUTIONS,
    number_density=SIZES,
    scale=SIZES,
    start=st.sampled_from(["gaussian", "monoenergetic", "samples"]),
    times=st.lists(st.floats(-200.0, 200.0), min_size=1, max_size=6, unique=True),
    rtol=st.floats(-12.0, -1.0).map(lambda x: 10.0**x),
)
def test_random_scenes_are_finite_cool_and_meet_their_limits(
    e: float, number_density: float, scale: float, start: str, times: list[float], rtol: float
) -> None:
    state, first = {
        "gaussian": (kinetics.Gaussian(scale, scale), (math.sqrt(2.0), 0.0)),
        "monoenergetic": (kinetics.Monoenergetic(scale), (1.0, -0.5)),
        "samples": (
            kinetics.SpeedSamples(scale * SPEEDS),
            (
                math.sqrt(np.mean(SPEEDS**2)),
                float(np.mean(SPEEDS**4) / (2 * np.mean(SPEEDS**2) ** 2)) - 1.0,
            ),
        ),
    }[start]
    when = np.concatenate([[0.0], 10.0 ** np.array(sorted(times))])
    solution = solve(
        Scene(e, number_density, initial=state, times=when, outputs=("thermal_speed", "a2")), rtol
    )
    speed, a2 = solution.thermal_speed, solution.a2
    assert np.all(np.isfinite(speed))
    assert np.all(np.isfinite(a2))
    assert np.all(speed > 0.0)
    assert growth(speed) <= max(GROWTH, rtol)
    assert below(a2, -0.5) <= rtol
    if solution.status.name == "CONVERGED":
        error = limit_errors(solution, (first[0] * scale, first[1]), rtol)
        assert not error > rtol + ROUNDING  # NaN where no time is early or late enough


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
