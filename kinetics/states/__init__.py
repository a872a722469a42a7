"""Initial states: what a scene starts from, as weighted points on the axis of ln v.

May import `kinetics.numerics`, `kinetics.results`, `kinetics.validation`, `kinetics.errors`. Begin
with `state.py`: it says what an initial state must provide, and has the rules by which it becomes
points. `kinds.py` holds the states of the package.
"""
