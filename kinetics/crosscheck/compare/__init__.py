"""Particle data, from any code, compared with the kinetic equation: begin with `ask`.

    ask -> data.reading -> Sample -> Measured -> Fit -> Judgement -> Comparison

- `observables`: what is compared, one row each; `measured`: its values in a sample
- `point`, `theory`, `frames_theory`: the theory, at a point with all its numbers
- `pool`: simulated tracers, how averages scatter by chance; `residuals`, `statistics`: tests
- `selection`, `parameters`, `fit`: the fit; `media`, `starts`: what it is of
- `densities`, `judge`: rows, tests, and the p-value of the verdict
- `causes`, `noted`, `wrong_unit`: what may explain a difference
- `answer`, `result`: the comparison, in words, tables and figures
"""

from kinetics.crosscheck.compare.ask import compare_data, fit_data
from kinetics.crosscheck.compare.ask import compare_data as compare
from kinetics.crosscheck.compare.result import Comparison

__all__ = ["Comparison", "compare", "compare_data", "fit_data"]
