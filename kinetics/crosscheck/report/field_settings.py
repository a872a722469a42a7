"""What a report on tracers in a uniform field is asked for."""

from dataclasses import dataclass, replace

from kinetics import CollisionLaw
from kinetics.crosscheck.report.settings import check_counts, checked_restitutions
from kinetics.validation import check_rtol, refuse

SCATTERERS = {2: "disks", 3: "spheres"}
APPROACH = (0.5, 0.9)
RESTITUTIONS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98)
QUICK_RESTITUTIONS = (0.0, 0.5, 0.9)
_LINE = (*(k / 20 for k in range(19)), 0.925, 0.95, 0.97, 0.98, 0.99, 0.995, 0.999)
_QUICK_LINE = (0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.8, 0.9, 0.95, 0.975, 0.99, 0.995, 0.999)
DENSITIES = (0.0025, 0.005, 0.01, 0.02, 0.04, 0.08)
_LEAST = {
    "configurations": 10,
    "tracers": 2,
    "groups": 10,
    "collisions": 1,
    "most_tracers": 100,
    "seed": 0,
}


@dataclass(frozen=True)
class FieldSettings:
    """The systems, the sample sizes and the accuracy of one report.

    Scatterers are smooth. The mean free path l and the acceleration g are the units, so that
    speeds are in sqrt(g l) and times in sqrt(l/g). InputError for anything that cannot be used.

    restitutions : of the comparisons, from 0 to below 1; empty for those of `RESTITUTIONS`
    dimensions : 2 for disks, 3 for spheres
    approach : restitutions at which the approach to the steady state is followed; None for
        `APPROACH`, or for the first and the last of the restitutions that were asked for
    collisions : about so many in each run, which sets the number of its tracers
    most_tracers : of a run
    densities, dense : number densities of hard disks, in d^-2, and the restitutions there
    configurations, tracers : of hard disks, and of tracers in each of them
    groups : independent groups of tracers, behind the errors
    rtol, time_rtol : asked of the solver, for the steady state and over time
    """

    restitutions: tuple[float, ...] = ()
    dimensions: tuple[int, ...] = (2, 3)
    approach: tuple[float, ...] | None = None
    line: tuple[float, ...] = _LINE
    collisions: int = 8_000_000
    most_tracers: int = 200_000
    groups: int = 100
    densities: tuple[float, ...] = DENSITIES
    dense: tuple[float, ...] = (0.5, 0.7, 0.9)
    configurations: int = 200
    tracers: int = 60
    rtol: float = 1e-8
    time_rtol: float = 1e-6
    seed: int = 1
    workers: int | None = None

    def __post_init__(self) -> None:
        restitutions = checked_restitutions(self.restitutions or RESTITUTIONS)
        if max(restitutions) == 1.0:
            allowed = "each must be below 1: elastic tracers reach no steady state in a field"
            refuse("restitutions", restitutions, allowed)
        restitutions = tuple(sorted(restitutions))
        object.__setattr__(self, "restitutions", restitutions)
        if self.approach is None:
            ends = tuple(dict.fromkeys((restitutions[0], restitutions[-1])))
            followed = APPROACH if restitutions == RESTITUTIONS else ends
            object.__setattr__(self, "approach", followed)
        for dimension in self.dimensions:
            CollisionLaw(0.5, 1.0, dimension)
        check_rtol(self.rtol)
        check_rtol(self.time_rtol)
        check_counts(self, _LEAST)

    @property
    def followed(self) -> tuple[float, ...]:
        """The restitutions at which the approach to the steady state is followed."""
        return self.approach or ()

    @property
    def has_disks(self) -> bool:
        """Whether tracers fall among hard disks too."""
        return 2 in self.dimensions and bool(self.dense)

    def quick(self) -> "FieldSettings":
        """The same with fewer restitutions, unless others were asked for, and fewer samples."""
        few = QUICK_RESTITUTIONS if self.restitutions == RESTITUTIONS else self.restitutions
        return replace(
            self,
            restitutions=few,
            approach=self.followed[:1],
            line=_QUICK_LINE,
            densities=self.densities[1::2],
            dense=self.dense[:2],
            configurations=min(self.configurations, 50),
            tracers=min(self.tracers, 20),
            collisions=min(self.collisions, 500_000),
            most_tracers=min(self.most_tracers, 10_000),
            rtol=max(self.rtol, 1e-6),
            time_rtol=max(self.time_rtol, 1e-4),
        )
