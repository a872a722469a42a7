"""What each figure of the paper shows, and the numbers that the exact theory sets beside it."""

from __future__ import annotations

from .flux import sonine_slope
from .quadrature_values import a2_value, cooling_rate_value, diffusion_slope_value
from .record import Derived, Number, Status
from .registry import derives

_RESTITUTIONS = (0.4, 0.6, 0.7, 0.9)


def _figure(note: str, *numbers: Number) -> Derived:
    return Derived(None, note=note, status=Status.FIGURE, numbers=numbers)


@derives("collision")
def _collision() -> Derived:
    return _figure("Sketch of vchange.")


@derives("v0re")
def _v0re() -> Derived:
    return _figure(
        "The printed line 0.058 t is rho_0 times the fitted 1.45. The exact slopes at the free "
        "path 1/(2 d rho_0) lie below it.",
        Number("printed slope", 0.058),
        *(
            Number(f"exact slope at e = {e}", 0.04 * float(cooling_rate_value(e)) / (1 - e))
            for e in _RESTITUTIONS
        ),
    )


@derives("hetomu2")
def _hetomu2() -> Derived:
    return _figure(
        "The exact curve exists on the whole of 0 <= e <= 1.",
        *(Number(f"exact h at e = {e}", float(cooling_rate_value(e))) for e in _RESTITUTIONS),
    )


@derives("msdtheory")
def _msdtheory() -> Derived:
    return _figure("The fitted l = 13.5 d stands in for the neglected persistence; see msd.")


@derives("inelasticposi")
def _inelasticposi() -> Derived:
    return _figure(
        "Neither curve is normalised to <R^2> = 1; see gammatailg and peakg. The shapes at four "
        "values of e need not be one universal curve; see beyond:position."
    )


@derives("scalev")
def _scalev() -> Derived:
    return _figure(
        "A projection on one component hides that the exact F vanishes at c = 0 for 0 < e < 1 and "
        "becomes a ring as e -> 1. A Gaussian has a_2 = 0.",
        *(Number(f"exact a_2 at e = {e}", float(a2_value(e))) for e in _RESTITUTIONS),
    )


@derives("impact")
def _impact() -> Derived:
    return _figure("Sketch of the impact parameter b = d sin(pi - psi).")


@derives("sign")
def _sign() -> Derived:
    return _figure("H is minus and plus sqrt(-383 + 828 e^2 + 900 e^4)/8; see ac7.")


@derives("soninediffuse")
def _soninediffuse() -> Derived:
    return _figure(
        "The deviation that the paper reports is that of the first Sonine approximation.",
        *(
            Number(f"slope at e = {e}, Sonine over exact", sonine_slope(e) / float(value))
            for e, value in ((e, diffusion_slope_value(e)) for e in (0.6, 0.7, 0.9))
        ),
    )
