"""Which statements of the paper survive, in one place, each with the limits that decide it."""

from __future__ import annotations

import mpmath as mp

from .closed_form_values import largest_cooling_ratio
from .quadrature_values import a2_value, cooling_rate_value, diffusion_slope_value
from .record import Derived, Number, Status
from .registry import derives
from .sonine import at_restitution, roots

_RESTITUTIONS = (0.4, 0.6, 0.7, 0.9)


def _verdict(holds: bool, note: str, *numbers: Number) -> Derived:
    return Derived(None, note=note, status=Status.ASSUMPTION, holds=holds, numbers=numbers)


@derives("statement:h-linear")
def _h_linear() -> Derived:
    return _verdict(
        False,
        "Nearly, not exactly: h/(1 - e) starts from sqrt(2), rises by 1 % to its largest value at "
        "e = 0.1464 and falls to 4/3: it varies by 7 % in all. It follows from the exact moments, "
        "with no Sonine expansion.",
        Number("largest h/(1 - e)", largest_cooling_ratio()[1]),
        Number("restitution at which it is largest", largest_cooling_ratio()[0]),
        Number("h/(1 - e) at e = 0", float(mp.sqrt(2))),
        *(
            Number(f"h/(1 - e) at e = {e}", float(cooling_rate_value(e)) / (1 - e))
            for e in _RESTITUTIONS
        ),
        Number("h/(1 - e) as e -> 1", 4 / 3),
    )


@derives("statement:h-not-haff")
def _h_not_haff() -> Derived:
    return _verdict(
        True,
        "h/(1 - e^2) falls from sqrt(2) to 2/3. A Gaussian VDF would give the constant "
        "sqrt(pi)/2; the exact VDF is never Gaussian.",
        Number("h/(1 - e^2) at e = 0", float(mp.sqrt(2))),
        Number("h/(1 - e^2) as e -> 1", 2 / 3),
        Number("of a Gaussian", float(mp.sqrt(mp.pi) / 2)),
    )


@derives("statement:a2-missing")
def _a2_missing() -> Derived:
    return _verdict(
        False,
        "Only the truncated equation has no real root there. The exact a_2 exists for every e in "
        "[0, 1) and falls from 2 to -1/2.",
        Number("a_2 at e = 0", 2.0),
        *(Number(f"a_2 at e = {e}", float(a2_value(e))) for e in (0.2, 0.4, 0.5816, 0.9)),
        Number("a_2 as e -> 1", -0.5),
    )


@derives("statement:sonine-a2")
def _sonine_a2() -> Derived:
    return _verdict(
        False,
        "At e = 0.9 it is less than half of the exact value, and as e -> 1 it tends to -0.236 "
        "where the exact a_2 tends to -1/2.",
        *(
            number
            for e in (0.6, 0.7, 0.9)
            for number in (
                Number(f"Sonine a_2 at e = {e}", at_restitution(roots()[0], e)),
                Number(f"exact a_2 at e = {e}", float(a2_value(e))),
            )
        ),
        Number("Sonine a_2 as e -> 1", at_restitution(roots()[0], 1)),
    )


@derives("statement:gaussian-f")
def _gaussian_f() -> Derived:
    return _verdict(
        False,
        "As e -> 1 it tends to the ring delta(c - 1)/(2 pi), of relative width "
        "sqrt((1 - e^2)/5). Even where a_2 vanishes, at e = 0.5929352, its tail is exponential.",
        Number("a_2 of a Gaussian", 0.0),
        *(Number(f"a_2 at e = {e}", float(a2_value(e))) for e in _RESTITUTIONS),
        *(
            Number(f"relative width of the speed by the limit at e = {e}", ((1 - e * e) / 5) ** 0.5)
            for e in (0.9,)
        ),
    )


@derives("statement:exponential-f")
def _exponential_f() -> Derived:
    return _verdict(
        True,
        "F ~ c^(1/(1 - e^2) - 2) exp(-2 c/h): exactly exponential, for every e in [0, 1).",
        *(Number(f"rate 2/h at e = {e}", 2 / float(cooling_rate_value(e))) for e in _RESTITUTIONS),
    )


@derives("statement:log-msd")
def _log_msd() -> Derived:
    return _verdict(
        True,
        "<r^2> grows as 2 l^2 ln t/[kappa (1 - <cos chi>)]: to the first power of ln t.",
        *(
            Number(f"slope at e = {e} (l^2)", float(diffusion_slope_value(e)))
            for e in _RESTITUTIONS
        ),
    )


@derives("statement:universal-g")
def _universal_g() -> Derived:
    return _verdict(
        False,
        "It tends to the Gaussian 2 R exp(-R^2), with corrections of order 1/ln t that depend on "
        "e; at any finite time it differs from e to e and changes.",
        Number("<R^4>/<R^2>^2 of the limit", 2.0),
        Number("<R^4>/<R^2>^2 of the paper's integral", 4.0),
    )


@derives("statement:exponential-g")
def _exponential_g() -> Derived:
    return _verdict(
        False,
        "The paper's integral is 4 R K_0(2 R) once <R^2> = 1: its tail is exponential, but its "
        "peak is not Gaussian (G/R diverges as -ln R). It rests on D_e ~ V^2, which fails even "
        "at e = 1. At finite times the free paths do give an exponential tail; the limit is "
        "Gaussian.",
        Number("decay rate of the paper's integral at <R^2> = 1", 2.0),
    )
