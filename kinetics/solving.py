"""The verbs: `solve` answers one scene, `sweep` a line of restitutions."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from kinetics.errors import ModelWarning, SolverStatus, ToleranceWarning
from kinetics.model_error import warning_of_density
from kinetics.scene import Scene
from kinetics.solution import Solution
from kinetics.validation import check_rtol, finite_line, one_of, refuse, whole_number

if TYPE_CHECKING:
    import xarray

#: How densities can be made.
METHODS = ("spectral", "conservative")
#: The relative accuracy that is asked for by default.
DEFAULT_RTOL = 1e-10
#: The same of driven tracers, which take longer.
DEFAULT_RTOL_OF_DRIVEN = 1e-8
#: The same in a field.
DEFAULT_RTOL_IN_FIELD = 1e-6
#: Nodes of the speed axis of densities that can be asked for.
MIN_NODES = 8
#: The largest number of these nodes.
MAX_NODES = 8192


def solve(
    scene: Scene, rtol: float | None = None, method: str | None = None, nodes: int | None = None
) -> Solution:
    """Solve the inelastic Lorentz equation for the outputs of a scene.

    Parameters
    ----------
    scene
        System, initial state, times and outputs.
    rtol
        Relative accuracy, 1e-14 to 0.1, of every average (of 1 + a2 for a2; of <v^p> for its
        harmonics; of v_rms(0) v_rms(t), v_rms = sqrt(<v^2>), for velocity_autocorrelation), and of
        the densities relative to their maximum, for speeds above 1e-2 of the thermal one; below it
        is the density of ln v that keeps it. The scaled position density G(R) is solved to
        max(rtol, 1e-8), absolute. By default 1e-10; 1e-8 for driven tracers, 1e-6 with a field, and
        densities of both are solved to max(rtol, 1e-4).
    method
        How densities are made: "spectral" (for smooth states), "conservative" (mass and positivity
        exact, second order, for rough ones), or None for the solver's choice.
    nodes
        Of the speed axis of the densities, 8 to 8192, for convergence studies.

    Returns
    -------
    Solution
        Its status says whether the accuracy was reached.

    Raises
    ------
    InputError
        A ValueError: an argument out of range, a density that is negative, not normalised or
        without second moment, or a method that cannot do the scene.

    Warns
    -----
    ToleranceWarning
        The status is not CONVERGED.
    ModelWarning
        The scatterers are denser than those that the equation was fitted to.

    Examples
    --------
    >>> from kinetics import Scene
    >>> solution = solve(Scene(restitution=0.7, times=[0.0, 1e3, 1e6]))
    >>> bool(abs(solution.thermal_speed[0] - 2**0.5) < 1e-10)
    True
    """
    if not isinstance(scene, Scene):
        refuse("scene", scene, "it must be a Scene")
    rtol = check_rtol(_default_rtol(scene) if rtol is None else rtol)
    if method is not None:
        method = one_of("method", method, METHODS)
    if nodes is not None:
        nodes = whole_number("nodes", nodes, MIN_NODES, MAX_NODES)
    solution = Solution.of(scene, rtol, method, nodes)
    if solution.status is not SolverStatus.CONVERGED:
        warnings.warn(solution.message, ToleranceWarning, stacklevel=2)
    warning = warning_of_density(solution)
    if warning:
        warnings.warn(warning, ModelWarning, stacklevel=2)
    return solution


def _default_rtol(scene: Scene) -> float:
    """Return the relative accuracy that is asked for by default: what takes a second or so."""
    if scene.drive.only_collides:
        return DEFAULT_RTOL
    if scene.field:
        return DEFAULT_RTOL_IN_FIELD
    return DEFAULT_RTOL_OF_DRIVEN


def sweep(restitutions: ArrayLike, rtol: float | None = None, **scene: Any) -> xarray.Dataset:
    """Solve for averages over time at several restitutions.

    Parameters
    ----------
    restitutions
        e, shape (n_restitutions,).
    rtol
        Relative accuracy, as of :func:`solve`.
    scene
        The other arguments of a :class:`Scene`, with times and outputs.

    Returns
    -------
    xarray.Dataset
        Variables of the shape (n_restitutions, n_times, ...), with units; "status" and
        "error_estimate" of the shape (n_restitutions,).

    Raises
    ------
    InputError
        As :func:`solve` does; it warns as that does, too.

    Examples
    --------
    >>> speeds = sweep([0.5, 0.9], times=[0.0, 1e3], outputs="thermal_speed")
    >>> speeds.thermal_speed.dims, speeds.thermal_speed.sel(restitution=0.9).shape
    (('restitution', 'time'), (2,))
    """
    import xarray

    e = finite_line("restitutions", restitutions, low=0.0)
    if e.size == 0:
        refuse("restitutions", restitutions, "there must be one at least")
    solutions = [solve(Scene(restitution, **scene), rtol) for restitution in e.tolist()]
    axis = xarray.Variable("restitution", e, {"long_name": "coefficient of restitution"})
    datasets = [solution.to_xarray() for solution in solutions]
    swept = xarray.concat(datasets, axis, combine_attrs="drop_conflicts")
    swept["status"] = "restitution", [each.status.name.lower() for each in solutions]
    swept["error_estimate"] = "restitution", [each.error_estimate for each in solutions]
    return swept
