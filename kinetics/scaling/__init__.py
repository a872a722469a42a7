"""The scaled velocity distribution F(c): its closed form, and the discretised solver.

May import `kinetics.collision` and `kinetics.numerics`. Begin with `closed_form.py` for the
formulas and with `scaled_vdf.py` for the solver.
"""
