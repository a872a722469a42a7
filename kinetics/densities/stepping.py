r"""The forward equation in steps of logarithmic time, by Fourier collocation.

With Y = v (t + t0)/l, x = ln Y and tau = ln(t + t0) the inelastic Lorentz equation (paper, label
``inelaslorentz2``) has constant coefficients: for the density g of x in harmonic m,

    dg/dtau = -dg/dx - Lambda (e^x g),     Lambda : symbol 1 - E[s^(-i k) cos(m chi)].

Mass is kept to rounding, because the symbol of m = 0 vanishes at k = 0.
"""

from __future__ import annotations

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.log_grid import LogGrid
from kinetics.scaling.symbols import harmonic_symbol

_SHARE = 1e-4  # of rtol that a step may err in g: f = g/v has 100 times it at the lowest speeds
_FINEST, _FINEST_ABSOLUTE = 3e-14, 1e-15  # what rounding allows the integrator to reach


def stepped(
    law: CollisionLaw, grid: LogGrid, rows: FloatArray, m: int, tau: FloatArray, rtol: float
) -> tuple[FloatArray, FloatArray]:
    """g at the nodes of x at the times tau, and the size of its highest modes.

    rows : real and imaginary part of g at tau = 0, shape (n, nodes)
    tau : rising, shape (n_times,)

    Shapes (n_times, n, nodes) and (n_times,).
    """
    from scipy.integrate import solve_ivp

    z = -1j * grid.wave_numbers
    loss = law.decay_symbol(z) if m == 0 else harmonic_symbol(law, z, m)
    # the highest mode of a real transform has no partner: its odd part is left out
    z[-1] = 0.0
    rate = np.exp(grid.x)

    def derivative(_: float, flat: FloatArray) -> FloatArray:
        g = flat.reshape(rows.shape)
        spectrum = z * np.fft.rfft(g) - loss * np.fft.rfft(rate * g)
        return np.asarray(np.fft.irfft(spectrum, grid.nodes).ravel())

    values = np.empty((tau.size, *rows.shape))
    scale = float(np.abs(rows).max())
    now, g = 0.0, rows.ravel()
    # from one output time to the next: the dense output of the method is of lower order
    for i, time in enumerate(map(float, tau)):
        if time > now:
            result = solve_ivp(
                derivative,
                (now, time),
                g,
                method="DOP853",
                t_eval=[time],
                rtol=max(_SHARE * rtol, _FINEST),
                atol=max(_SHARE * rtol, _FINEST_ABSOLUTE) * scale,
                first_step=min(time - now, 1.0 / float(rate[-1])),
            )
            if not result.success:
                raise RuntimeError(f"the forward equation was not integrated: {result.message}")
            g, now = result.y[:, -1], time
        values[i] = g.reshape(rows.shape)
    return values, np.abs(np.fft.rfft(values)[..., -3:]).max(axis=(1, 2))
