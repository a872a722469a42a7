"""Initial states: what a scene starts from, as weighted points on the axis of ln v.

May import `kinetics.numerics`, `kinetics.results`, `kinetics.validation`, `kinetics.errors`. Begin
with `state`, which says what an initial state must provide.

- `state`: the contract
- `kinds`: the states of the package
- `points`: rules that turn Gaussians, tables and samples into weighted points
- `function_points`: the same for functions, with `density_scan` and `halved_panels`
"""
