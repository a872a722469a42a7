"""solve(scene): solves the parts that the outputs of a scene need, and no other.

Begin with :func:`solve`. What an output is made of is in `kinetics.outputs`, how its parts are
solved in `kinetics.answer`.
"""

from __future__ import annotations

import warnings

from kinetics.answer import answer_to
from kinetics.errors import ToleranceWarning
from kinetics.scene import Scene
from kinetics.solution import Solution
from kinetics.status import SolverStatus
from kinetics.validation import check_rtol, one_of, refuse, whole_number

METHODS = ("spectral", "conservative")


def solve(
    scene: Scene, rtol: float | None = None, method: str | None = None, nodes: int | None = None
) -> Solution:
    """Solve the inelastic Lorentz equation for what the scene asks.

    Parameters
    ----------
    scene : system, initial state, times and outputs
    rtol : relative accuracy of every average (of 1 + a2 for a2; of <v^p> for its harmonics; of
        v_rms(0) v_rms(t), v_rms = sqrt(<v^2>), for velocity_autocorrelation), and of the densities
        relative to their maximum, for speeds above 1e-2 of the thermal one; below it
        is the density of ln v that keeps it. 1e-14 to 0.1. The scaled position density G(R) is
        solved to max(rtol, 1e-8), absolute. By default 1e-10; 1e-8 for driven tracers, 1e-6 with a
        field, and densities of both are solved to max(rtol, 1e-4)
    method : how densities are made: "spectral" (for smooth states), "conservative" (mass and
        positivity exact, second order, for rough ones), or None for the solver's choice. Averages
        need no density, and are the same for either.
    nodes : of the speed axis of the densities, 8 to 8192, for convergence studies

    Returns
    -------
    Solution : frozen; arrays with time as the first axis, under the names of the outputs

    Warns
    -----
    ToleranceWarning : the status is not CONVERGED

    Raises
    ------
    InputError (a ValueError) : an argument out of range, a density that is negative, not
        normalised or without second moment, or a method that cannot do the scene

    >>> from kinetics import Scene
    >>> solution = solve(Scene(restitution=0.7, times=[0.0, 1e3, 1e6]))
    >>> bool(abs(solution.thermal_speed[0] - 2**0.5) < 1e-10)
    True
    """
    if not isinstance(scene, Scene):
        refuse("scene", scene, "it must be a Scene")
    if rtol is None:
        rtol = 1e-6 if scene.field else 1e-8 if scene.system else 1e-10
    rtol = check_rtol(rtol)
    method = None if method is None else one_of("method", method, METHODS)
    nodes = None if nodes is None else whole_number("nodes", nodes, 8, 8192)
    solution = Solution.of(answer_to(scene, rtol, method, nodes), scene, rtol, method, nodes)
    if solution.status is not SolverStatus.CONVERGED:
        warnings.warn(solution.message, ToleranceWarning, stacklevel=2)
    return solution
