"""The stability sweep: solvers and particles at their limits, a verdict for each case.

`all_cases` is the table: a row is the name of a group, the work of its cases, and the values of
each argument of the work; every choice of these is a case. The work gives an `Outcome`: the error
asked for, the error reached, and what every answer must keep. The works are in `stress_work.py`,
the invariants in `stress_invariants.py`.
"""

import math
import time
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product

import numpy as np
import pandas as pd

from kinetics.collision import CollisionLaw
from kinetics.crosscheck import references
from kinetics.crosscheck.files import dumps, markdown_table
from kinetics.crosscheck.stress_invariants import Outcome
from kinetics.crosscheck.stress_work import (
    driven,
    error_to_references,
    fly,
    scaled,
    scene,
    steady,
)
from kinetics.errors import InputError, ModelWarning, ToleranceWarning, suggestion

FORMAT = "inelastic-lorentz stress 2"
HOLDS = "holds"
SAYS_SO = "says so"
MISSED = "missed"
BROKEN = "broken"
VERDICTS = {
    HOLDS: "a finite answer within the error asked for, and every invariant kept",
    SAYS_SO: "the status says that the error asked for was not reached",
    MISSED: "the error asked for was not reached, and the status claims that it was",
    BROKEN: "not finite, an invariant violated, a warning, an exception, or a minute's work",
}
ACCEPTED = (HOLDS, SAYS_SO)
#: Processor time in s from which on a case is broken. The slowest of the
#: quick sweep took 9.4 s of it.
MAX_SECONDS = 60.0
#: A quick sweep runs every fifth choice of a row.
QUICK_STRIDE = 5
#: Characters of a note that are kept.
MAX_NOTE = 240

#: A case that was run, as the JSON document holds it.
CaseRow = dict[str, str | float]
Work = Callable[..., Outcome]


# -- a case and its verdict ------------------------------------------------------------------------
@dataclass(frozen=True)
class Case:
    """A case that has not been run."""

    group: str
    name: str
    work: Callable[[], Outcome]


def judge(outcome: Outcome, seconds: float) -> str:
    """Return the verdict on a run that raised nothing, in so many s of processor time."""
    if math.isinf(outcome.reached) or outcome.violated is not None or seconds > MAX_SECONDS:
        return BROKEN
    if not outcome.converged:
        return SAYS_SO
    if outcome.reached > outcome.asked:
        return MISSED
    return HOLDS


def attempt(case: Case) -> CaseRow:
    """Return the row of one case, with what it violates; only an interruption stops the sweep."""
    begin = time.process_time()
    outcome = Outcome()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", ToleranceWarning)  # the status is looked at
            warnings.simplefilter("ignore", ModelWarning)  # the solver is driven to its limits
            outcome = case.work()
        verdict = judge(outcome, time.process_time() - begin)
        note = outcome.note
    except Exception as error:  # whatever it is, it is the finding
        verdict = BROKEN
        note = f"{type(error).__name__}: {error}"
    row: CaseRow = {
        "group": case.group,
        "name": case.name,
        "verdict": verdict,
        "asked": outcome.asked,
        "reached": outcome.reached,
        "invariant": "",
        "violation": 0.0,
        "allowed": 0.0,
    }
    if outcome.violated is not None:
        violation = outcome.invariants[outcome.violated]
        row["invariant"] = outcome.violated
        row["violation"] = violation.size
        row["allowed"] = violation.allowed
    row["seconds"] = time.process_time() - begin
    row["note"] = " ".join(note.split())[:MAX_NOTE]
    return row


# -- the table -------------------------------------------------------------------------------------
@dataclass(frozen=True)
class CaseFamily:
    """A row of the table: the group of its cases, their work, and the values of its arguments."""

    group: str
    work: Work
    axes: Mapping[str, Sequence[object]]

    def cases(self, stride: int) -> Iterator[Case]:
        """Yield a case for every choice of the values, or for each `stride`-th."""
        for values in list(product(*self.axes.values()))[::stride]:
            arguments = dict(zip(self.axes, values, strict=True))
            texts = [f"{name} = {_text_of(name, value)}" for name, value in arguments.items()]
            yield Case(self.group, ", ".join(texts), partial(self.work, **arguments))


def _text_of(name: str, value: object) -> object:
    """Return what stands for a value in the name of a case: of times the last."""
    if name == "times" and isinstance(value, Sequence | np.ndarray):
        return value[-1]
    return value


