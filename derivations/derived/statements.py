"""Which statements of the paper hold in the exact theory, each with the limits that decide it."""

from __future__ import annotations

from math import pi, sqrt

from .closed_form_values import largest_cooling_ratio
from .quadrature_values import a2_value, cooling_rate_value, diffusion_slope_value
from .record import RESTITUTIONS, Derived, Number, derives, numbers_at, result
from .sonine import at_restitution, roots


@derives("statement:h-linear")
def _h_linear() -> Derived:
    place, largest = largest_cooling_ratio()
    ratio = {"h/(1 - e) at e = {e}": lambda e: float(cooling_rate_value(e)) / (1 - e)}
    return result(
        None,
        note="Nearly, not exactly: h/(1 - e) starts from sqrt(2), rises by 1 % to its largest "
        "value at e = 0.1464 and falls to 4/3: it varies by 7 % in all. It follows from the exact "
        "moments, with no Sonine expansion.",
        holds=False,
        numbers=(
            Number("largest h/(1 - e)", largest),
            Number("restitution at which it is largest", place),
            Number("h/(1 - e) at e = 0", sqrt(2)),
            *numbers_at(RESTITUTIONS, ratio),
            Number("h/(1 - e) as e -> 1", 4 / 3),
        ),
    )


@derives("statement:h-not-haff")
def _h_not_haff() -> Derived:
    return result(
        None,
        note="h/(1 - e^2) falls from sqrt(2) to 2/3. A Gaussian VDF would give the constant "
        "sqrt(pi)/2; the exact VDF is never Gaussian.",
        holds=True,
        numbers=(
            Number("h/(1 - e^2) at e = 0", sqrt(2)),
            Number("h/(1 - e^2) as e -> 1", 2 / 3),
            Number("of a Gaussian", sqrt(pi) / 2),
        ),
    )


@derives("statement:a2-missing")
def _a2_missing() -> Derived:
    return result(
        None,
        note="Only the truncated equation has no real root there. The exact a_2 exists for every "
        "e in [0, 1) and falls from 2 to -1/2.",
        holds=False,
        numbers=(
            Number("a_2 at e = 0", 2.0),
            *numbers_at((0.2, 0.4, 0.5816, 0.9), {"a_2 at e = {e}": a2_value}),
            Number("a_2 as e -> 1", -0.5),
        ),
    )


@derives("statement:sonine-a2")
def _sonine_a2() -> Derived:
    def sonine(e: float) -> float:
        return at_restitution(roots()[0], e)

    return result(
        None,
        note="At e = 0.9 it is less than half of the exact value, and as e -> 1 it tends to "
        "-0.236 where the exact a_2 tends to -1/2.",
        holds=False,
        numbers=(
            *numbers_at(
                (0.6, 0.7, 0.9), {"Sonine a_2 at e = {e}": sonine, "exact a_2 at e = {e}": a2_value}
            ),
            Number("Sonine a_2 as e -> 1", sonine(1)),
        ),
    )


@derives("statement:gaussian-f")
def _gaussian_f() -> Derived:
    width = ((1 - 0.9 * 0.9) / 5) ** 0.5
    return result(
        None,
        note="As e -> 1 it tends to the ring delta(c - 1)/(2 pi), of relative width "
        "sqrt((1 - e^2)/5). Even where a_2 vanishes, at e = 0.5929352, its tail is exponential.",
        holds=False,
        numbers=(
            Number("a_2 of a Gaussian", 0.0),
            *numbers_at(RESTITUTIONS, {"a_2 at e = {e}": a2_value}),
            Number("relative width of the speed by the limit at e = 0.9", width),
        ),
    )


@derives("statement:exponential-f")
def _exponential_f() -> Derived:
    return result(
        None,
        note="F ~ c^(1/(1 - e^2) - 2) exp(-2 c/h): exactly exponential, for every e in [0, 1).",
        holds=True,
        numbers=numbers_at(
            RESTITUTIONS, {"rate 2/h at e = {e}": lambda e: 2 / float(cooling_rate_value(e))}
        ),
    )


@derives("statement:log-msd")
def _log_msd() -> Derived:
    return result(
        None,
        note="<r^2> grows as 2 l^2 ln t/[kappa (1 - <cos chi>)]: to the first power of ln t.",
        holds=True,
        numbers=numbers_at(RESTITUTIONS, {"slope at e = {e} (l^2)": diffusion_slope_value}),
    )


@derives("statement:universal-g")
def _universal_g() -> Derived:
    return result(
        None,
        note="It tends to the Gaussian 2 R exp(-R^2), with corrections of order 1/ln t that "
        "depend on e; at any finite time it differs from e to e and changes.",
        holds=False,
        numbers=(
            Number("<R^4>/<R^2>^2 of the limit", 2.0),
            Number("<R^4>/<R^2>^2 of the paper's integral", 4.0),
        ),
    )


@derives("statement:exponential-g")
def _exponential_g() -> Derived:
    return result(
        None,
        note="The paper's integral is 4 R K_0(2 R) once <R^2> = 1: its tail is exponential, but "
        "its peak is not Gaussian (G/R diverges as -ln R). It rests on D_e ~ V^2, which fails even "
        "at e = 1. At finite times the free paths do give an exponential tail; the limit is "
        "Gaussian.",
        holds=False,
        numbers=(Number("decay rate of the paper's integral at <R^2> = 1", 2.0),),
    )
