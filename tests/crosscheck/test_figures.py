"""Figures of the equation and of particles: the same quantity has the same axes in both."""

from collections.abc import Iterator

import matplotlib as mpl
import numpy as np
import pytest
from marking import slow_but
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kinetics import ScalingSolution, Scene, Solution, compare, solve, solve_scaled, solve_steady
from particles import BoltzmannGrad, Ensemble, HardDisks, simulate

TIMES = np.array([1.0, 10.0, 100.0, 1000.0])
OVER_TIME = ("thermal_speed", "a2", "msd", "kurtosis", "collisions", "velocity_autocorrelation")
DENSITIES = {
    "speed_density": "speed_histogram",
    "position_density": "displacement_histogram",
}


@pytest.fixture(autouse=True)
def without_open_figures() -> Iterator[None]:
    backend = mpl.get_backend()
    yield
    pyplot.close("all")
    assert mpl.get_backend() == backend


@pytest.fixture(scope="module")
def solution() -> Solution:
    return solve(Scene(0.7, times=TIMES, outputs=(*OVER_TIME, *DENSITIES)), rtol=1e-3)


@pytest.fixture(scope="module")
def run() -> Ensemble:
    histograms = list(DENSITIES.values())
    medium = BoltzmannGrad(0.04)
    return simulate(medium, 0.7, times=TIMES, media=4, tracers=50, observables=histograms)


def axes_of(ax: Axes) -> tuple[str, ...]:
    return ax.get_xlabel(), ax.get_ylabel(), ax.get_xscale(), ax.get_yscale()


def legend_of(ax: Axes) -> list[str]:
    legend = ax.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


@pytest.mark.parametrize("name", OVER_TIME)
def test_an_average_has_the_same_axes_whoever_draws_it(
    solution: Solution, run: Ensemble, name: str
) -> None:
    assert axes_of(run.plot(name)) == axes_of(solution.plot(name))


@pytest.mark.parametrize("name", DENSITIES)
def test_a_density_has_the_same_axes_whoever_draws_it(
    solution: Solution, run: Ensemble, name: str
) -> None:
    assert axes_of(run.plot(DENSITIES[name])) == axes_of(solution.plot(name))


def test_an_average_over_a_short_time_has_linear_axes_whoever_draws_it() -> None:
    times = [1.0, 2.0]
    solution = solve(Scene(0.7, times=times, outputs="msd"))
    run = simulate(BoltzmannGrad(0.04), 0.7, times=times, media=2, tracers=2)
    assert axes_of(run.plot("msd")) == axes_of(solution.plot("msd"))
    assert run.plot("msd").get_xscale() == "linear"


def test_all_averages_of_a_field_have_the_same_axes_whoever_draws_them() -> None:
    outputs = ("mean_velocity", "velocity_tensor", "mean_displacement", "displacement_tensor")
    solution = solve(Scene(0.7, times=TIMES, field=0.1, outputs=outputs), rtol=1e-3)
    run = simulate(BoltzmannGrad(0.04), 0.7, times=TIMES, field=0.1, media=2, tracers=5)
    for name in outputs:
        name_of_run = "dispersion" if name == "displacement_tensor" else name
        assert axes_of(run.plot(name_of_run)) == axes_of(solution.plot(name))


def test_the_title_says_which_system_it_is(solution: Solution, run: Ensemble) -> None:
    for ax in (solution.plot("msd"), run.plot("msd")):
        assert ax.get_title() == "e = 0.7, n = 0.04 d⁻², dilute"
    assert solution.plot()[0].figure.get_suptitle() == "e = 0.7, n = 0.04 d⁻², dilute"
    assert run.plot()[0].figure.get_suptitle() == "e = 0.7, n = 0.04 d⁻², dilute"


def test_the_density_of_a_title_is_in_diameters() -> None:
    solution = solve(Scene(0.7, number_density=0.01, diameter=2.0, times=TIMES, outputs="msd"))
    run = simulate(BoltzmannGrad(0.01, diameter=2.0), 0.7, times=TIMES, media=2, tracers=2)
    for ax in (solution.plot("msd"), run.plot("msd")):
        assert "n = 0.04 d⁻²" in ax.get_title()


def test_both_on_the_same_axes_are_told_apart(solution: Solution, run: Ensemble) -> None:
    ax = run.plot("msd", ax=solution.plot("msd"))
    assert legend_of(ax) == ["equation", "particles (mean and standard error)"]


def test_another_system_on_the_same_axes_is_told_apart(solution: Solution) -> None:
    among_disks = simulate(HardDisks(0.04, count=400), 0.7, times=TIMES, media=2, tracers=2)
    ax = among_disks.plot("msd", ax=solution.plot("msd"))
    assert legend_of(ax)[1] == "particles, hard disks (mean and standard error)"
    other = solve(Scene(0.9, times=TIMES, outputs="msd"))
    first, second = other.plot("msd", ax=solution.plot("msd")).lines
    assert second.get_label() == "equation, e = 0.9"
    assert first.get_color() != second.get_color()


