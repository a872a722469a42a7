"""Tracers that have collided twice, and the front of those that have collided three times."""

import itertools
import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import j0

from kinetics.position import twice_collided
from kinetics.position.front_tail import FrontTail, fit_fronts
from kinetics.position.once_collided import Scatterer
from kinetics.position.twice_collided import (
    inner_fronts,
    twice_density,
    twice_integral,
    twice_scattering,
    twice_within,
)
from kinetics.position.wave_panel import WavePanel, points_between

FloatArray = NDArray[np.float64]
QUICK = ((0.2, 2), (1.0, 3))
CASES = [
    pytest.param(*case, marks=() if case in QUICK else pytest.mark.slow)
    for case in itertools.product((0.0, 0.2, 0.9, 1.0), (2, 3))
]


def of_four_integrals(k: FloatArray, T: float, e: float, dimension: int) -> FloatArray:
    """Their part of F, by the integral over both flights and both deflections: all is smooth.

    Written down again from the law of reflection, v' = v - (1+e) (v.s) s, with vectors.
    """
    node, weight = np.polynomial.legendre.leggauss(14)
    node, weight = 0.5 * (1.0 + node), 0.5 * weight
    # first flight, second flight, and the angles of both collisions to the path: sin = y
    u, v, a, b = np.meshgrid(node, node, node, node, indexing="ij")
    w = np.einsum("i,j,k,l->ijkl", weight, weight, weight, weight)
    first, second = T * u, T * (1.0 - u) * v
    w, third = w * T * T * (1.0 - u), T - first - second
    alpha, beta = 0.5 * math.pi * a, 0.5 * math.pi * b
    for angle in (alpha, beta):
        chance = np.cos(angle) if dimension == 2 else 2.0 * np.sin(angle) * np.cos(angle)
        w = w * 0.5 * math.pi * chance
    v1 = np.stack([1.0 - (1.0 + e) * np.cos(alpha) ** 2, (1.0 + e) * np.cos(alpha) * np.sin(alpha)])
    speed = np.hypot(*v1)
    ahead, aside = v1 / speed, np.stack([-v1[1], v1[0]]) / speed
    out = np.zeros(k.shape)
    # in the plane to either side; in space all round, at 12 angles
    turns = (0.0, math.pi) if dimension == 2 else 2.0 * math.pi * (np.arange(12) + 0.5) / 12
    for turn in turns:
        normal = np.cos(beta) * ahead + np.sin(beta) * math.cos(turn) * aside
        out_of_plane = np.sin(beta) * math.sin(turn)
        loss = (1.0 + e) * speed * np.cos(beta)
        v2, up = v1 - loss * normal, -loss * out_of_plane
        x = first + second * v1[0] + third * v2[0]
        y = second * v1[1] + third * v2[1]
        r = np.sqrt(x**2 + y**2 + (third * up) ** 2)
        after = np.sqrt(v2[0] ** 2 + v2[1] ** 2 + up**2)
        share = w * speed * np.exp(-first - speed * second - after * third) / len(turns)
        for i, one in enumerate(k):
            wave = j0(one * r) if dimension == 2 else np.sinc(one * r / math.pi)
            out[i] += float(np.sum(share * wave))
    return out


@pytest.mark.parametrize(("e", "dimension"), CASES)
def test_their_part_of_f_against_four_integrals(e: float, dimension: int) -> None:
    """The table is right to its quadrature's error, which is smooth in R and cancels in g."""
    T = 3.0
    k = np.array([0.0, 2.0])
    found = twice_scattering(k, T, e, dimension)
    expected = of_four_integrals(k, T, e, dimension)
    assert np.abs(found - expected).max() < 1e-3 * expected[0]
    assert twice_within(np.array([T]), T, e, dimension)[0] == pytest.approx(found[0], rel=1e-9)
    if e == 1.0:
        assert found[0] == pytest.approx(0.5 * T * T * math.exp(-T), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("e", "dimension"), CASES)
