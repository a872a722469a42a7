"""What a report is asked to compare: the paper's own system unless told otherwise."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from kinetics.collision import CollisionLaw, law_of
from kinetics.errors import InputError
from kinetics.validation import (
    check_positive,
    check_restitution,
    check_rtol,
    refuse,
    whole_number,
)  # fmt: skip

PAPER_FINAL_TIME = {0.4: 3000.0, 0.6: 300.0, 0.7: 500.0, 0.9: 1000.0}
"""Final time in d/U of each restitution in the paper (captions of inelasticposi and scalev)."""
OTHER_FINAL_TIME = 1000.0
"""Final time in d/U of a restitution that the paper does not have."""
_LEAST = {"count": 1, "media": 2, "tracers": 1, "free_tracers": 2, "n_times": 2, "seed": 0}


def half_cross_section(dimension: int) -> float:
    """1/(2 l rho0) in d^(dimension - 1): the diameter of disks, pi/2 for spheres."""
    return 1.0 if dimension == 2 else math.pi / 2


def checked_restitutions(values: Iterable[Any]) -> tuple[float, ...]:
    """Different restitutions from 0 to 1; InputError for others."""
    restitutions = tuple(check_restitution(e) for e in values)
    if len(set(restitutions)) != len(restitutions):
        refuse("restitutions", restitutions, "each may stand only once")
    return restitutions


def check_counts(settings: Any, least: Mapping[str, int]) -> None:
    """InputError for whole numbers of the settings that are below the least, or too large."""
    for name, low in least.items():
        most = 2**31 if name == "free_tracers" else 2**63
        whole_number(name, getattr(settings, name), low, most)
    if settings.workers is not None:
        whole_number("workers", settings.workers, 1, 2**31)


@dataclass(frozen=True)
class ReportSettings:
    """The system, the sample sizes and the accuracy of one report.

    Lengths in d (the diameter of scatterer and of tracer), times in d/U, densities in d^-2, or d^-3
    in space.
    Empty restitutions stand for the paper's, empty final times for the paper's or
    `OTHER_FINAL_TIME`; a single final time is that of all restitutions. InputError for anything
    that cannot be used.
    """

    restitutions: tuple[float, ...] = ()
    final_times: tuple[float, ...] = ()
    number_density: float = 0.04
    count: int = 40_000  # hard disks, or spheres, in the box
    media: int = 100  # configurations of them
    tracers: int = 100  # in each of them
    free_tracers: int = 200_000  # of the Boltzmann-Grad run, which has no configurations
    n_times: int = 24
    rtol: float = 1e-10  # asked of the solver
    position_rtol: float = 1e-6  # asked of G(R), which costs most and is only drawn
    seed: int = 1
    workers: int | None = None
    tangential_restitution: float = 1.0
    dimension: int = 2  # 3: spheres

    def __post_init__(self) -> None:
        restitutions = checked_restitutions(self.restitutions or PAPER_FINAL_TIME)
        times = self.final_times or tuple(
            PAPER_FINAL_TIME.get(e, OTHER_FINAL_TIME) for e in restitutions
        )
        times = tuple(check_positive("until", t) for t in times)
        if len(times) == 1:
            times *= len(restitutions)
        if len(times) != len(restitutions):
            raise InputError(
                f"until: got {len(times)} for {len(restitutions)} restitutions; "
                "there must be one for each"
            )
        object.__setattr__(self, "restitutions", restitutions)
        object.__setattr__(self, "final_times", times)
        for e in restitutions:
            law = self.law(e)
        object.__setattr__(self, "tangential_restitution", law.tangential_restitution)
        object.__setattr__(self, "dimension", law.dimension)
        check_positive("number_density", self.number_density)
        check_rtol(self.rtol)
        check_rtol(self.position_rtol)
        check_counts(self, _LEAST)

    def law(self, restitution: float) -> CollisionLaw:
        """The collision law of one restitution."""
        return law_of(restitution, self.tangential_restitution, self.dimension)

    @property
    def is_papers_law(self) -> bool:
        """Whether scatterers are smooth disks in the plane, for which the paper's formulas are."""
        return self.tangential_restitution == 1.0 and self.dimension == 2

    @property
    def scatterers(self) -> str:
        """What tracers hit: "disks" or "spheres"."""
        return "disks" if self.dimension == 2 else "spheres"

    @property
    def half_rate(self) -> float:
        """1/(2 l) in 1/d, l the mean free path of the kinetic equation: in the plane d rho0."""
        return self.number_density * half_cross_section(self.dimension)

    def described(self) -> dict[str, Any]:
        """The settings by name, for the document. That of the paper's law does not name the law."""
        every = asdict(self)
        if self.is_papers_law:
            del every["tangential_restitution"], every["dimension"]
        return every

    def quick(self) -> "ReportSettings":
        """The same system with fewer samples, and G(R) to fewer digits."""
        return replace(
            self,
            media=min(self.media, 40),
            tracers=min(self.tracers, 25),
            free_tracers=min(self.free_tracers, 20_000),
            position_rtol=max(self.position_rtol, 1e-5),
        )
