"""The finite density of the scatterers, as a hypothesis without a free parameter."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from marking import slow_but

from kinetics import Scene, solve
from kinetics.crosscheck import compare
from kinetics.crosscheck.comparison import finite_density
from kinetics.crosscheck.comparison.data.ensemble_files import from_ensemble
from kinetics.crosscheck.comparison.data_and_theory import side_by_side
from kinetics.crosscheck.comparison.question import compare_sample
from kinetics.crosscheck.comparison.result import Comparison, Explanation
from kinetics.crosscheck.comparison.statistics import hotelling, log_widening
from kinetics.crosscheck.comparison.theory import AVERAGES, Expectation, SampledStart
from particles import BoltzmannGrad, HardDisks, Poisson, simulate

DENSITY = 0.04
PATH = 12.5
TIMES = np.geomspace(1.0, 400.0, 7) * PATH


@cache
def run_of(scatterers: str, e: float, media: int = 100) -> Any:
    """10,000 tracers, 100 to a configuration."""
    medium = {
        "hard disks": HardDisks(DENSITY, 5000),
        "overlapping": Poisson(DENSITY),
        "dilute": BoltzmannGrad(DENSITY),
    }[scatterers]
    return simulate(
        medium, restitution=e, times=[0.0, *TIMES], media=media, tracers=100,
        max_collisions=None, seed=5, workers=1,
    )  # fmt: skip


def sample_of(scatterers: str, e: float) -> Any:
    """As from a file, that does not say which particles meet no scatterer again."""
    return replace(from_ensemble(run_of(scatterers, e)), free=False)


@cache
def compared(scatterers: str, e: float) -> Comparison:
    """With what the sample says of itself."""
    return compare_sample(sample_of(scatterers, e))


def densities(result: Comparison) -> list[Explanation]:
    return [item for item in result.explanations if item.name == "finite density"]


@pytest.mark.parametrize(
    ("scatterers", "e"),
    [
        ("hard disks", 0.7),
        pytest.param("overlapping", 0.9, marks=pytest.mark.slow),
        pytest.param("hard disks", 0.9, marks=pytest.mark.slow),
        pytest.param("overlapping", 0.7, marks=pytest.mark.slow),
    ],
)
def test_the_density_is_the_headline(scatterers: str, e: float) -> None:
    result = compared(scatterers, e)
    assert result.verdict == "differs"
    words = f"the finite density of the scatterers ({scatterers}, no fitted number)"
    assert result.summary.startswith(f"They differ; {words} explains it.")
    first, other = densities(result)
    assert result.explanations[0] is first
    assert (first.outcome, first.value, first.error) == ("explains", None, None)
    # the other medium, whose free path differs by 5 %, is told apart, and so is all else
    assert other.outcome != "explains"
    assert first.p_value is not None
    assert first.p_value > 0.05
    for item in result.explanations:
        if item.name in ("free path", "recollisions", "restitution", "tracers at rest"):
            assert item.outcome in ("in part", "does not"), item.name


def test_the_text_says_what_is_known_of_the_theory() -> None:
    (text,) = (item.text for item in densities(compared("hard disks", 0.7))[:1])
    assert 'Scene(scatterers="hard disks")' in text
    assert "Nothing is fitted to these data" in text
    dense, dilute = (
        solve(Scene(0.7, DENSITY, times=TIMES, outputs=("thermal_speed", "msd"), scatterers=kind))
        for kind in ("hard disks", "dilute")
    )
    for symbol, name in (("v₀", "thermal_speed"), ("⟨r²⟩", "msd")):
        change = getattr(dense, name)[-1] / getattr(dilute, name)[-1] - 1
        assert f"{symbol} by {change:+.2%}".replace("-", "−") in text
    assert "trusted from 30 l/U = 375 d/U on; 4 of the 7 times are earlier" in text
    # .2 n of <r^2> from there on and .8 n before
    assert "0.80% of ⟨r²⟩ from that time on, 0.40% and 3.20% before" in text
    assert "up to n" not in text


@pytest.mark.parametrize("e", [0.7, pytest.param(0.9, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "wrong", slow_but(["density", "nothing"], ["density", "restitution", "nothing"])
)
def test_independent_flights_are_not_explained_by_a_density(e: float, wrong: str) -> None:
    density = 1.05 * DENSITY if wrong == "density" else DENSITY
    told = e - 0.02 if wrong == "restitution" else e
    result = compare_sample(sample_of("dilute", e), told, density)
    if wrong == "nothing":
        assert (result.verdict, densities(result)) == ("agrees", [])
        return
    assert result.explanations[0].name == {"density": "free path"}.get(wrong, wrong)
    assert result.explanations[0].outcome == "explains"
    assert {item.outcome for item in densities(result)} <= {"in part", "does not"}


def test_a_wrong_restitution_among_hard_disks_is_not_explained_by_the_density() -> None:
    result = compare_sample(sample_of("hard disks", 0.9), 0.92)
    assert result.verdict == "differs"
    assert {item.outcome for item in densities(result)} <= {"in part", "does not"}


@pytest.mark.slow
def test_it_is_tried_only_where_the_theory_is_defined() -> None:
    sample = sample_of("hard disks", 0.7)

    def known(data: Any, e: float = 0.7, density: float = DENSITY, **more: Any) -> bool:
        scene = Scene(e, density, times=sample.times, outputs=("thermal_speed",), **more)
        return finite_density.is_known(side_by_side(solve(scene), data))

    assert known(sample)
    assert known(sample, 0.2, 0.3)
    assert not known(sample, density=0.31)
    assert not known(sample, 0.15)
    assert not known(replace(sample, law=replace(sample.law, tangential_restitution=0.9)))
    assert not known(sample, scatterers="hard disks")
    # Boltzmann-Grad particles of this package are known to meet no scatterer again
    assert not known(from_ensemble(run_of("dilute", 0.7)))
    # a density that is fitted to the same data is no density that is known
    fitted = compare_sample(replace(sample, told={"restitution": 0.7}))
    assert fitted.verdict == "differs"
    assert densities(fitted) == []
    beyond = densities(compare_sample(sample, 0.7, 0.12))[0].text
    assert "compared with simulations up to n = 0.1 only" in beyond


@pytest.mark.slow
def test_the_diameter_of_the_scene_enters_the_density() -> None:
    """Lengths in half a diameter: the same system."""
    halves = sample_of("hard disks", 0.7).rescaled(1.0, 0.5)
    scene = Scene(0.7, DENSITY / 4, diameter=2.0, times=halves.times, outputs=AVERAGES)
    result = compared("hard disks", 0.7), compare(solve(scene), halves)
    one, two = (densities(item)[0] for item in result)
    assert two.outcome == "explains"
    assert one.chi_square_after is not None
    assert two.chi_square_after == pytest.approx(one.chi_square_after, rel=1e-3)


@pytest.mark.slow
def test_the_speeds_of_the_data_may_be_the_start() -> None:
    """Speeds that were drawn from a Gaussian: nearly its theory, in the medium too."""
    run = simulate(
        HardDisks(DENSITY, 5000), restitution=0.7, times=[0.0, *TIMES[::2]], media=40, tracers=100,
        max_collisions=None, seed=3, workers=1, observables=("positions", "velocities"),
    )  # fmt: skip
    sample = from_ensemble(run)
    assert sample.start is not None
    expectation = Expectation(sample, ("thermal_speed", "msd"))
    own, named = (
        expectation.theory(0.7, PATH, start, "hard disks")[0][:, 1:]
        for start in (SampledStart(sample.start), "gaussian")
    )
    dilute = expectation.theory(0.7, PATH, "gaussian")[0][:, 1:]
    # <v^2> of 4000 tracers is known to 1/sqrt(4000)
    assert own == pytest.approx(named, rel=3.5 / np.sqrt(4000))
    assert own[1, -1] / dilute[1, -1] < 0.85
    result = compare_sample(sample, initial="data")
    assert result.initial == "the data's own speeds at time 0"
    assert densities(result)[0].outcome == "explains"


def test_the_error_of_the_theory_is_added_and_counted() -> None:
    rng = np.random.default_rng(2)
    data = rng.normal(size=(400, 3))
    left_out = (data.sum(axis=0) - data) / 399
    known = np.diag([0.5, 0.0, 0.0])
    difference = np.array([1.0, 0.0, 0.0])
    plain, wide = hotelling(difference, left_out), hotelling(difference, left_out, known)
    assert plain is not None
    assert wide is not None
    assert plain.statistic == pytest.approx(400, rel=0.2)
    assert wide.statistic == pytest.approx(1 / (0.5 + 1 / 400), rel=0.01)
    assert log_widening(left_out, known) == pytest.approx(np.log(1 + 0.5 * 400), rel=0.03)
    assert log_widening(left_out, 0 * known) == 0.0


def test_the_covariance_of_the_theory_is_that_of_its_error() -> None:
    sample = sample_of("hard disks", 0.7)
    solution = solve(Scene(0.7, DENSITY, times=sample.times, outputs=AVERAGES))
    both = side_by_side(solution, sample)
    found = finite_density.covariance(both, both.theory)
    n = sample.times.size
    assert np.all(np.diagonal(found).reshape(4, n)[:, 0] == 0.0)  # at time 0 the start is told
    size = np.abs(both.theory + np.array([[0], [1], [0], [0]]))[:, 1:]
    relative = np.sqrt(np.diagonal(found).reshape(4, n)[:, 1:]) / size
    late = sample.times[1:] >= 30 * PATH
    for k, name in enumerate(AVERAGES):
        before, after = finite_density.OWN_ERROR[name]
        assert relative[k, late] == pytest.approx(after * DENSITY)
        assert relative[k, ~late] == pytest.approx(before * DENSITY)
    assert np.all(np.linalg.eigvalsh(found) > -1e-9 * found.max())
    # averages are independent, times a factor of ten apart have the correlation 1/e
    assert np.all(found[:n, n:] == 0.0)
    error = np.sqrt(np.diagonal(found))
    expected = np.exp(-np.log10(sample.times[-1] / sample.times[-3]))
    assert found[n - 1, n - 3] / error[n - 1] / error[n - 3] == pytest.approx(expected)
