"""The rows of a uniform field against numbers, and against the definition of the derivative."""

import math

import numpy as np
import pytest
import sympy as sp

from derivations import symbols as s
from derivations.derived.uniform_field import field_row
from derivations.printed import printed_equation


@pytest.mark.parametrize(("dimension", "m"), [(d, m) for d in (2, 3) for m in (0, 1, 2)])
def test_rows_against_a_function_of_the_vector(dimension: int, m: int) -> None:
    """f = v_z^3 + v^2 v_z has the harmonics 1 and 3; its derivative by v_z is 4 v_z^2 + ..."""
    x = np.polynomial.legendre.leggauss(20)
    angles = (np.arange(64) + 0.5) * math.pi / 64
    cosine, weight = (np.cos(angles), np.full(64, 1 / 64)) if dimension == 2 else (x[0], x[1] / 2)

    def harmonic(values: np.ndarray, k: int) -> float:
        basis = np.cos(k * np.arccos(cosine)) if dimension == 2 else legendre(k)
        return float((values * basis) @ weight / ((basis**2) @ weight))

    def legendre(k: int) -> np.ndarray:
        return np.polynomial.legendre.legval(cosine, [0.0] * k + [1.0])

    v = 1.3
    parts = {
        f(s.v): s.v**3 * harmonic(cosine**3 + cosine, k)
        for k, f in enumerate((s.f0, s.f1, s.f2, s.f3))
    }
    row = field_row(dimension, m).subs(parts).doit().subs(s.v, v)
    # d/dv_z of v_z^3 + v^2 v_z = 3 v_z^2 + 2 v_z^2 + v^2
    exact = harmonic(v**2 * (5 * cosine**2 + 1), m)
    assert float(row) == pytest.approx(exact, abs=1e-12)


def test_constants_of_the_nearly_elastic_limit() -> None:
    formula = printed_equation("beyond:field-nearly-elastic").formula
    values = [float(sp.N(row.rhs.subs({s.deficit: 1}))) for row in formula if row.lhs != s.f0(s.v)]
    expected = [0.52666478, 0.37760980, 0.63452714, 0.41337540]
    assert values == pytest.approx(expected, abs=5e-9)