def _laws(*restitutions: float, et: float = 1.0, d: int = 2) -> list[CollisionLaw]:
    """Return the collision laws of these restitutions."""
    return [CollisionLaw(e, et, d) for e in restitutions]


#: The restitution closest to 1 that is tried.
NEARLY_ELASTIC = 1.0 - 1e-10
#: Smooth disks: usual restitutions, and as close to 0 and 1 as 1e-10.
SMOOTH_DISKS = _laws(
    *(0.7, 1e-10, 1e-8, 1e-4, 0.01, 0.2, 0.3, 0.5, 0.0, 0.9, 0.99, 0.999),
    *(1 - 1e-6, NEARLY_ELASTIC),
)
#: Bounces from which a law is made, a third of which keep the speed: impact parameter, ratio of
#: speeds, cosine of the deflection as `CollisionLaw.from_samples` takes them.
BOUNCES = ([0.2, 0.3, 0.2, 0.3], [0.9, 0.5, 1.0, 1.0], [-1.0, 0.0, 0.5, 1.0])
#: Spheres, rough scatterers, and measured bounces.
OTHER_LAWS = [
    *_laws(0.0, 1e-10, 0.2, 0.7, 0.99, NEARLY_ELASTIC, d=3),
    *_laws(0.5, et=0.0),
    *_laws(1e-7, et=1e-7),
    *_laws(0.7, 0.0, 1.0, et=0.8),
    *_laws(0.7, 0.0, 1.0, et=0.8, d=3),
    *_laws(0.5, et=0.5),
    CollisionLaw.from_samples(*BOUNCES, dimension=2),
    CollisionLaw.from_samples(*BOUNCES, dimension=3),
]
COOLING_LAWS = [*SMOOTH_DISKS, *OTHER_LAWS]
#: Mean logarithmic loss of speed above which the density of the speeds can be followed.
LOSSY_ABOVE = 1e-4
LOSSY_LAWS = [law for law in OTHER_LAWS if law.mean_log_loss > LOSSY_ABOVE]
ELASTIC_LAWS = _laws(1.0) + _laws(1.0, d=3)
#: Laws of which digits are kept in `references`.
REFERENCE_LAWS = _laws(0.7, 0.0, 0.2, 0.99)
POSITION_LAWS = _laws(0.7, 0.2, NEARLY_ELASTIC, 1.0)
FALLING_LAWS = _laws(0.7)

KNOWN_STARTS = references.STARTS
ROUGH_STARTS = ("beam along x", "step", "two peaks", "speeds 1e-100 and 1")
#: Times from 0 to where the largest number of doubles is near.
ALL_TIMES = np.array([0.0, 1e-300, 1e-3, 1.0, 1e3, 1e8, 1e30, 1e300])
AVERAGES = ("thermal_speed", "a2", "collisions")
DISPLACEMENT = (*AVERAGES, "msd", "velocity_autocorrelation", "diffusion_coefficient")
ALL_AVERAGES = (
    *DISPLACEMENT,
    "kurtosis",
    "mean_displacement",
    "mean_velocity",
    "velocity_tensor",
)


def all_families() -> list[CaseFamily]:
    """Return the table, by what is asked."""
    return [
        *_scaled_families(),
        *_average_families(),
        *_density_families(),
        *_field_families(),
        *_driven_families(),
        *_particle_families(),
    ]


def _scaled_families() -> list[CaseFamily]:
    """Return the scaled equation, to two tolerances and with few nodes."""
    group = "scaled equation"
    with_nodes = partial(scaled, rtol=1e-12)
    nodes = (8, 16, 64, 256)
    return [
        CaseFamily(group, scaled, {"law": COOLING_LAWS, "rtol": (1e-4, 1e-12)}),
        CaseFamily(group, with_nodes, {"law": REFERENCE_LAWS, "nodes": nodes}),
    ]


