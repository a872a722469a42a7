"""Mean free paths and elastic diffusion at length: run on demand."""

import numpy as np
import pytest

from particles import Poisson, simulate

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("density", "flights", "media"),
    [(0.01, 2000, 24_000), (0.04, 2000, 24_000), (0.2, 50, 600_000)],
)
def test_mean_free_path_of_overlapping_scatterers_to_a_part_in_a_thousand(
    density: float, flights: int, media: int
) -> None:
    # Santalo: 1/(2 d rho0), in a periodic box of area A with a fixed number of scatterers times
    # 1 - pi d^2/A. At 0.2 a tracer may start in a small pocket and stay there: many starts, not
    # long paths, bring the error down.
    medium = Poisson(density, 500)
    expected = 0.5 / density * (1 - np.pi / medium.box_side**2)
    ensemble = simulate(
        medium, 1.0, "monoenergetic", times=[flights * expected], media=media, tracers=1, seed=2
    )
    path = ensemble.mean_free_path
    assert path.error < 7e-4 * path.value
    assert abs(path.value / expected - 1) < 1e-3


def diffusion(density: float, media: int = 15_000, tracers: int = 8) -> tuple[float, float]:
    """Return D / D_Boltzmann and its error: slope of <r^2> between 60 and 180 free times.

    By then the slope has settled: what is left of the velocity's memory falls as 1/t^2.
    """
    length = 0.5 / density
    times = np.array([60.0, 180.0]) * length
    ensemble = simulate(
        Poisson(density, box=None), 1.0, "monoenergetic", times=times, media=media, tracers=tracers,
        observables=["positions"], seed=3,
    )  # fmt: skip
    r2 = np.sum(ensemble.positions**2, axis=-1).reshape(2, media, tracers).mean(axis=-1)
    slopes = (r2[1] - r2[0]) / (times[1] - times[0])
    # Boltzmann: <r^2> = 4 D t with D = 3/8 l v.
    ratios = slopes / (1.5 * length)
    return ratios.mean(), ratios.std() / np.sqrt(media)


def test_elastic_diffusion_among_overlapping_scatterers() -> None:
    # Measured before, by another program, to 0.001 or 0.002.
    expected = {0.005: 0.970, 0.01: 0.947, 0.02: 0.908}
    densities = np.array([0.00125, 0.0025, 0.005, 0.01, 0.02])
    values, errors = np.array([diffusion(density) for density in densities]).T
    for density, value, error in zip(densities, values, errors, strict=True):
        assert error < 0.005
        if density in expected:
            assert abs(value - expected[density]) < 0.01, (density, value, error)
    # To zero density: D_B/D = 1 + a rho ln rho + b rho + ... A logarithm is expected (van Leeuwen &
    # Weijland, Physica 36, 457, 1967); its coefficient is fitted here like the others.
    x, y, sigma = densities, 1 / values, errors / values**2
    columns = np.stack([np.ones(x.size), x * np.log(x), x]).T / sigma[:, None]
    covariance = np.linalg.inv(columns.T @ columns)
    limit = (covariance @ columns.T @ (y / sigma))[0]
    assert abs(limit - 1) < 3 * np.sqrt(covariance[0, 0]), (values, errors, limit)
