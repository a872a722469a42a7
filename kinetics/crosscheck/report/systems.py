"""What a report compares: smooth disks as in the paper, any other law, spheres, a drive.

A `Cooling` gas is left alone; a `Driven` one is in a field, in a bath or heated, or has a
restitution that depends on the impact speed. Both are a `System`: what follows this file uses its
members alone. InputError for what cannot be used.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

from kinetics.collision import CollisionLaw, law_of
from kinetics.collision.impact import Viscoelastic
from kinetics.validation import check_positive, check_restitution, check_rtol, refuse, whole_number

SCATTERERS = {2: "disks", 3: "spheres"}
#: Final time in d/U of each restitution in the paper (captions of its figures 5 and 6).
PAPER_FINAL_TIME = {0.4: 3000.0, 0.6: 300.0, 0.7: 500.0, 0.9: 1000.0}
#: Final time in d/U of any other restitution. Chosen: within the range of the paper's.
USUAL_FINAL_TIME = 1000.0
#: Largest number of tracers of one run: indices of tracers are 32-bit integers.
MAX_TRACERS = 2**31
#: Largest of the other whole numbers, which NumPy holds as 64-bit integers.
MAX_INTEGER = 2**63


def half_cross_section(dimension: int) -> float:
    """Return 1/(2 l rho0) in d^(dimension - 1): the diameter of disks, pi/2 for spheres."""
    if dimension == 2:
        return 1.0
    return math.pi / 2


@dataclass
class System:
    """What all systems have.

    Parameters
    ----------
    restitutions : those that are compared; none: the usual ones of the system
    rtol : relative tolerance of the solver
    seed : of every random number
    workers : threads; None: one per processor
    name : of the files that are written
    """

    restitutions: tuple[float, ...] = ()
    rtol: float = 1e-10
    seed: int = 1
    workers: int | None = None
    name: str = "report"
    dimension: int = field(default=2, kw_only=True)

    def _check(self) -> None:
        """Raise InputError for values that no system can use."""
        checked = tuple(check_restitution(e) for e in self.restitutions)
        if len(set(checked)) != len(checked):
            refuse("restitutions", checked, "each may stand only once")
        self.restitutions = checked
        whole_number("seed", self.seed, 0, MAX_INTEGER)
        if self.workers is not None:
            whole_number("workers", self.workers, 1, MAX_TRACERS)
        check_rtol(self.rtol)

    @property
    def values(self) -> tuple[float, ...]:
        """Values of the `parameter`: there is a case for each of them."""
        return self.restitutions

    @property
    def parameter(self) -> str:
        """Symbol of the parameter that differs between cases: "e" (or "b", see `Driven`)."""
        return "e"

    @property
    def is_papers_law(self) -> bool:
        """Whether scatterers are smooth disks in the plane, for which the paper's formulas are."""
        return False

    @property
    def scatterers(self) -> str:
        """What tracers hit: "disks" or "spheres"."""
        return SCATTERERS[self.dimension]

    @property
    def settings(self) -> dict[str, Any]:
        """The settings by name, as the report lists them."""
        return {entry.name: getattr(self, entry.name) for entry in fields(self)}


