"""What a terminal and a notebook show of every result: values, units, a status, nothing hidden."""

import math
import re
from collections.abc import Callable
from html import unescape
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from kinetics import (
    ScalingSolution,
    Scene,
    compare,
    solve,
    solve_field,
    solve_scaled,
    solve_steady,
)
from kinetics.results.table import number_text
from particles import BoltzmannGrad, Ensemble, HardDisks, simulate

WIDTH = 100
TIMES = np.geomspace(1.0, 1000.0, 20)
LONG = (
    "thermal_speed", "temperature", "a2", "collisions", "msd", "kurtosis",
    "velocity_autocorrelation", "mean_displacement", "mean_velocity", "velocity_tensor",
)  # fmt: skip


def run() -> Ensemble:
    return simulate(HardDisks(0.04, count=400), 0.7, times=TIMES, media=12, tracers=4)


RESULTS: dict[str, Callable[[], Any]] = {
    "scene": lambda: Scene(0.7, times=TIMES, outputs=LONG),
    "solution": lambda: solve(Scene(0.7, times=TIMES, outputs=LONG), rtol=1e-6),
    "ensemble": run,
    "scaling solution": lambda: ScalingSolution(0.7),
    "scaled solver": lambda: solve_scaled(0.7),
    "driven state": lambda: solve_steady(0.7, bath_speed=1.0),
    "field state": lambda: solve_field(0.7),
    "comparison": lambda: compare(run(), restitution=0.7, number_density=0.04),
    "estimate": lambda: run().msd,
}
#: What the table of each must say: a value, a unit, a status.
SAID = {
    "scene": ["0.7", "12.5", "dilute", "d/U", "msd"],
    "solution": ["e = 0.7", "0.0573978", "U", "converged", "1e-06"],
    "ensemble": ["e = 0.7", "hard disks", "±", "d^2", "finished=48"],
    "scaling solution": ["0.412181911126", "-0.173315658655", "closed form"],
    "scaled solver": ["0.412181911126", "-0.173315658655", "converged"],
    "driven state": ["3.3665016", "bath speed = 1", "converged"],
    "field state": ["0.5019261", "sqrt(g l)", "converged"],
    "comparison": ["restitution", "msd", "agrees"],
    "estimate": ["±"],
}


class Balanced(HTMLParser):
    """Checks that tags are closed in their order, and gathers the text."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.words: list[str] = []
        self.feed(html)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)


@pytest.mark.parametrize("name", RESULTS)
def test_a_notebook_shows_values_units_and_status(name: str) -> None:
    html = RESULTS[name]()._repr_html_()
    text = " ".join(Balanced(html).words)
    assert "<table" in html
    for said in SAID[name]:
        assert said in text


@pytest.mark.parametrize("name", RESULTS)
def test_a_text_has_no_line_that_is_too_long_and_hides_nothing(name: str) -> None:
    text = repr(RESULTS[name]())
    assert max(len(line) for line in text.splitlines()) <= WIDTH
    assert "more" not in text


def test_names_in_tables_are_escaped() -> None:
    run_of_data = run()
    comparison = compare(run_of_data, restitution=0.7, number_density=0.04)
    object.__setattr__(comparison, "summary", "<script>alert(1)</script>")
    assert "<script>" not in comparison._repr_html_()
    assert "<script>alert(1)</script>" in unescape(comparison._repr_html_())


def test_an_estimate_shows_every_time() -> None:
    lines = repr(run().msd).splitlines()
    assert len(lines) == 1 + TIMES.size


def test_an_estimate_of_vectors_shows_every_component() -> None:
    falling = simulate(BoltzmannGrad(0.04), 0.7, times=[1.0, 2.0], field=0.1, media=4, tracers=4)
    text = repr(falling.mean_velocity)
    assert text.count("±") == 4


def test_one_configuration_says_that_errors_are_unknown() -> None:
    alone = simulate(BoltzmannGrad(0.04), 0.7, times=[10.0, 100.0], media=1, tracers=4)
    for text in (repr(alone.msd), alone.msd._repr_html_(), alone._repr_html_()):
        assert "inf" not in text
        assert "unknown" in text


def test_a_number_that_is_smaller_than_its_error_is_zero() -> None:
    state = solve_steady(0.7, bath_speed=1.0)
    assert 0.0 < abs(state.a2) < state.error_estimate
    assert "a2 = 0," in repr(state)
    solution = solve(Scene(0.7, times=[1000.0], outputs="velocity_autocorrelation"), rtol=1e-3)
    assert re.search(r"velocity_autocorrelation</th><td>0</td>", solution._repr_html_())


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.123456789, 1e-3, "0.1235"),
        (1234.56789, 1.0, "1234.6"),
        (-7.5e-13, 1e-10, "0"),
        (0.0, 1e-3, "0"),
        (12.5, None, "12.5"),
        (3.0e-8, 1e-10, "3.000e-08"),
        (math.inf, None, "inf"),
        (math.nan, 1.0, "nan"),
    ],
)
def test_a_number_has_the_digits_of_its_error(value: float, error: float, text: str) -> None:
    assert number_text(value, error) == text
