"""Scenes of any kind: solved within their own error, or refused."""

from typing import Any

import numpy as np
from fuzzing import broken, extremes, fuzz, geometric, keeps, laws, mostly, points, tried
from hypothesis import strategies as st

from kinetics import (
    AngularHarmonics,
    Beam,
    Gaussian,
    Monoenergetic,
    PolarGrid,
    Scene,
    SolverStatus,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
    VelocitySamples,
    solve,
)
from kinetics.crosscheck.stress_invariants import Violation, invariants
from kinetics.crosscheck.stress_work import largest_difference, solve_again
from kinetics.moments.outputs import averaged_outputs
from kinetics.outputs import FIELD_OUTPUTS, OUTPUTS


def bell(v: Any) -> Any:
    with np.errstate(all="ignore"):
        return np.minimum(v, 1e100) * np.exp(-0.5 * np.minimum(v, 1e100) ** 2)


number = mostly(geometric(0.1, 10.0), extremes)
functions = mostly([bell], st.sampled_from([
    lambda v: 2.0 * bell(v), lambda v: -bell(v), lambda v: v * np.nan, lambda v: v[:1],
]) | broken)  # fmt: skip
table = st.lists(st.floats(0.0, 1.0), min_size=3, max_size=5).map(
    lambda f: np.array(f) / (0.7 * (sum(f) - 0.5 * (f[0] + f[-1])) or 1.0)
)
pairs = st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3)), max_size=4)
speed = np.linspace(0.0, 2.0, 5)
grid = np.full((5, 3), 1.0 / (np.pi * 4.0))
states = st.one_of(
    st.tuples(st.just(Gaussian), number, number),
    st.tuples(st.just(Monoenergetic), number),
    table.map(lambda f: (SpeedTable, 0.7 * np.arange(len(f)), f)),
    st.tuples(st.just(SpeedSamples), mostly(st.lists(geometric(0.1, 10.0), max_size=5))),
    st.tuples(st.just(SpeedDensity), functions),
    st.tuples(st.just(Beam), mostly(st.floats(-4.0, 4.0), extremes), mostly(["gaussian"])),
    st.tuples(st.just(VelocitySamples), mostly(pairs)),
    st.tuples(st.just(AngularHarmonics), mostly([{0: bell, 2: lambda v: 0.5 * bell(v)}])),
    st.tuples(st.just(PolarGrid), st.just(speed), mostly([grid])),
)
times = st.lists(mostly(geometric(1e-2, 1e4), st.sampled_from([0.0, 5e-324, 1e-300, 1e100, 1e300])),
                 min_size=1, max_size=3)  # fmt: skip
CHEAP = [name for name in OUTPUTS if name in averaged_outputs(2)]
LATE = ["position_density", "intermediate_scattering"]  # early ones take seconds
LATER = {"times": st.just([1e3, 7e3])}
DENSE = [name for name in OUTPUTS if name not in CHEAP and name not in LATE]
SYSTEM: dict[str, Any] = {
    **laws,
    "number_density": mostly([0.04], extremes),
    "diameter": mostly([1.0], extremes),
    "initial": st.sampled_from(["gaussian", "monoenergetic"]) | mostly(states),
    "times": mostly(times.map(sorted)),
    "harmonics": mostly(st.integers(0, 3)),
}


def solved(system: dict[str, Any], rtol: Any, **options: Any) -> Any:
    if isinstance(system["initial"], tuple) and callable(system["initial"][0]):
        kind, *arguments = system["initial"]
        system = system | {"initial": tried(kind, *arguments)}
    scene = tried(Scene, **system)
    found = None if scene is None else tried(solve, scene, rtol, **options)
    if found is not None:
        repr(scene), hash(scene), repr(found)
        # of what is not reached the estimate itself is no more than a size
        more = 1.0 if found.status is SolverStatus.CONVERGED else 2.0
        violations = tried(invariants, found) or {}  # it may ask for wave numbers out of range
        keeps({n: Violation(v.size, more * v.allowed) for n, v in violations.items()})
        assert found.message
        if found.status is SolverStatus.CONVERGED:
            assert found.error_estimate <= 1.1 * max(found.rtol, 1e-8)
    return found


@fuzz(
    20, system=st.fixed_dictionaries(SYSTEM | {
        "outputs": mostly(st.lists(st.sampled_from(CHEAP), min_size=1, max_size=4)),
        "scatterers": mostly(["dilute", "dilute", "overlapping", "hard disks"]),
    }), rtol=mostly([1e-2, 1e-4, 1e-8, 1e-10, 1e-12]), power=mostly(st.floats(-1.5, 6.0), extremes),
    order=mostly(st.integers(0, 3)),
)  # fmt: skip
def test_averages(system: Any, rtol: Any, power: Any, order: Any) -> None:
    found = solved(system, rtol)
    if found is None:
        return
    if found.status is SolverStatus.CONVERGED:
        fine = solve_again(found, 1e-12)
        assert largest_difference(found, fine) <= 1.5 * (found.rtol + fine.error_estimate)
    for moment in (tried(found.moment, power), tried(found.harmonic, power, order)):
        assert moment is None or np.all(np.isfinite(moment))


@fuzz(
    12, system=st.sampled_from(DENSE + LATE).flatmap(lambda name: st.fixed_dictionaries(
        SYSTEM | {"outputs": mostly([(name,)])} | (LATER if name in LATE else {}))),
    rtol=mostly([1e-2, 1e-3]), method=mostly([None, None, "spectral", "conservative"]),
    nodes=mostly(st.none() | st.integers(8, 64)), at=points,
)  # fmt: skip
def test_densities(system: Any, rtol: Any, method: Any, nodes: Any, at: Any) -> None:
    found = solved(system, rtol, method=method, nodes=nodes)
    outputs = () if found is None else found.scene.outputs
    names = [name for name in (*LATE, "speed_density") if name in outputs]
    names += ["velocity_component_density"] * ("speed_density" in names)
    for name in names:
        values = tried(getattr(found, name), at)
        if values is None:
            continue
        if name == "velocity_component_density":  # it may be infinite at 0, but nowhere else
            values = np.where(np.asarray(at, float) == 0.0, 0.0, values)
        assert np.all(np.isfinite(values))


@fuzz(
    8, system=st.fixed_dictionaries(SYSTEM | {
        "field": mostly(geometric(1e-3, 1e2), extremes),
        "initial": mostly(["gaussian", "monoenergetic", "rest"]), "harmonics": st.just(0),
        "times": mostly(st.lists(geometric(1e-2, 1e3), min_size=1, max_size=2).map(sorted)),
        "outputs": mostly(st.lists(st.sampled_from(sorted(FIELD_OUTPUTS)), min_size=1, max_size=3)),
    }),
)  # fmt: skip
def test_averages_in_a_field(system: Any) -> None:
    solved(system, 1e-3)
