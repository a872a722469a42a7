"""Derivations with sympy: what the paper prints, re-derived and judged."""
