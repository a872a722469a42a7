"""Particle data, from any code, compared with the kinetic equation.

Begin with `ask.compare_data` (also `compare` here, and `kinetics.compare`): it reads data, fits
what was not told (`fit`), solves the equation (`theory`), judges (`statistics`, `judge`), and looks
for what explains a difference (`causes`). The answer is a `result.Comparison`.
"""

from kinetics.crosscheck.compare.ask import compare_data
from kinetics.crosscheck.compare.result import Comparison

compare = compare_data

__all__ = ["Comparison", "compare", "compare_data"]
