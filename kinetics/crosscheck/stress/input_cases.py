"""Bad input: each case must be refused, in one line that names the argument."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome, named


def input_cases(quick: bool) -> Iterator[Case]:
    """All of them, in the quick sweep too: they cost nothing."""
    for argument, name, work in [*_scenes(), *_questions(), *_states(), *_particles()]:
        yield named("bad input", f"{argument}: {name}", _answer, work, refusal=argument)


Bad = tuple[str, str, Callable[[], Any]]


def _answer(work: Callable[[], Any]) -> Outcome:
    work()
    return Outcome()


def _scene(**changes: Any) -> Callable[[], Any]:
    def make() -> Any:
        from kinetics import Scene

        return Scene(**{"restitution": 0.7, "times": [1.0], **changes})

    return make


def _solve(ask: Callable[[Any], Any] = lambda found: None, **changes: Any) -> Callable[[], Any]:
    """Solve a scene, and ask the solution. Arguments of solve() among the changes are its own."""
    of_solve = {k: changes.pop(k) for k in ("rtol", "method", "nodes") if k in changes}

    def work() -> Any:
        from kinetics import solve

        return ask(solve(_scene(**changes)(), **of_solve))

    return work


def _scenes() -> Iterator[Bad]:
    nan, infinity = math.nan, math.inf
    for e in (-1e-300, 1.0 + 1e-15, nan, infinity, "0.7 or so", None):
        yield "restitution", repr(e), _scene(restitution=e)
    for name in ("number_density", "diameter"):
        for value in (0.0, -1.0, nan, infinity, "one"):
            yield name, repr(value), _scene(**{name: value})
    for rho in (1e-310, 1.7e308):
        yield "number_density", f"{rho} of diameter 2", _scene(number_density=rho, diameter=2.0)
    for times in ([], [1.0, 0.5], [-1e-300], [nan], [infinity], "soon", [[1.0]], [1j]):
        yield "times", repr(times), _scene(times=times)
    for outputs in ((), ("speed",), (1,)):
        yield "outputs", repr(outputs), _scene(outputs=outputs)
    for harmonics in (-1, 257, 1.5, True):
        yield "harmonics", repr(harmonics), _scene(harmonics=harmonics)
    for rtol in (0.0, -1e-9, 1e-15, 0.5, nan, infinity, "small"):
        yield "rtol", repr(rtol), _solve(rtol=rtol)
    for nodes in (7, 8193, 16.5, True, -8):
        yield "nodes", repr(nodes), _solve(nodes=nodes)
    yield "method", "'finite volumes'", _solve(method="finite volumes")
    density = ("speed_density",)
    yield (
        "method",
        "'spectral' for a delta peak",
        _solve(method="spectral", initial="monoenergetic", outputs=density),
    )
    yield "scene", "None", _nothing


def _nothing() -> Any:
    from kinetics import solve

    return solve(None)  # type: ignore[arg-type]


def _asking(method: str, *values: Any, **named_values: Any) -> Callable[[Any], Any]:
    """A call of this method of a solution."""
    return lambda found: getattr(found, method)(*values, **named_values)


def _questions() -> Iterator[Bad]:
    nan = math.nan
    for p in (41.0, nan, "two", math.inf):
        yield "p", repr(p), _solve(_asking("moment", p))
    yield "p", "-2 of a Gaussian", _solve(_asking("moment", -2.0))
    yield "p", "-1 at e = 0", _solve(_asking("moment", -1.0), restitution=0.0)
    for m in (-1, 257, 0.5):
        yield "m", repr(m), _solve(_asking("harmonic", 1.0, m))
    speeds = {"outputs": ("speed_density",), "rtol": 1e-3}
    for v in ([-1.0], [nan], "fast"):
        yield "v", repr(v), _solve(_asking("speed_density", v), **speeds)
    yield "outputs", "speed_density unasked", _solve(_asking("speed_density", [1.0]))
    place = {"outputs": ("position_density",), "rtol": 1e-3}
    for r in ([-1.0], [nan], [], [math.inf]):
        yield "r", repr(r), _solve(_asking("position_density", r), **place)
    for edges in ([1.0], [1.0, 1.0], [2.0, 1.0], [-1.0, 1.0]):
        yield "edges", repr(edges), _solve(_asking("position_fraction", edges), **place)
    waves = {"outputs": ("intermediate_scattering",), "rtol": 1e-3}
    for k in ([-1.0], [nan], [], [1e150]):
        yield "wave_numbers", repr(k), _solve(_asking("intermediate_scattering", k), **waves)
    ask = _asking("intermediate_scattering", [1.0], direction=nan)
    yield "direction", "nan", _solve(ask, **waves)
    elastic: dict[str, Any] = {"restitution": 1.0, "times": [1e300], "number_density": 1e150}
    yield "times", "elastic flights of 1e450 l", _solve(**elastic, outputs=("collisions",))
    from kinetics import solve_scaled

    for e in (1.0, -0.1, nan):
        yield "restitution", f"{e!r}, scaled", partial(solve_scaled, e)
    wrong: tuple[Any, ...] = (7, 10**6, 16.5)
    for nodes in wrong:
        yield "nodes", f"{nodes!r}, scaled", partial(solve_scaled, 0.7, nodes=nodes)
    yield "p", "301, scaled", lambda: solve_scaled(0.7).moment(301.0)
    yield "c", "-1, scaled", lambda: solve_scaled(0.7).vdf(-1.0)


def _states() -> Iterator[Bad]:
    from kinetics import Beam, Gaussian, Monoenergetic, SpeedSamples, SpeedTable

    for deviation in (0.0, -1.0, math.nan):
        yield "deviation_x", repr(deviation), partial(Gaussian, deviation, 1.0)
    for speed in (0.0, -1.0, math.inf):
        yield "speed", f"{speed!r}, monoenergetic", partial(Monoenergetic, speed)
    for samples in ([], [0.0], [1.0, math.nan], [-1.0]):
        yield "speed", f"{samples!r}, samples", partial(SpeedSamples, samples)
    yield "speed", "a table that does not rise", partial(SpeedTable, [1.0, 1.0], [0.0, 1.0])
    yield "density", "a negative table", partial(SpeedTable, [0.0, 1.0, 2.0], [2.0, -1.0, 1.0])
    yield "density", "a table of norm 2", partial(SpeedTable, [0.0, 1.0], [2.0, 2.0])
    yield "direction", "nan, beam", partial(Beam, math.nan)
    functions: dict[str, Callable[[Any], Any]] = {
        "negative": lambda v: np.cos(v) * np.exp(-v),
        "of norm 1/2": lambda v: 0.5 * v * np.exp(-0.5 * v * v),
        "NaN": lambda v: np.full(np.shape(v), math.nan),
        "without second moment": lambda v: 1.0 / (1.0 + v) ** 2,
        "of another shape": lambda v: 1.0,
    }
    for name, function in functions.items():
        # a bad norm or sign is the density's, what cannot be called is the argument's
        argument = "density" if name in ("negative", "of norm 1/2") else "initial"
        yield argument, f"a function {name}", _solve(initial=function)
    yield "initial", "'bimodal'", _scene(initial="bimodal")


def _particles() -> Iterator[Bad]:
    from particles import BoltzmannGrad, HardDisks, Poisson, Positions, simulate

    for medium in (BoltzmannGrad, Poisson, HardDisks):
        for rho in (0.0, -1.0, math.nan, math.inf):
            name = f"{rho!r}, {medium.__name__}"
            yield "number_density", name, partial(medium, rho)
    yield "number_density", "0.7, HardDisks", partial(HardDisks, 0.7)
    for thin in (HardDisks, Poisson):
        yield "number_density", f"1e-11, {thin.__name__}", partial(thin, 1e-11)
    yield "number_density", "no free path", partial(BoltzmannGrad, 0.04, diameter=1e-300)
    yield "box_side", "one disk in 1e6 d", partial(Positions, np.zeros((1, 2)), 1e6)
    yield "count", "one disk in too small a box", partial(HardDisks, 0.1, count=1)
    yield "positions", "a disk upon the start", partial(Positions, np.array([[5.0, 5.0]]), 10.0)
    yield "positions", "NaN", partial(Positions, np.array([[math.nan, 5.0]]), 10.0)
    yield "box_side", "3", partial(Positions, np.zeros((1, 2)), 3.0)

    def run(**changes: Any) -> Callable[[], Any]:
        given: dict[str, Any] = {
            "restitution": 0.5,
            "times": [1.0],
            "media": 1,
            "tracers": 2,
            "workers": 1,
        }
        return lambda: simulate(BoltzmannGrad(0.04), **{**given, **changes})

    bad: dict[str, tuple[Any, ...]] = {
        "restitution": (-0.1, 1.1, math.nan),
        "times": ([1.0, 1.0], [-1.0], [math.nan], [2e300]),
        "media": (0, -1, 1.5),
        "tracers": (0, 2**40),
        "max_collisions": (0, -1),
        "seed": (-1, 2**64),
        "workers": (0, 1.5),
        "observables": (("speed",),),
        "initial": (
            np.full((2, 2), 1e-151),
            np.full((2, 2), 1e151),
            "bimodal",
            np.zeros((2, 2)),
            np.zeros((3, 2)),
            np.full((2, 2), math.nan),
        ),
    }
    for argument, values in bad.items():
        for value in values:
            yield argument, f"{' '.join(repr(value).split())}, simulate", run(**{argument: value})
    yield "times", "none, and no cap, simulate", run(times=None)
