"""The scaled velocity distribution: its closed form, and the discretised solver.

- `closed_form`: ScalingSolution, with `log_moments` (ln A(z) for any power z), `mellin` (the
  density) and `late_times` (numbers of collisions and path)
- `scaled_vdf`: solve_scaled and its result; with `scaled_axis`, ln g on the axis of speeds, which
  `density_march` solves from the top down, and `panel_losses`, what collisions bring there
- `scaled_state`: what closed form and solver share

May import `kinetics.collision` and `kinetics.numerics`. Begin with `closed_form.py` for the
formulas and with `scaled_vdf.py` for the solver.
"""