def test_with_more_points_the_integral_is_exact(
    e: float, dimension: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, points in (("_IMPACTS", 14), ("_TIMES", 32), ("_ARC", 24), ("_AROUND", 6)):
        monkeypatch.setattr(twice_collided, name, points)
    ends = [0.0, *sorted(inner_fronts(e)), 1.0]
    node, weight = np.polynomial.legendre.leggauss(10)
    t, w = 0.5 * (1.0 + node), 0.5 * weight
    share = 0.0
    for low, high in itertools.pairwise(ends):
        x = low + (high - low) * t**3 * (10.0 - 15.0 * t + 6.0 * t * t)
        slope = 30.0 * (t * (1.0 - t)) ** 2
        share += (high - low) * float(twice_integral(x, 1.0, e, dimension) @ (w * slope))
    assert share == pytest.approx(of_four_integrals(np.zeros(1), 1.0, e, dimension)[0], rel=4e-5)


@pytest.mark.parametrize(
    ("e", "dimension"), [(0.2, 2), pytest.param(0.9, 3, marks=pytest.mark.slow)]
)
def test_the_table_is_the_integral(e: float, dimension: int) -> None:
    """Between its points too, beside the fronts above all; and the slope of what is within."""
    x = np.concatenate([np.linspace(0.03, 0.97, 20), [e - 0.01, e + 0.001, 0.999]])
    table = twice_density(x, 1.0, e, dimension)
    assert np.abs(table - twice_integral(x, 1.0, e, dimension)).max() < 2e-5
    step = 1e-5
    within = [twice_within(x + h, 1.0, e, dimension) for h in (-step, step)]
    assert np.abs((within[1] - within[0]) / (2.0 * step) - table).max() < 1e-5
    assert twice_density(np.array([0.0, 1.0, 1.5]), 1.0, e, dimension).tolist() == [0.0, 0.0, 0.0]


def test_the_front_of_two_equal_deflections() -> None:
    """R is stationary there: in the impact parameter of both, and in their place."""
    e = 0.37
    x, y = np.meshgrid(np.linspace(-0.999, 0.999, 1201), np.linspace(-1.0, 1.0, 1601))
    along, across = -e + (1.0 + e) * y * y, (1.0 + e) * y * np.sqrt(1.0 - y * y)
    place, q = 0.5 * (1.0 + x), along + 1j * across
    r = np.abs(place + (1.0 - place) * q * q)
    grad = np.hypot(*np.gradient(r, y[:, 0], x[0]))
    stationary = r[(grad < 0.004) & (np.abs(y) < 0.99) & (np.abs(y) > 0.01)]
    assert stationary.size
    assert np.abs(stationary - inner_fronts(e)[2]).max() < 1e-3


# at R = T, and on either side of R = T/2
INNER = np.array([[1, 2, 0], [1, 2, 1], [1, 2, 2], [0.5, 2.5, -1], [0.5, 2.5, 2]], dtype=float)


@pytest.mark.parametrize("terms", [INNER[:3], INNER], ids=["front", "inner"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_tails_are_what_they_were_made_of(dimension: int, terms: FloatArray) -> None:
    """A sum of the functions is found again, and its transforms are those of its own F."""
    coefficients = np.array([0.3, -0.5, 0.2, 0.1, -0.2])[: len(terms)]
    if dimension == 3:
        terms = terms + np.array([0.0, 0.5, 0.0]) * (terms[:, :1] < 1.0)
    shape = FrontTail(coefficients, 1.0, dimension, terms)
    ends = np.array([0.0, 20.0, 40.0, 55.0, 70.0])
    panels = [
        WavePanel(low, high, np.array([0]), shape.at(points_between(low, high, 40))[None, :])
        for low, high in itertools.pairwise(ends)
    ]
    found, left = fit_fronts(panels, 0, 1.0, Scatterer(0.5, 1.0, dimension))
    assert found is not None
    k = np.linspace(75.0, 200.0, 50)
    assert np.abs(found.at(k) - shape.at(k)).max() < 1e-3 * np.abs(shape.at(k)).max()
    assert left < 1e-8
    rho = np.array([0.11, 0.4, 0.63, 0.8])
    element, step = rho ** (dimension - 1), 1e-5
    within = [shape.transform(x, 1) * x ** (dimension - 1) for x in (rho - step, rho + step)]
    slope = (within[1] - within[0]) / (2.0 * step)
    assert np.abs(slope / element - shape.transform(rho, 0)).max() < 1e-5
    beside = shape.transform(rho + step, 0) - shape.transform(rho - step, 0)
    assert np.abs(beside / (2.0 * step) + shape.transform(rho, 2)).max() < 1e-5
    x, w = np.polynomial.legendre.leggauss(400)
    x, w = 0.5 * (1.0 + x), 0.5 * w
    k = np.linspace(10.0, 60.0, 9)
    waves = j0(np.outer(k, x)) if dimension == 2 else np.sinc(np.outer(k, x) / math.pi)
    again = waves @ (w * x ** (dimension - 1) * shape.transform(x, 0))
    assert np.abs(again - shape.at(k)).max() < 1e-8
