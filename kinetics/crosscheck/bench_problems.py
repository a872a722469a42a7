"""What the benchmark measures: the table of problems, and runs of particles, as pieces of `Work`.

Errors are relative to references of 1e-12 or better; of G(R), <r^2> among hard disks and driven
tracers, of which nothing else is known, to a tighter solution.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics import ScalingSolution, Scene, solve, solve_field, solve_scaled, solve_steady
from kinetics.crosscheck import references
from particles import (
    BoltzmannGrad,
    HardDisks,
    HardSpheres,
    Medium,
    Poisson,
    PoissonSpheres,
    simulate,
)

FloatArray = NDArray[np.float64]

#: Section of the rows that hold run time against error.
PRECISION = "precision"
#: Section of the rows of particles, and the case that makes them.
PARTICLES = "particles"
#: Name of this package's own method in the tables.
SPECTRAL = "spectral"
#: What `--case` may choose; `cli.bench` repeats them, as this module is slow to import.
CASES = ("scaled", "cooling", "position", "field", "driven", PARTICLES)
#: Scatterers per d^2, of the paper: l is `references.MEAN_FREE_PATH`.
DENSITY = 0.04
#: Restitution of a quick benchmark, one of the paper's.
RESTITUTION = 0.7
#: Relative tolerances that are asked for. Chosen: one in each decade.
TOLERANCES = tuple(10.0**-digits for digits in range(2, 13))
#: c at which F(c) is compared. The origin of range and number is not recorded.
SPEEDS = np.linspace(0.1, 4.0, 391)
#: R at which G(R) is compared. The origin of range and number is not recorded.
RADII = np.linspace(0.0, 6.0, 200)
#: Restitution of G(R), one of the paper's.
POSITION_RESTITUTION = 0.6
#: Time in d/U at which G(R) is compared, the paper's for this restitution.
POSITION_TIME = 300.0
#: Restitution of the particles, one of the paper's.
PARTICLE_RESTITUTION = 0.9
#: Scatterers per d^3. Derived: l = 1/(pi n d^2) is 10 d, near the 12.5 d of the plane.
SPACE_DENSITY = 0.1 / math.pi
#: Scatterers in a box. The origin of the number is not recorded.
COUNT = 10_000
#: Configurations of a run. The origin of the number is not recorded.
MEDIA = 4


@dataclass(frozen=True)
class Effort:
    """How much is measured.

    Parameters
    ----------
    min_repeats, max_repeats : of each work
    seconds : for which work is repeated between these numbers
    restitutions : of which each problem is solved
    tracers : in each configuration of a long run of particles
    """

    quick: bool = True
    min_repeats: int = 5
    max_repeats: int = 11
    seconds: float = 0.04
    restitutions: tuple[float, ...] = (RESTITUTION,)
    tracers: int = 300


#: Effort of `--quick`, about a minute in all.
QUICK = Effort()
#: Effort of the whole benchmark, about ten minutes in all.
FULL = Effort(
    quick=False,
    min_repeats=10,
    max_repeats=25,
    seconds=0.12,
    restitutions=(RESTITUTION, 0.95),
    tracers=2000,
)


@dataclass(frozen=True)
class Work:
    """One row that is to be measured.

    Parameters
    ----------
    section, problem, method, setting, value : the row's own columns
    call : what is measured
    error : of its result; None where only the time counts
    threads : the time of one thread is the processor's, of more that of the clock
    """

    section: str
    problem: str
    method: str
    call: Callable[[], object]
    setting: str = ""
    value: float | None = None
    error: Callable[[object], float] | None = None
    threads: int = 1


# -- problems: run time against error --------------------------------------------------------------
def relative_error(values: ArrayLike, exact: ArrayLike) -> float:
    """Return the largest relative error."""
    with np.errstate(all="ignore"):
        return float(np.max(np.abs(np.asarray(values) / np.asarray(exact) - 1.0)))


def error_over_largest(values: ArrayLike, exact: ArrayLike) -> float:
    """Return the largest difference over the largest value."""
    difference = np.max(np.abs(np.asarray(values) - np.asarray(exact)))
    return float(difference / np.max(exact))


@dataclass(frozen=True)
class Problem:
    """What is solved for each of the tolerances, and compared with exact values.

    Parameters
    ----------
    case : one of `CASES`
    name : the question, and after ": " its variant
    solve : maps a relative tolerance to values
    exact : the values; a number: the tolerance of a solution that is taken for exact
    error : of values, beside the exact ones
    """

    case: str
    name: str
    solve: Callable[[float], FloatArray]
    exact: FloatArray | float
    error: Callable[[ArrayLike, ArrayLike], float] = relative_error
    tolerances: Sequence[float] = TOLERANCES

    def works(self) -> Iterator[Work]:
        """Yield a work for each tolerance; the exact values are solved for first if need be."""
        exact = self.solve(self.exact) if isinstance(self.exact, float) else self.exact

        def error_of(values: object) -> float:
            return self.error(np.asarray(values), exact)

        for tolerance in self.tolerances:
            call = partial(self.solve, tolerance)
            yield Work(PRECISION, self.name, SPECTRAL, call, "rtol", tolerance, error_of)


def averages_of(answer: object, names: Iterable[str]) -> FloatArray:
    """Return averages of an answer by name; 1 + a2, which is never 0, for a2."""
    averages = []
    for name in names:
        values = np.asarray(getattr(answer, name))
        averages.append(1.0 + values if name == "a2" else values)
    return np.array(averages)


def problems(effort: Effort) -> Iterator[Problem]:
    """Yield every problem; nothing is solved yet."""
    for restitution in effort.restitutions:
        yield _scaled_problem(restitution)
    yield from _problems_with_references(effort)
    yield _hard_disk_problem()
    yield _position_problem(effort)
    yield _field_problem()
    yield _driven_problem("a bath", bath_speed=1.0, mass_ratio=4.0)
    yield _driven_problem("noise", heating=1.0)


def _scaled_problem(restitution: float) -> Problem:
    """Return F(c) against its closed form."""

    def solve_to(rtol: float) -> FloatArray:
        return np.asarray(solve_scaled(restitution, rtol).vdf(SPEEDS))

    exact = ScalingSolution(restitution).vdf(SPEEDS)
    name = f"scaled F(c): e = {restitution:g}"
    return Problem("scaled", name, solve_to, exact, error_over_largest)


@dataclass(frozen=True)
class KeptAverages:
    """Averages over time of which `references` hold digits, and until which horizon."""

    case: str
    title: str
    outputs: tuple[str, ...]
    horizon: str


KEPT_AVERAGES = (
    KeptAverages("cooling", "v0(t), a2(t)", ("thermal_speed", "a2"), "short"),
    KeptAverages("cooling", "v0(t), a2(t)", ("thermal_speed", "a2"), "long"),
    KeptAverages("position", "<r^2>(t)", ("msd",), "short"),
    KeptAverages("position", "kurtosis(t)", ("kurtosis",), "short"),
)


def _problems_with_references(effort: Effort) -> Iterator[Problem]:
    """Yield averages over time, of each restitution and start."""
    for kept in KEPT_AVERAGES:
        for restitution in effort.restitutions:
            for start in references.STARTS:
                yield _problem_with_references(kept, restitution, start)


def _problem_with_references(kept: KeptAverages, restitution: float, start: str) -> Problem:
    """Return averages over time against the kept digits."""
    times = references.times(kept.horizon)
    scene = Scene(restitution, DENSITY, initial=start, times=times, outputs=kept.outputs)

    def solve_to(rtol: float) -> FloatArray:
        return averages_of(solve(scene, rtol=rtol), kept.outputs)

    exact = []
    for name in kept.outputs:
        values = references.kept(name, restitution, start, kept.horizon)
        exact.append(1.0 + values if name == "a2" else values)
    name = f"{kept.title}, t <= {times[-1]:.0e}: {start}, e = {restitution:g}"
    return Problem(kept.case, name, solve_to, np.array(exact))


def _hard_disk_problem() -> Problem:
    """Return <r^2> among hard disks against a tighter solution."""
    scene = Scene(
        RESTITUTION,
        DENSITY,
        times=np.geomspace(1.0, 1e8, 100),
        outputs=("msd",),
        scatterers="hard disks",
    )

    def solve_to(rtol: float) -> FloatArray:
        return averages_of(solve(scene, rtol=rtol), ("msd",))

    name = f"<r^2>(t) among hard disks, t <= 1e+08: e = {RESTITUTION:g}"
    return Problem("position", name, solve_to, 1e-13, tolerances=TOLERANCES[:-2])


def _position_problem(effort: Effort) -> Problem:
    """Return G(R) against a tighter solution."""
    outputs = ("position_density",)
    scene = Scene(POSITION_RESTITUTION, DENSITY, times=[POSITION_TIME], outputs=outputs)

    def solve_to(rtol: float) -> FloatArray:
        return np.asarray(solve(scene, rtol).scaled_position_density(RADII)[0])

    name = f"G(R): gaussian, t = {POSITION_TIME:g}, e = {POSITION_RESTITUTION:g}"
    if effort.quick:
        tolerances: Sequence[float] = (1e-2, 1e-4, 1e-5)
        return Problem("position", name, solve_to, 1e-7, error_over_largest, tolerances)
    return Problem("position", name, solve_to, 1e-8, error_over_largest, TOLERANCES[:6])


#: The steady state in a field at `RESTITUTION`, l = g = 1: digits of a program of its own.
STEADY_IN_FIELD = {
    "drift": 0.501926119920,
    "mean_square_speed": 1.702146383757,
    "mean_square_along": 1.061388235142,
    "mean_speed": 1.160252548014,
}


def _field_problem() -> Problem:
    """Return the steady state in a field against kept digits."""

    def solve_to(rtol: float) -> FloatArray:
        return averages_of(solve_field(RESTITUTION, rtol=rtol), STEADY_IN_FIELD)

    name = f"steady state in a field: e = {RESTITUTION:g}"
    exact = np.array([*STEADY_IN_FIELD.values()])
    return Problem("field", name, solve_to, exact, tolerances=TOLERANCES[:9])


def _driven_problem(title: str, **drive: Any) -> Problem:
    """Return the steady state of a driven tracer against a tighter solution."""

    def solve_to(rtol: float) -> FloatArray:
        state = solve_steady(RESTITUTION, **drive, rtol=rtol)
        return averages_of(state, ("thermal_speed", "diffusion_coefficient"))

    name = f"steady state, {title}: e = {RESTITUTION:g}"
    return Problem("driven", name, solve_to, 1e-12, tolerances=TOLERANCES[:9])


def works(case: str, effort: Effort) -> Iterator[Work]:
    """Yield the works of a case."""
    if case == PARTICLES:
        yield from particle_works(effort)
        return
    for problem in problems(effort):
        if problem.case == case:
            yield from problem.works()


# -- particles -------------------------------------------------------------------------------------
#: Method of the row of a run of one collision, whose time is that of placing the scatterers.
PLACING = "placing"
#: Method of the row of a long run.
RUN = "run"
#: Collisions of each tracer of the long run. The origin of the number is not recorded.
COLLISIONS_OF_RUN = 500


def particle_works(effort: Effort) -> Iterator[Work]:
    """Yield runs of one and of two threads in all media, and of one in a bath."""
    media: dict[str, Medium] = {
        f"hard disks, {density:g} per d^2": HardDisks(density, COUNT)
        for density in (0.005, DENSITY, 0.5)
    }
    media["overlapping disks, 0.04 per d^2"] = Poisson(DENSITY, COUNT)
    media["Boltzmann-Grad, 0.04 per d^2"] = BoltzmannGrad(DENSITY)
    media["hard spheres, 0.032 per d^3"] = HardSpheres(SPACE_DENSITY, count=COUNT)
    media["overlapping spheres, 0.032 per d^3"] = PoissonSpheres(SPACE_DENSITY, count=COUNT)
    media["Boltzmann-Grad, 0.032 per d^3"] = BoltzmannGrad(SPACE_DENSITY, dimension=3)
    for name, medium in media.items():
        for threads in (1, 2):
            yield from _runs(name, medium, threads, effort)
    bath = BoltzmannGrad(DENSITY)
    yield from _runs("Boltzmann-Grad, 0.04 per d^2, bath", bath, 1, effort, bath_speed=1.0)


def _runs(
    name: str, medium: Medium, threads: int, effort: Effort, bath_speed: float = 0.0
) -> Iterator[Work]:
    """Yield the run of one collision and the long one."""
    for setting, tracers, max_collisions in (
        (PLACING, 1, 1),
        (RUN, effort.tracers, COLLISIONS_OF_RUN),
    ):
        call = partial(
            simulate,
            medium,
            PARTICLE_RESTITUTION,
            max_collisions=max_collisions,
            media=MEDIA,
            tracers=tracers,
            workers=threads,
            bath_speed=bath_speed,
        )
        collisions = float(max_collisions * tracers * MEDIA)
        yield Work(PARTICLES, name, setting, call, "collisions", collisions, threads=threads)
