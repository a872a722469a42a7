"""Particle data, from any code, compared with the kinetic equation: begin with `ask`."""

from kinetics.crosscheck.compare.ask import compare_data, fit_data
from kinetics.crosscheck.compare.ask import compare_data as compare
from kinetics.crosscheck.compare.result import Comparison

__all__ = ["Comparison", "compare", "compare_data", "fit_data"]
