"""What a report compares: smooth disks as in the paper, any other law, spheres, a drive.

`Cooling` is a gas that is left alone, `Driven` one in a field, in a bath or heated, or with a
restitution of the impact speed: values with the same few members, so that everything after this
file takes any. InputError for what cannot be used.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple, Self

from kinetics.collision import CollisionLaw, law_of
from kinetics.collision.impact import Viscoelastic
from kinetics.validation import check_positive, check_restitution, check_rtol, refuse, whole_number

SCATTERERS = {2: "disks", 3: "spheres"}
PAPER_FINAL_TIME = {0.4: 3000.0, 0.6: 300.0, 0.7: 500.0, 0.9: 1000.0}
"""Final time in d/U of each restitution in the paper (captions of its figures 5 and 6)."""


def half_cross_section(dimension: int) -> float:
    """1/(2 l rho0) in d^(dimension - 1): the diameter of disks, pi/2 for spheres."""
    return 1.0 if dimension == 2 else math.pi / 2


@dataclass
class _System:
    restitutions: tuple[float, ...] = ()  # none: those that the system has by itself
    rtol: float = 1e-10  # asked of the solver
    seed: int = 1
    workers: int | None = None  # threads
    name: str = "report"  # of its files

    is_papers_law: ClassVar[Any] = False  # are scatterers smooth disks, as those of the paper?
    parameter: ClassVar[Any] = "e"  # what `restitutions` are
    _least: ClassVar[Any] = {}  # of counts
    # of a quick report: counts at most, and tolerances at least
    _quick: ClassVar[Any] = {}

    def _check(self, default: tuple[float, ...]) -> None:
        """Set the restitutions, or the default; InputError for what cannot be used."""
        self.restitutions = found = tuple(
            check_restitution(e) for e in self.restitutions or default
        )
        if len(set(found)) != len(found):
            refuse("restitutions", found, "each may stand only once")
        for name, low in {**self._least, "seed": 0}.items():
            whole_number(name, getattr(self, name), low, 2**31 if name == "free_tracers" else 2**63)
        if self.workers is not None:
            whole_number("workers", self.workers, 1, 2**31)
        for name in ("rtol", "position_rtol", "time_rtol"):
            check_rtol(getattr(self, name, 1e-6))

    @property
    def scatterers(self) -> str:
        """What tracers hit: "disks" or "spheres"."""
        own: Any = self
        return SCATTERERS[own.dimension]

    def quick(self) -> Self:
        """The same system with fewer samples, and with fewer digits of what costs most."""
        bounds = {n: (min if x > 1 else max)(getattr(self, n), x) for n, x in self._quick.items()}
        return replace(self, **bounds)


@dataclass
class Cooling(_System):
    """Tracers that are left alone from a Gaussian start, and lose speed at every bounce.

    Times in d/U, densities in d^-2, or d^-3 in space. Empty restitutions are the paper's, empty
    final times the paper's, and 1000 of others; a single final time is that of all restitutions.
    """

    final_times: tuple[float, ...] = ()
    number_density: float = 0.04
    count: int = 40_000  # hard disks, or spheres, in the box
    media: int = 100  # configurations of them
    tracers: int = 100  # in each of them
    free_tracers: int = 200_000  # of the Boltzmann-Grad run, which has no configurations
    n_times: int = 24
    position_rtol: float = 1e-6  # asked of G(R), which costs most and is only drawn
    tangential_restitution: Any = 1.0
    dimension: int = 2  # 3: spheres

    _least: ClassVar[Any] = {"count": 1, "media": 2, "tracers": 1, "free_tracers": 2, "n_times": 2}
    _quick: ClassVar[Any] = {
        "media": 40, "tracers": 25, "free_tracers": 20_000, "position_rtol": 1e-5,
    }  # fmt: skip

    def __post_init__(self) -> None:
        self._check(tuple(PAPER_FINAL_TIME))
        found = self.restitutions
        default = tuple(PAPER_FINAL_TIME.get(e, 1000.0) for e in found)
        times = tuple(check_positive("until", t) for t in self.final_times or default)
        self.final_times = times * len(found) if len(times) == 1 else times
        if len(self.final_times) != len(found):
            refuse("until", len(times), f"there must be one for each of {len(found)} restitutions")
        check_positive("number_density", self.number_density)
        law = self.law(found[0])
        self.tangential_restitution, self.dimension = law.tangential_restitution, law.dimension
        self.stages = 3 * len(found) + 2  # how often a report tells progress

    def law(self, restitution: float) -> CollisionLaw:
        """The collision law of one restitution."""
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
    def half_rate(self) -> float:
        """1/(2 l) in 1/d, l the mean free path of the kinetic equation: in the plane d rho0."""
        return self.number_density * half_cross_section(self.dimension)


class Drive(NamedTuple):
    """What drives tracers, as a Scene and `simulate` take it, and what is then usual."""

    drive: dict[str, Any]
    initial: str
    restitutions: tuple[float, ...]
    collisions: int  # about so many in each run, which sets its tracers


DRIVES = {
    "field": Drive({"field": 1.0}, "rest", (
        0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98,
    ), 8_000_000),
    # scatterers that move, infinitely heavy
    "bath": Drive({"bath_speed": 1.0}, "gaussian", (0.5,), 10_000_000),
    # noise takes many short steps
    "heated": Drive({"heating": 1.0}, "gaussian", (0.5,), 2_000_000),
    # nothing drives, and the restitution falls with the impact speed; these are b
    "viscoelastic": Drive({}, "gaussian", (0.45,), 10_000_000),
}  # fmt: skip


@dataclass
class Driven(_System):
    """Tracers of the dilute limit that something drives, one of `DRIVES` by name.

    Lengths are in l, times in l/U, in a field sqrt(g l) and sqrt(l/g). Restitutions below 1.
    """

    rtol: float = 1e-8
    name: str = "bath"
    time_rtol: float = 1e-6  # asked of the solver over time
    dimension: int = 2
    collisions: int = 0  # 0: as usual
    most_tracers: int = 200_000
    groups: int = 100  # independent ones of tracers, behind the errors

    _least: ClassVar[Any] = {"groups": 10, "collisions": 1, "most_tracers": 100}
    _quick: ClassVar[Any] = {"collisions": 500_000, "most_tracers": 10_000, "time_rtol": 1e-5}

    def __post_init__(self) -> None:
        self.drive, self.initial, usual, collisions = DRIVES[self.name]
        self.collisions = self.collisions or collisions
        self._check(usual)
        self.restitutions = tuple(sorted(self.restitutions))
        if self.restitutions[-1] == 1.0 and self.drive:
            allowed = "each must be below 1: elastic tracers reach no steady state"
            refuse("restitutions", self.restitutions, allowed)
        CollisionLaw(0.5, 1.0, self.dimension)
        for x in self.restitutions:
            self.law(x)
        self.stages = 2 * len(self.restitutions) + 2

    @property
    def parameter(self) -> str:
        """What `restitutions` are."""
        return "e" if self.drive else "b"

    def law(self, restitution: float) -> Any:
        """The restitution, as a Scene and `simulate` take it."""
        return restitution if self.drive else Viscoelastic(restitution)

    def quick(self) -> Self:
        """The same with fewer samples, and fewer restitutions unless others were asked for."""
        usual, few = DRIVES[self.name].restitutions, self.restitutions
        if few == usual and len(usual) > 3:
            few = (0.0, 0.5, 0.9)
        return super(Driven, replace(self, restitutions=few)).quick()


System = Cooling | Driven