def test_densities_at_the_same_times_have_the_same_colours(
    solution: Solution, run: Ensemble
) -> None:
    ax = run.plot("speed_histogram", ax=solution.plot("speed_density"))
    of_equation = [line.get_color() for line in ax.lines[: TIMES.size]]
    of_particles = [container.lines[0].get_color() for container in ax.containers]
    assert of_particles == of_equation
    assert len(set(of_equation)) == TIMES.size
    for label, time in zip(legend_of(ax)[: TIMES.size], TIMES, strict=True):
        assert label.startswith("equation")
        assert f"{time:g}" in label


@pytest.mark.parametrize("name", ["msd", "a2", "speed_density"])
def test_the_legend_covers_no_data(solution: Solution, run: Ensemble, name: str) -> None:
    ax = run.plot(DENSITIES.get(name, name), ax=solution.plot(name))
    ax.figure.draw_without_rendering()
    legend = ax.get_legend()
    assert legend is not None
    assert not ax.bbox.overlaps(legend.get_window_extent())
    assert ax.figure.bbox.contains(*legend.get_window_extent().min)
    assert not ax.xaxis.label.get_window_extent().overlaps(legend.get_window_extent())


def test_a_comparison_has_the_axes_of_a_solution(solution: Solution, run: Ensemble) -> None:
    comparison = compare(run, restitution=0.7, number_density=0.04, scatterers="dilute")
    for name in ("msd", "a2", "thermal_speed", "kurtosis"):
        ax = comparison.plot(name)
        assert axes_of(ax) == axes_of(solution.plot(name))
        assert ax.get_title() == "e = 0.7, n = 0.04 d⁻², dilute"
        assert len(legend_of(ax)) == 2


# -- the scaled distribution -----------------------------------------------------------------------


@pytest.mark.parametrize("scaled", [ScalingSolution(0.7), solve_scaled(0.7)])
def test_the_scaled_distribution_is_drawn_with_a_gaussian_and_its_tail(
    scaled: ScalingSolution,
) -> None:
    ax = scaled.plot("vdf", c=np.linspace(0.1, 6.0, 60))
    curves = {line.get_label().split()[0]: line.get_xydata() for line in ax.lines}
    assert set(curves) == {"equation", "Gaussian", "tail"}
    c, density = curves["equation"].T
    np.testing.assert_allclose(density, scaled.vdf(c))
    c, gaussian = curves["Gaussian"].T
    np.testing.assert_allclose(gaussian, np.exp(-(c**2)) / np.pi)
    c, tail = curves["tail"].T
    assert tail[-1] == pytest.approx(scaled.vdf(c[-1]), rel=0.2)  # corrections are of order 1/c
    exact = ScalingSolution(0.7)
    slope = np.diff(np.log(tail)) / np.diff(c)
    middle = 0.5 * (c[1:] + c[:-1])
    np.testing.assert_allclose(slope, exact.tail_power / middle - exact.tail_rate, rtol=1e-3)
    assert ax.get_yscale() == "log"
    assert ax.get_title() == "e = 0.7, dilute"


def test_moments_of_the_scaled_distribution_are_points() -> None:
    points = ScalingSolution(0.7).plot("moment").lines[0]
    assert points.get_linestyle() == "None"
    p, moments = points.get_data()
    np.testing.assert_allclose(moments, [ScalingSolution(0.7).moment(power) for power in p])


def test_plot_of_a_scaled_distribution_draws_both() -> None:
    assert len(ScalingSolution(0.7).plot()) == 2
    assert len(ScalingSolution(1.0).plot()) == 1  # without a distribution


@pytest.mark.parametrize(
    ("e", "tangential"),
    slow_but(
        [(0.0, 1.0), (0.3, 0.5), (0.99, 1.0), (1.0, 1.0), (1.0, 0.5)],
        [(e, tangential) for e in (0.0, 0.3, 0.99, 1.0) for tangential in (1.0, 0.5)],
    ),
)
def test_every_scaled_distribution_can_be_drawn(e: float, tangential: float) -> None:
    for ax in ScalingSolution(e, tangential_restitution=tangential).plot():
        ax.figure.draw_without_rendering()


def test_a_steady_state_is_not_drawn_below_its_error() -> None:
    ax = solve_steady(0.7, bath_speed=1.0, rtol=1e-3).plot("vdf", ax=Figure().subplots())
    bottom, top = ax.get_ylim()
    assert bottom > 1e-4 * top
