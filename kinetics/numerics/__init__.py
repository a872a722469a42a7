"""Numerical methods without physics: panels, quadrature, interpolation, the logarithmic grid.

Imports nothing of this project. Begin with `panels.py`.
"""
