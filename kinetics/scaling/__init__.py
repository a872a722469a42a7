"""The scaled velocity distribution: its closed form, and the discretised solver.

- `closed_form`: ScalingSolution, formulas; `mellin`: what they take from the complex plane
- `scaled_vdf`: solve_scaled and its result; `axis`: the axis of speeds, marched downwards

May import `kinetics.collision` and `kinetics.numerics`. Begin with `closed_form.py` for the
formulas and with `scaled_vdf.py` for the solver.
"""
