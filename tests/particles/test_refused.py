"""What is refused, each in one line that begins with the argument's name."""

from functools import partial
from typing import Any

import numpy as np
import pytest

import particles
from particles import BoltzmannGrad, HardDisks, HardSpheres, Poisson, PoissonSpheres, simulate

NAN, LONG = float("nan"), 10**400
GOOD: dict[str, Any] = dict(
    medium=BoltzmannGrad(0.5), restitution=0.5, times=[1.0], media=2, tracers=2, workers=1
)
DISKS, SPHERES = HardDisks(0.1, 400), HardSpheres(0.1, count=400)
PLACES = particles.Positions([[1.0, 1.0]], 6.0)
RUNS: list[tuple[str, list[Any], dict[str, Any]]] = [
    # argument; values of it; what else is asked
    ("restitution", [1.2, NAN, lambda v: 1 + v, lambda v: v[:3], lambda v: "hard",
                     ([1.0, 0.5], [0.5, 0.5]), ([0.5, 1.0], [0.5, 1.5])], {}),
    ("restitution", [particles.Viscoelastic(1)], dict(medium=DISKS, field=1.0)),
    ("tangential_restitution", ["rough"], {}),
    ("tangential_restitution", [0.0], dict(restitution=0.0)),
    ("times", [[True], ["1.0"], np.array(["1.0"], object)], {}),
    ("times", [[], [1.0, 1.0], [-1.0], None, [1 + 1j], np.ma.array([1.0, 2.0], mask=[0, 1])], {}),
    ("times", [None], dict(drag=1.0, max_collisions=9)),  # drag alone stops a tracer
    ("initial", ["maxwell", np.ones((3, 2)), np.full((2, 2), NAN), np.full((2, 2), 1e308),
                 np.zeros((2, 2)), "rest"], {}),
    ("initial", [np.ones((2, 2))], dict(medium=SPHERES)),
    ("initial", ["rest"], dict(drag=1.0)),
    ("media", [0], {}),
    ("tracers", [2.5], {}),
    ("max_collisions", [0], {}),
    ("seed", [-1, 10**5000], {}),
    ("workers", [10**6], {}),
    ("observables", [["speed"], [["a"]]], {}),
    ("observables", [["velocity_component_histogram"]], dict(field=1.0)),  # of |v_x|
    ("medium", ["Poisson"], {}),
    ("executor", [3], {}),
    ("progress", [3], {}),
    ("output", ["a\0b"], {}),
    ("resume", [True], {}),
    ("field", [NAN, "down", 1e200], {}),
    ("field", [1.0], dict(medium=SPHERES)),
    ("depth", [-1.0], dict(field=1.0)),
    ("depth", [1.0], {}),
    *(("mass_ratio", [2.0], dict(medium=m)) for m in (DISKS, Poisson(0.1), SPHERES, PLACES)),
    ("mass_ratio", [0.0, -1.0, 1e-7, NAN, "2", None], {}),
    ("mass_ratio", [2.0], dict(tangential_restitution=0.5)),
    ("bath_speed", [-1.0], {}),
    ("bath_speed", [1.0], dict(medium=DISKS)),
    ("bath_speed", [1.0], dict(tangential_restitution=0.5)),
    ("heating", [NAN], {}),
    ("drag", [1.0], dict(medium=SPHERES)),
    ("capture_speed", [0.1], dict(bath_speed=1.0)),
    ("capture_speed", [0.1], dict(mass_ratio=2.0)),
    ("capture_speed", [0.1], dict(medium=DISKS, field=1.0)),
]  # fmt: skip
START = partial(particles.Positions, box_side=10)
MEDIA: list[tuple[str, Any]] = [
    ("number_density", lambda: Poisson(-1, 10)),
    ("number_density", lambda: HardDisks(0.9, 1000)),
    ("number_density", lambda: HardDisks(0.04, diameter=1e308)),
    ("number_density", lambda: HardSpheres(0.1, 2.0)),
    ("number_density", lambda: PoissonSpheres(1.1)),
    ("number_density", lambda: PoissonSpheres(1e-11)),
    ("number_density", lambda: BoltzmannGrad(1e200, 1e200)),
    ("count", lambda: Poisson(1.0, 1)),
    ("count", lambda: HardDisks(0.1, 0)),
    ("count", lambda: HardDisks(0.04, LONG)),
    ("count", lambda: HardSpheres(0.1, count=None)),
    ("count", lambda: PoissonSpheres(0.1, count=5)),  # the box would be 3.68 d wide
    ("diameter", lambda: PoissonSpheres(0.1, 0.0)),
    ("diameter", lambda: BoltzmannGrad(0.1, diameter=NAN)),
    ("dimension", lambda: BoltzmannGrad(0.1, dimension=4)),
    ("number_density", lambda: HardDisks("0.04")),
    ("diameter", lambda: HardDisks(0.04, diameter=True)),
    ("box_side", lambda: particles.Positions([[1, 2]], 3.0)),
    ("positions", lambda: START([[5.5, 5]])),  # it covers the start
    ("positions", lambda: START([[1, 1], [0, 9.2]], start=(0, 0))),
    ("positions", lambda: START([[1, 1], [np.nan, 2]])),
    ("positions", lambda: START([[1, 1], [1, 1e14]])),
    ("positions", lambda: START([1, 2, 3])),
    ("positions", lambda: START([["a", "b"]])),
    ("positions", lambda: START(np.ones((1, 2), complex))),
    ("positions", lambda: START(np.ma.masked_all((1, 2)))),
    ("start", lambda: START([[1, 2]], start=(1,))),
    ("start", lambda: START([[1, 2]], start=(0, -1e308))),
    ("b", lambda: particles.Viscoelastic(-1.0)),
    ("speed", lambda: particles.Viscoelastic(0.3)("")),
    ("speed", lambda: particles.Viscoelastic(0.3)(-1.0)),
    *(("parts", partial(particles.Ensemble.merge, parts)) for parts in (3, None, np.array(1.0))),
    ("parts", lambda: particles.Ensemble.merge("a.h5")),
    ("name", lambda: simulate(**GOOD).plot(np.array(["a2", "msd"]))),
    *((n, lambda n=n, v=v: simulate(**GOOD).trajectories(**{"tracers": 1, n: v}))
      for n, v in (("tracers", 9), ("configuration", 2), ("until", -1.0), ("collisions", 1001))),
]  # fmt: skip


@pytest.mark.parametrize(("name", "call"), [
    *((name, partial(simulate, **GOOD | more | {name: value}))
      for name, values, more in RUNS for value in values),
    *MEDIA,
])  # fmt: skip
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_one_line_names_the_argument(name: str, call: Any) -> None:
    with pytest.raises(ValueError, match=rf"^{name}\W[^\n]*$") as refused:
        call()
    assert len(str(refused.value)) < 400
