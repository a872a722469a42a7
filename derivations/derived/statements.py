"""Which statements of the paper hold in the exact theory, and what its figures show."""

from __future__ import annotations

from math import pi, sqrt

from .diffusion import sonine_slope
from .record import Status, Verdict, defines, row, statement
from .scaling_state import a2_value, cooling_rate_value, largest_cooling_ratio, slope_value
from .sonine import SONINE_AND_EXACT, at_restitution, roots

statement(
    "statement:h-linear",
    Verdict.IN_PART,
    "Nearly, not exactly: h/(1 - e) starts from sqrt(2), rises by 1 % to its largest value at "
    "e = 0.1464 and falls to 4/3: it varies by 7 % in all. It follows from the exact moments, with "
    "no Sonine expansion.",
    numbers={
        "largest h/(1 - e)": lambda: largest_cooling_ratio()[1],
        "restitution at which it is largest": lambda: largest_cooling_ratio()[0],
        "h/(1 - e) at e = 0": sqrt(2),
        "h/(1 - e) at e = {e}": lambda e: cooling_rate_value(e) / (1 - e),
        "h/(1 - e) as e -> 1": 4 / 3,
    },
)
statement(
    "statement:h-not-haff",
    Verdict.HOLDS,
    "h/(1 - e^2) falls from sqrt(2) to 2/3. A Gaussian VDF would give the constant "
    "sqrt(pi)/2; the exact VDF is never Gaussian.",
    numbers={
        "h/(1 - e^2) at e = 0": sqrt(2),
        "h/(1 - e^2) as e -> 1": 2 / 3,
        "of a Gaussian": sqrt(pi) / 2,
    },
)
statement(
    "statement:a2-missing",
    Verdict.FAILS,
    "Only the truncated equation has no real root there. The exact a_2 exists for every e in "
    "[0, 1) and falls from 2 to -1/2.",
    numbers={"a_2 at e = 0": 2.0, "a_2 at e = {e}": a2_value, "a_2 as e -> 1": -0.5},
    restitutions=(0.2, 0.4, 0.5816, 0.9),
)
statement(
    "statement:sonine-a2",
    Verdict.FAILS,
    "At e = 0.9 it is less than half of the exact value, and as e -> 1 it tends to -0.236 "
    "where the exact a_2 tends to -1/2.",
    numbers={**SONINE_AND_EXACT, "Sonine a_2 as e -> 1": lambda: at_restitution(roots()[0], 1)},
    restitutions=(0.6, 0.7, 0.9),
)
statement(
    "statement:gaussian-f",
    Verdict.FAILS,
    "As e -> 1 it tends to the ring delta(c - 1)/(2 pi), of relative width sqrt((1 - e^2)/5). "
    "Even where a_2 vanishes, at e = 0.5929352, its tail is exponential.",
    numbers={
        "a_2 of a Gaussian": 0.0,
        "a_2 at e = {e}": a2_value,
        "relative width of the speed by the limit at e = 0.9": ((1 - 0.9 * 0.9) / 5) ** 0.5,
    },
)
statement(
    "statement:exponential-f",
    Verdict.HOLDS,
    "F ~ c^(1/(1 - e^2) - 2) exp(-2 c/h): exactly exponential, for every e in [0, 1).",
    numbers={"rate 2/h at e = {e}": lambda e: 2 / float(cooling_rate_value(e))},
)
statement(
    "statement:log-msd",
    Verdict.HOLDS,
    "<r^2> grows as 2 l^2 ln t/[kappa (1 - <cos chi>)]: to the first power of ln t.",
    numbers={"slope at e = {e} (l^2)": slope_value},
)
statement(
    "statement:universal-g",
    Verdict.FAILS,
    "It tends to the Gaussian 2 R exp(-R^2), with corrections of order 1/ln t that depend on "
    "e; at any finite time it differs from e to e and changes.",
    numbers={"<R^4>/<R^2>^2 of the limit": 2.0, "<R^4>/<R^2>^2 of the paper's integral": 4.0},
)
statement(
    "statement:exponential-g",
    Verdict.IN_PART,
    "The paper's integral is 4 R K_0(2 R) once <R^2> = 1: its tail is exponential, but its "
    "peak is not Gaussian (G/R diverges as -ln R). It rests on D_e ~ V^2, which fails even at e = "
    "1. At finite times the free paths do give an exponential tail; the limit is Gaussian.",
    numbers={"decay rate of the paper's integral at <R^2> = 1": 2.0},
)
defines(
    {
        "collision": "Sketch of vchange.",
        "msdtheory": "The fitted l = 13.5 d makes up for the neglected persistence; see msd.",
        "inelasticposi": "Neither curve is normalised to <R^2> = 1; see gammatailg and peakg. The "
        "shapes at four values of e need not be one universal curve; see beyond:position.",
        "impact": "Sketch of the impact parameter b = d sin(pi - psi).",
        "sign": "H is minus and plus sqrt(-383 + 828 e^2 + 900 e^4)/8; see ac7.",
    },
    Status.FIGURE,
)
row(
    "v0re",
    note="The printed line 0.058 t is rho_0 times the fitted 1.45. The exact slopes at the free "
    "path 1/(2 d rho_0) lie below it.",
    status=Status.FIGURE,
    numbers={
        "printed slope": 0.058,
        "exact slope at e = {e}": lambda e: 0.04 * cooling_rate_value(e) / (1 - e),
    },
)
row(
    "hetomu2",
    note="The exact curve exists on the whole of 0 <= e <= 1.",
    status=Status.FIGURE,
    numbers={"exact h at e = {e}": cooling_rate_value},
)
row(
    "scalev",
    note="A projection on one component hides that the exact F vanishes at c = 0 for 0 < e < 1 and "
    "becomes a ring as e -> 1. A Gaussian has a_2 = 0.",
    status=Status.FIGURE,
    numbers={"exact a_2 at e = {e}": a2_value},
)
row(
    "soninediffuse",
    note="The deviation that the paper reports is that of the first Sonine approximation.",
    status=Status.FIGURE,
    numbers={"slope at e = {e}, Sonine over exact": lambda e: sonine_slope(e) / slope_value(e)},
    restitutions=(0.6, 0.7, 0.9),
)
