"""The distribution of the displacement: F(k, t), g(r, t) and G(R).

May import `kinetics.moments`, `kinetics.states`, `kinetics.collision` and `kinetics.numerics`.
Begin with `scattering.py`: one system of equations for each wave number.
"""
