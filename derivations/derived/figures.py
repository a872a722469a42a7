"""What each figure of the paper shows, and the numbers that the exact theory sets beside it."""

from __future__ import annotations

from .flux import sonine_slope
from .quadrature_values import a2_value, cooling_rate_value, diffusion_slope_value
from .record import RESTITUTIONS, Derived, Number, Status, defines, derives, numbers_at, result

defines(
    {
        "collision": "Sketch of vchange.",
        "msdtheory": "The fitted l = 13.5 d stands in for the neglected persistence; see msd.",
        "inelasticposi": "Neither curve is normalised to <R^2> = 1; see gammatailg and peakg. "
        "The shapes at four values of e need not be one universal curve; see beyond:position.",
        "impact": "Sketch of the impact parameter b = d sin(pi - psi).",
        "sign": "H is minus and plus sqrt(-383 + 828 e^2 + 900 e^4)/8; see ac7.",
    },
    Status.FIGURE,
)


@derives("v0re")
def _v0re() -> Derived:
    slope = {"exact slope at e = {e}": lambda e: 0.04 * float(cooling_rate_value(e)) / (1 - e)}
    return result(
        None,
        note="The printed line 0.058 t is rho_0 times the fitted 1.45. The exact slopes at the "
        "free path 1/(2 d rho_0) lie below it.",
        status=Status.FIGURE,
        numbers=(Number("printed slope", 0.058), *numbers_at(RESTITUTIONS, slope)),
    )


@derives("hetomu2")
def _hetomu2() -> Derived:
    return result(
        None,
        note="The exact curve exists on the whole of 0 <= e <= 1.",
        status=Status.FIGURE,
        numbers=numbers_at(RESTITUTIONS, {"exact h at e = {e}": cooling_rate_value}),
    )


@derives("scalev")
def _scalev() -> Derived:
    return result(
        None,
        note="A projection on one component hides that the exact F vanishes at c = 0 for "
        "0 < e < 1 and becomes a ring as e -> 1. A Gaussian has a_2 = 0.",
        status=Status.FIGURE,
        numbers=numbers_at(RESTITUTIONS, {"exact a_2 at e = {e}": a2_value}),
    )


@derives("soninediffuse")
def _soninediffuse() -> Derived:
    def ratio(e: float) -> float:
        return sonine_slope(e) / float(diffusion_slope_value(e))

    return result(
        None,
        note="The deviation that the paper reports is that of the first Sonine approximation.",
        status=Status.FIGURE,
        numbers=numbers_at((0.6, 0.7, 0.9), {"slope at e = {e}, Sonine over exact": ratio}),
    )
