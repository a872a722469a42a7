"""Initial states: what a scene starts from, as weighted points on the axis of ln v.

May import `kinetics.numerics` and `kinetics.errors`. Begin with `state.py`, which says what an
initial state must provide. `isotropic.py` and `directed.py` hold those of the package,
`quadrature.py` the rules by which they become points, `checks.py` the checks of their arguments and
`plain_data.py` what makes them values that can be compared, hashed and pickled.
"""
