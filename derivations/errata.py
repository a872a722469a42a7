"""The nine errata of the paper: what is printed, what is right, and what it changes.

The one list of them for ``lorentz derive``, for the documentation and for the report. That they
are errata is decided elsewhere, by derivation: :func:`derivations.verify` gives exactly these
labels the status "erratum".
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Erratum:
    """One printed formula that does not follow, in words.

    ``label`` and ``number`` name the equation, as in :class:`derivations.Check` and in the paper;
    ``printed`` and ``correct`` say what stands there and what should; ``changes`` says which
    results of the paper it touches.
    """

    label: str
    number: str
    printed: str
    correct: str
    changes: str


ERRATA: tuple[Erratum, ...] = (
    Erratum(
        label="diffuse7",
        number="31",
        printed="Order j of the change of n is -nabla^(0).J^(j).",
        correct="It is the sum of -nabla^(i).J^(j-i) over i from 0 to j, by (33).",
        changes="Nothing at the orders that the paper uses, since J^(0) vanishes; the diffusion "
        "equation (46) stays. From order 2 on it does.",
    ),
    Erratum(
        label="normg",
        number="47",
        printed="A Gaussian with <r^2> = 8 int D_e dt.",
        correct="The diffusion equation (46) gives <r^2> = 4 int D_e dt, as (C8) says too: "
        "r/(2 I) exp(-r^2/(4 I)) with I = int D_e dt.",
        changes="eta: <R^2> = 1 needs eta = 1/2 with the printed form, eta = 1 with the right one. "
        "The undetermined prefactor of D_e(V, t) absorbs the factor 2; the shape of G(R) stays.",
    ),
    Erratum(
        label="tailg",
        number="56",
        printed="The integral about the saddle is the root of pi/(2 p'').",
        correct="It is the root of 2 pi/p'', twice as large.",
        changes="G(R) at large R, by the factor 2, which the fitted gamma of (58) absorbs.",
    ),
    Erratum(
        label="semig",
        number="57",
        printed="The tail of G(R) with the prefactor that follows from (56).",
        correct="Twice that.",
        changes="The height of the tail; its decay rate, the root of 2/eta, stays.",
    ),
    Erratum(
        label="ad5",
        number="C5",
        printed="The Sonine form of f without the factor n.",
        correct="By (3) and (10) the integral of f over v is n, not 1.",
        changes="Nothing: nu_D is a ratio, in which the factor cancels.",
    ),
    Erratum(
        label="ad8",
        number="C8",
        printed="<r^2> is 4 times the integral of D_e(t) over t'.",
        correct="The integrand is D_e(t').",
        changes="Nothing if read as meant. Taken literally, 4 t D_e(t) levels off where <r^2> "
        "grows as ln t.",
    ),
    Erratum(
        label="ap1",
        number="D1",
        printed="Continuity over all speeds with the weight 2 pi v.",
        correct="The weight is v: n(r, v, t) of (D2) is already summed over directions.",
        changes="Nothing: the other side is zero.",
    ),
    Erratum(
        label="ap4",
        number="D4",
        printed="At each speed the density changes by its flux alone.",
        correct="Collisions move tracers from one speed to another: the right-hand side is the "
        "collision term summed over directions, which is zero only at e = 1.",
        changes="The expansion at one speed, all of Appendix D, is not justified for e < 1.",
    ),
    Erratum(
        label="ap7",
        number="D6",
        printed="Order j of the change of n at one speed is -nabla^(0).J^(j).",
        correct="It is the sum of -nabla^(i).J^(j-i) over i from 0 to j, as in (31).",
        changes="Nothing at the orders that the paper uses, since J^(0) vanishes; from order 2 on "
        "it does.",
    ),
)
"""All of them, in the order of the paper."""