@dataclass
class Cooling(System):
    """Tracers that are left alone from a Gaussian start, and lose speed at every bounce.

    Times are in d/U, densities in d^-2, or d^-3 in space.

    Parameters
    ----------
    restitutions : none: those of the paper
    final_times : one for each restitution, or one for all; none: the paper's, 1000 of others
    number_density : of the scatterers
    count : hard disks, or spheres, in the box
    media : configurations of them
    tracers : in each configuration
    free_tracers : of the Boltzmann-Grad run, which has no configurations
    n_times : number of output times
    position_rtol : tolerance of G(R), which costs most and is only drawn
    tangential_restitution : what a collision leaves of the tangential velocity
    dimension : 2, or 3 for spheres
    """

    final_times: tuple[float, ...] = ()
    number_density: float = 0.04
    count: int = 40_000
    media: int = 100
    tracers: int = 100
    free_tracers: int = 1_000_000
    n_times: int = 24
    position_rtol: float = 1e-6
    tangential_restitution: float = 1.0

    def __post_init__(self) -> None:
        self.restitutions = self.restitutions or tuple(PAPER_FINAL_TIME)
        self._check()
        whole_number("count", self.count, 1, MAX_INTEGER)
        whole_number("media", self.media, 2, MAX_INTEGER)
        whole_number("tracers", self.tracers, 1, MAX_INTEGER)
        whole_number("free_tracers", self.free_tracers, 2, MAX_TRACERS)
        whole_number("n_times", self.n_times, 2, MAX_INTEGER)
        check_rtol(self.position_rtol)
        self.final_times = self._one_time_each()
        check_positive("number_density", self.number_density)
        law = self.law(self.restitutions[0])
        if law.tangential_restitution is not None:
            self.tangential_restitution = law.tangential_restitution
        self.dimension = law.dimension

    def _one_time_each(self) -> tuple[float, ...]:
        """Return the final time of each restitution."""
        usual = tuple(PAPER_FINAL_TIME.get(e, USUAL_FINAL_TIME) for e in self.restitutions)
        times = tuple(check_positive("until", t) for t in self.final_times or usual)
        count = len(self.restitutions)
        if len(times) == 1:
            return times * count
        if len(times) != count:
            refuse("until", len(times), f"there must be one for each of {count} restitutions")
        return times

    @property
    def stages(self) -> int:
        """How often a report of this system tells its progress."""
        return 3 * len(self.restitutions) + 2

    def law(self, restitution: float) -> CollisionLaw:
        """Return the collision law of one restitution."""
        return law_of(restitution, self.tangential_restitution, self.dimension)

    @property
    def is_smooth(self) -> bool:
        """Whether a bounce keeps the tangential velocity."""
        return self.tangential_restitution == 1.0

    @property
    def is_papers_law(self) -> bool:
        """Whether scatterers are smooth disks in the plane, for which the paper's formulas are."""
        return self.is_smooth and self.dimension == 2

    @property
    def hard(self) -> str:
        """Source of the particles among scatterers with places: "hard disks" or "hard spheres"."""
        return f"hard {self.scatterers}"

    @property
    def half_rate(self) -> float:
        """1/(2 l) in 1/d, l the mean free path of the kinetic equation: in the plane d rho0."""
        return self.number_density * half_cross_section(self.dimension)

    def quick(self) -> Self:
        """Return the system with fewer samples, and with fewer digits of what costs most."""
        return replace(
            self,
            media=min(self.media, 40),
            tracers=min(self.tracers, 25),
            free_tracers=min(self.free_tracers, 100_000),
            position_rtol=max(self.position_rtol, 1e-5),
        )


@dataclass(frozen=True)
class DriveOfReport:
    """What drives the tracers of a report, and what is usual then.

    Parameters
    ----------
    arguments : as a Scene and `simulate` take them
    initial : the initial state
    values : usual restitutions (of viscoelastic scatterers: usual b)
    collisions : about so many in each run, which sets the number of its tracers
    quick_values : instead of `values` in a quick report; empty: the same
    """

    arguments: Mapping[str, float]
    initial: str
    values: tuple[float, ...]
    collisions: int
    quick_values: tuple[float, ...] = ()