def _average_families() -> list[CaseFamily]:
    """Return averages over time: against kept digits, of all starts, of other units."""
    known = partial(scene, reference=error_to_references, outputs=AVERAGES)
    horizons = [references.times(horizon) for horizon in references.HORIZONS]
    in_units = partial(scene, times=ALL_TIMES, outputs=(*AVERAGES, "temperature"), rtol=1e-9)
    moments = partial(scene, times=ALL_TIMES, outputs=DISPLACEMENT, rtol=1e-9)
    averages = partial(scene, times=ALL_TIMES, outputs=ALL_AVERAGES, rtol=1e-9)
    # Elastic tracers do not slow down: v t/l overflows at the last time.
    elastic = partial(averages, times=ALL_TIMES[:-1])
    units = ("speed 1e150", "gaussian of 1e-150")
    return [
        CaseFamily(
            "cooling",
            known,
            {
                "law": REFERENCE_LAWS,
                "start": KNOWN_STARTS,
                "times": horizons,
                "rtol": (1e-3, 1e-6, 1e-12),
            },
        ),
        CaseFamily("cooling", in_units, {"law": SMOOTH_DISKS, "start": units}),
        CaseFamily(
            "cooling",
            in_units,
            {"law": SMOOTH_DISKS, "start": KNOWN_STARTS, "number_density": [1e150]},
        ),
        CaseFamily(
            "cooling",
            in_units,
            {"law": SMOOTH_DISKS, "start": KNOWN_STARTS, "diameter": [1e-150]},
        ),
        # <v^6> is infinite.
        CaseFamily("averages", moments, {"law": SMOOTH_DISKS, "start": ["tail v^-6"]}),
        CaseFamily("averages", averages, {"law": COOLING_LAWS, "start": KNOWN_STARTS}),
        CaseFamily("averages", averages, {"law": SMOOTH_DISKS, "start": ROUGH_STARTS}),
        CaseFamily("averages", elastic, {"law": ELASTIC_LAWS, "start": KNOWN_STARTS}),
    ]


def _density_families() -> list[CaseFamily]:
    """Return densities of speeds and positions, and the scattering function."""
    speeds = partial(
        scene,
        start="gaussian",
        times=[0.5, 30.0, 1e3],
        outputs=("thermal_speed", "speed_density"),
        rtol=1e-6,
    )
    positions = partial(scene, start="gaussian", outputs=("msd", "position_density"), rtol=1e-3)
    scattering = partial(scene, outputs=("msd", "intermediate_scattering"), rtol=1e-6)
    starts = ("gaussian", "beam along x")
    all_laws = [*SMOOTH_DISKS, *LOSSY_LAWS, *ELASTIC_LAWS]
    extreme_times = ([1e-300], [1e3], [1e150])
    return [
        CaseFamily("spectral density", speeds, {"law": SMOOTH_DISKS, "nodes": (512, 64, 8)}),
        CaseFamily("spectral density", speeds, {"law": all_laws}),
        CaseFamily("position density", positions, {"law": POSITION_LAWS, "times": extreme_times}),
        CaseFamily("position density", positions, {"law": OTHER_LAWS, "times": ([1e3],)}),
        CaseFamily(
            "scattering function",
            scattering,
            {
                "law": POSITION_LAWS,
                "start": starts,
                "times": ([1.0], [1e-300], [1e3], [1e150]),
            },
        ),
        CaseFamily(
            "scattering function",
            scattering,
            {"law": OTHER_LAWS, "start": starts, "times": ([1.0],)},
        ),
    ]


def _field_families() -> list[CaseFamily]:
    """Return the steady state in a field, and weak and strong fields over time."""
    families = [CaseFamily("steady state", steady, {"law": COOLING_LAWS, "rtol": (1e-3, 1e-6)})]
    outputs = ("thermal_speed", "mean_velocity", "mean_displacement", "collisions")
    falling = partial(scene, outputs=outputs, rtol=1e-3)
    mean_free_path = references.MEAN_FREE_PATH
    for acceleration in (1e12, 1.0, 1e-12):
        times = np.array([1e-3, 0.1, 1.0, 10.0]) * math.sqrt(mean_free_path / acceleration)
        axes = {
            "law": FALLING_LAWS,
            "start": ("rest", *KNOWN_STARTS),
            "times": [times],
            "field": [acceleration],
        }
        families.append(CaseFamily("over time in a field", falling, axes))
    return families


def _driven_families() -> list[CaseFamily]:
    """Return steady states of driven tracers, alone and of all drives together."""
    common: dict[str, Sequence[object]] = {
        "restitution": (0.6, 0.0, 0.99),
        "mass_ratio": (3.0, math.inf, 0.3),
        "dimension": (2, 3),
        "rtol": (1e-4, 1e-8),
    }
    drives: list[dict[str, Sequence[object]]] = [
        {"bath_speed": (0.5, 10.0)},
        {"heating": [0.1], "drag": (0.1, 2.0)},
        {"field": [0.2], "drag": (0.1, 2.0)},
        {"bath_speed": [1.0], "heating": [0.3], "drag": [0.3], "field": [1.0]},
    ]
    return [CaseFamily("driven", driven, drive | common) for drive in drives]


