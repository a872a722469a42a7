"""Every comparison of the report in a uniform field, with its verdict.

Rows are those of `row`, here with g = l = 1 as units and times in sqrt(l/g).
"""

from dataclasses import dataclass

from kinetics.crosscheck.report.case import Array, Measured
from kinetics.crosscheck.report.field_limits import dispersion_near_elastic, drift_near_elastic
from kinetics.crosscheck.report.field_runs import ApproachCase, SteadyCase
from kinetics.crosscheck.report.row import (
    EXACT,
    SOLVER,
    Names,
    Row,
    approximation,
    estimated,
    numerical,
)

PARTICLES, LIMIT = "Boltzmann-Grad", "limit e → 1"
NEARLY_ELASTIC = 0.9
"""The limiting laws are compared from this restitution on."""

OBSERVABLES = {
    "drift": Names("Drift u = ⟨v_z⟩ / √(gl)", "drift u"),
    "mean_square_speed": Names("Mean square speed ⟨v²⟩ / gl", "⟨v²⟩"),
    "mean_square_along": Names("Mean square velocity along the field ⟨v_z²⟩ / gl", "⟨v_z²⟩"),
    "mean_speed": Names("Mean speed ⟨v⟩ / √(gl)", "⟨v⟩"),
    "diffusion_parallel": Names("Dispersion along the field D∥ / √(gl³)", "D∥"),
    "diffusion_perpendicular": Names("Dispersion across the field D⊥ / √(gl³)", "D⊥"),
    "drift_from_rest": Names("Mean velocity from rest ⟨v_z(t)⟩ / √(gl)", "⟨v_z(t)⟩"),
    "square_from_rest": Names("Mean square speed from rest ⟨v²(t)⟩ / gl", "⟨v²(t)⟩"),
    "momentum": Names("Balance of the momentum: ⟨v v_z⟩ = 1/λ₁(1)", "⟨v v_z⟩"),
    "energy": Names("Balance of the energy: λ(2)⟨v³⟩ / 2⟨v_z⟩ = 1", "energy"),
    "cube": Names("Balance of ⟨v³⟩: λ(3)⟨v⁴⟩ / 3⟨v v_z⟩ = 1", "⟨v³⟩"),
    "direction": Names("Balance of the speed: ⟨cos φ⟩ / λ(1)⟨v²⟩ = 1", "⟨cos φ⟩"),
    "logarithm": Names("Balance of ln v: ⟨cos φ / v⟩ / κ⟨v⟩ = 1", "ln v"),
    "inverse": Names("Balance of 1/v: ⟨cos φ / v²⟩ / (⟨1/s⟩ − 1) = 1", "1/v"),
    "drift_among_disks": Names(
        "Drift among hard disks as ρ₀ → 0, over that of the equation", "ρ₀ → 0"
    ),
}
"""Every observable that a row can have, in the order of the report."""
AVERAGES = tuple(OBSERVABLES)[:6]
RELATIONS = tuple(OBSERVABLES)[8:14]
OF_PARTICLES = RELATIONS[:4]
"""The relations whose averages have a finite variance: ⟨1/v²⟩ has none among disks."""


@dataclass(frozen=True)
class FieldRow:
    """A row of one dimension."""

    dimension: int
    row: Row


def all_rows(steady: list[SteadyCase], approach: list[ApproachCase]) -> list[FieldRow]:
    """Every comparison, in the order of the observables."""
    rows = [FieldRow(case.dimension, row) for case in steady for row in rows_of_steady(case)]
    rows += [FieldRow(case.dimension, row) for case in approach for row in rows_of_approach(case)]
    order = list(OBSERVABLES)
    return sorted(rows, key=lambda item: order.index(item.row.observable))


def rows_of_steady(case: SteadyCase) -> list[Row]:
    """Of the steady state: averages, dispersion, exact relations, and the limiting laws."""
    rows = []
    for name in AVERAGES:
        rows += statistical(case, name, case.values[name], float(getattr(case.state, name)))
    for name, (value, theory) in exact_relations(case).items():
        rows.append(numerical(case.restitution, name, value, theory, case.state.rtol))
        if name in OF_PARTICLES:
            rows += statistical(case, name, case.values[name], theory, EXACT)
    return rows + _limits(case)


def exact_relations(case: SteadyCase) -> dict[str, tuple[float, float]]:
    """Both sides of each relation between averages that holds exactly: solver, and closed form.

    They are moments of the equation for v v_z, v^2, v^3, v, ln v and 1/v, of which the rate of
    change vanishes. That of 1/v has no finite side at e = 0.
    """
    law, moment = case.law, case.state.moment
    loss = {p: float(law.decay_rate(float(p))) for p in (-1, 1, 2, 3) if p > law.lowest_power}
    e, square = case.restitution, moment(2.0, 0)
    momentum = (1.5 if case.dimension == 2 else 2.0) / (1.0 + e)
    found = {
        "momentum": (moment(2.0, 1), momentum),
        "energy": (loss[2] * moment(3.0, 0) / (2.0 * moment(1.0, 1)), 1.0),
        "cube": (loss[3] * moment(4.0, 0) / (3.0 * moment(2.0, 1)), 1.0),
        "direction": (moment(0.0, 1) / (loss[1] * square), 1.0),
        "logarithm": (moment(-1.0, 1) / (law.mean_log_loss * moment(1.0, 0)), 1.0),
    }
    if e > 0.0:
        found["inverse"] = (moment(-2.0, 1) / -loss[-1], 1.0)
    return found


def rows_of_approach(case: ApproachCase) -> list[Row]:
    """Mean velocity and mean square speed over time."""
    drift, square = case.measured_drift, case.measured_square
    return [
        *statistical(case, "drift_from_rest", drift, case.drift, time=case.times),
        *statistical(case, "square_from_rest", square, case.square, time=case.times),
    ]


def statistical(
    case: SteadyCase | ApproachCase, name: str, measured: Measured, theory: float | Array,
    against: str = SOLVER, **places: Array,
) -> list[Row]:  # fmt: skip
    """What particles measured against the theory; of several times the worst."""
    who = (PARTICLES, against)
    return estimated(case.restitution, name, who, measured, theory, case.groups, "", places)


def _limits(case: SteadyCase) -> list[Row]:
    """The limiting laws of nearly elastic collisions against the solver."""
    e, d, state = case.restitution, case.dimension, case.state
    if e < NEARLY_ELASTIC:
        return []
    along, across = dispersion_near_elastic(e, d)
    laws = {
        "drift": drift_near_elastic(e, d),
        "diffusion_parallel": along,
        "diffusion_perpendicular": across,
    }
    return [
        approximation(e, name, LIMIT, float(value), float(getattr(state, name)), SOLVER)
        for name, value in laws.items()
    ]