#: What may drive the tracers of a report, by name. The origin of the numbers of collisions is not
#: recorded.
DRIVES = {
    "field": DriveOfReport(
        {"field": 1.0},
        "rest",
        (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98),
        8_000_000,
        quick_values=(0.0, 0.5, 0.9),
    ),
    # Scatterers that move, infinitely heavy.
    "bath": DriveOfReport({"bath_speed": 1.0}, "gaussian", (0.5,), 10_000_000),
    # Noise takes many short steps.
    "heated": DriveOfReport({"heating": 1.0}, "gaussian", (0.5,), 2_000_000),
    # Nothing drives; the restitution falls with the impact speed, and the values are those of b.
    "viscoelastic": DriveOfReport({}, "gaussian", (0.45,), 10_000_000),
}
#: Name in `DRIVES` of scatterers whose restitution falls with the impact speed.
VISCOELASTIC = "viscoelastic"


@dataclass
class Driven(System):
    """Tracers of the dilute limit that something drives, one of `DRIVES` by name.

    Lengths are in l, times in l/U, in a field sqrt(g l) and sqrt(l/g). Restitutions are below 1.

    Parameters
    ----------
    time_rtol : tolerance of the solver over time
    collisions : in each run; 0: as usual
    most_tracers : tracers of a run at most
    groups : independent groups of tracers, from which the errors are
    viscoelastic : values of b, for viscoelastic scatterers, which have no restitutions
    """

    rtol: float = 1e-8
    name: str = "bath"
    time_rtol: float = 1e-6
    collisions: int = 0
    most_tracers: int = 200_000
    groups: int = 100
    viscoelastic: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        usual = DRIVES[self.name]
        self.collisions = self.collisions or usual.collisions
        if self.is_viscoelastic:
            self.viscoelastic = tuple(sorted(self.viscoelastic or usual.values))
        else:
            self.restitutions = tuple(sorted(self.restitutions or usual.values))
        self._check()
        whole_number("groups", self.groups, 10, MAX_INTEGER)
        whole_number("collisions", self.collisions, 1, MAX_INTEGER)
        whole_number("most_tracers", self.most_tracers, 100, MAX_INTEGER)
        check_rtol(self.time_rtol)
        if 1.0 in self.restitutions:
            allowed = "each must be below 1: elastic tracers reach no steady state"
            refuse("restitutions", self.restitutions, allowed)
        CollisionLaw(0.5, 1.0, self.dimension)
        for value in self.values:
            self.law(value)

    @property
    def is_viscoelastic(self) -> bool:
        """Whether scatterers are viscoelastic, which nothing drives."""
        return self.name == VISCOELASTIC

    @property
    def drive(self) -> Mapping[str, float]:
        """What drives, as a Scene and `simulate` take it."""
        return DRIVES[self.name].arguments

    @property
    def initial(self) -> str:
        """The initial state."""
        return DRIVES[self.name].initial

    @property
    def values(self) -> tuple[float, ...]:
        """Values of the `parameter`: there is a case for each of them."""
        if self.is_viscoelastic:
            return self.viscoelastic
        return self.restitutions

    @property
    def parameter(self) -> str:
        """Symbol of the parameter that differs between cases: e, or b of viscoelastic impacts."""
        if self.is_viscoelastic:
            return "b"
        return "e"

    @property
    def stages(self) -> int:
        """How often a report of this system tells its progress."""
        return 2 * len(self.values) + 2

    @property
    def settings(self) -> dict[str, Any]:
        """The settings by name, as the report lists them."""
        return super().settings | {"drive": dict(self.drive), "initial": self.initial}

    def law(self, value: float) -> float | Viscoelastic:
        """Return the restitution of one value, as a Scene and `simulate` take it."""
        if self.is_viscoelastic:
            return Viscoelastic(value)
        return value

    def quick(self) -> Self:
        """Return the system with fewer samples, and fewer restitutions unless others are asked."""
        restitutions = self.restitutions
        usual = DRIVES[self.name]
        if usual.quick_values and restitutions == usual.values:
            restitutions = usual.quick_values
        return replace(
            self,
            restitutions=restitutions,
            collisions=min(self.collisions, 500_000),
            most_tracers=min(self.most_tracers, 10_000),
            time_rtol=max(self.time_rtol, 1e-5),
        )