def _particle_families() -> list[CaseFamily]:
    """Return particles in dilute and dense media.

    The last Poisson medium is that at which the plane falls apart: rho pi d^2 = 1.128.
    """
    plane = [f"Poisson {density}" for density in (0.01, 0.2, 0.35, 0.359)]
    plane += [f"HardDisks {density}" for density in (0.01, 0.2, 0.65)]
    plane += ["BoltzmannGrad 0.04"]
    space = ["HardSpheres 0.3", "PoissonSpheres 0.03", "BoltzmannGrad 0.04"]
    families = []
    for dimension, media in ((2, plane), (3, space)):
        laws = _laws(0.5, et=0.8, d=dimension) + _laws(0.0, 1.0, d=dimension)
        families.append(CaseFamily("density", fly, {"law": laws, "medium": media}))
    return families


def all_cases(quick: bool) -> list[Case]:
    """Return every case of the table; of a quick sweep every fifth of each row."""
    stride = QUICK_STRIDE if quick else 1
    return [case for family in all_families() for case in family.cases(stride)]


# -- run and report --------------------------------------------------------------------------------
@dataclass
class StressReport:
    """The cases of a sweep as they were run, how many were not; s, and s of processor time."""

    quick: bool
    not_run: int
    cases: list[CaseRow] = field(default_factory=list)
    seconds: float = 0.0
    processor_seconds: float = 0.0

    @property
    def rejected(self) -> list[CaseRow]:
        """Those that ended as they must not."""
        return [case for case in self.cases if case["verdict"] not in ACCEPTED]

    def to_json(self) -> str:
        """Return one strict JSON document; what is not finite is null."""
        return dumps({"format": FORMAT, "verdicts": VERDICTS, **vars(self)})

    def markdown(self) -> str:
        """Return a row for each group; then the cases that are not accepted."""
        heading = "# Stability sweep (quick)" if self.quick else "# Stability sweep"
        text = (
            f"{heading}\n\n{len(self.cases)} cases in "
            f"{self.seconds:.0f} s, {self.processor_seconds:.0f} s of processor time; "
            f"{len(self.rejected)} did not end as they must, {self.not_run} were not run.\n\n"
        )
        if self.cases:
            text += markdown_table(self._counts()) + "\n"
        for verdict, meaning in VERDICTS.items():
            text += f"- {verdict}: {meaning}\n"
        if self.rejected:
            text += f"\n## Rejected cases\n\n{markdown_table(pd.DataFrame(self.rejected))}"
        return text

    def _counts(self) -> pd.DataFrame:
        """Return how many cases of each group have each verdict, and the slowest."""
        frame = pd.DataFrame(self.cases)
        counts = pd.crosstab(frame["group"], frame["verdict"], margins=True, margins_name="all")
        counts = counts.reindex(columns=["all", *VERDICTS], fill_value=0)
        slowest = frame.groupby("group")["seconds"].max()
        counts["slowest [s]"] = slowest.reindex(counts.index, fill_value=slowest.max())
        return counts.reset_index()


def ignore_progress(group: str, total: int) -> None:
    """Take the name of a group and the number of cases, and do nothing."""


def ignore_interruption(report: StressReport) -> None:
    """Take the report of what has been run, and do nothing."""


def run_stress(
    quick: bool = False,
    groups: Collection[str] | None = None,
    progress: Callable[[str, int], None] = ignore_progress,
    interrupted: Callable[[StressReport], None] = ignore_interruption,
) -> StressReport:
    """Run the sweep, or the named groups.

    Parameters
    ----------
    progress : called with the group and the number of all cases, before each case
    interrupted : called with the report of what has been run after Ctrl-C or SIGTERM, which goes on
    """
    cases = all_cases(quick)
    names = list(dict.fromkeys(case.group for case in cases))
    for group in groups or ():
        if group not in names:
            known = ", ".join(map(repr, names))
            near = suggestion(group, names)
            raise InputError(f"groups: got {group!r}; known are {known}{near}")
    if groups is not None:
        cases = [case for case in cases if case.group in groups]
    report = StressReport(quick, len(cases))
    begin = time.perf_counter()
    processor_begin = time.process_time()
    try:
        for case in cases:
            progress(case.group, len(cases))
            report.cases.append(attempt(case))
            report.not_run -= 1
            report.seconds = time.perf_counter() - begin
            report.processor_seconds = time.process_time() - processor_begin
    except (KeyboardInterrupt, SystemExit):
        interrupted(report)
        raise
    return report
