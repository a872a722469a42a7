"""What is asked: the system, its initial state, the times and the outputs. No numerics."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, check_positive, check_restitution, short
from kinetics.states.isotropic import as_state
from kinetics.states.state import State

FloatArray = NDArray[np.float64]

OUTPUTS = {
    "thermal_speed": "sqrt(<v^2>), in U (paper, label v0defi)",
    "temperature": "<v^2>/2, in m U^2 (paper, label thermo)",
    "a2": "<v^4>/(2 <v^2>^2) - 1 (paper, label sonine5)",
    "collisions": "mean number of collisions per tracer since t = 0",
    "msd": "<r^2>, in d^2",
    "kurtosis": "<r^4>/<r^2>^2: 2 for a Gaussian in the plane",
    "velocity_autocorrelation": "<v(0).v(t)>, in U^2",
    "diffusion_coefficient": "D = (1/4) d<r^2>/dt, in d U; and msd_slope = d<r^2>/d ln t, in d^2",
    "mean_displacement": "(<x>, <y>), in d, shape (n_times, 2)",
    "position_density": "radial density g(r, t) of the displacement, and the scaled G(R)",
    "intermediate_scattering": "F(k, t) = <exp(i k.r)>",
    "mean_velocity": "(<v_x>, <v_y>), in U, shape (n_times, 2)",
    "velocity_tensor": "<v_i v_j>, in U^2, shape (n_times, 2, 2)",
    "speed_density": "density of the speed, normalised over v",
    "velocity_density": "f(v, phi) in the velocity plane, from its angular harmonics",
}


@dataclass(frozen=True)
class Scene:
    """One question to the solver.

    Parameters
    ----------
    restitution : e in [0, 1]
    number_density : rho_0, scatterers per d^2; the mean free path is 1/(2 diameter rho_0)
    diameter : of tracer and scatterers, in d
    initial : "gaussian" (each component of the velocity has standard deviation U),
        "monoenergetic" (all speeds are U), a speed density as a function of v/U, or a state:
        SpeedTable, SpeedSamples, Gaussian, Beam, VelocitySamples, AngularHarmonics, PolarGrid
    times : in d/U, shape (n_times,), not falling, not negative
    outputs : names from OUTPUTS
    harmonics : highest angular harmonic m that "velocity_density" solves, if the state has it

    Raises
    ------
    InputError (a ValueError) : one line that names the argument, its value and what is allowed
    """

    restitution: float
    number_density: float = 0.04
    diameter: float = 1.0
    initial: Any = "gaussian"
    times: ArrayLike = ()
    outputs: tuple[str, ...] = ("thermal_speed",)
    harmonics: int = 8
    state: State = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "restitution", check_restitution(self.restitution))
        set_(self, "number_density", check_positive("number_density", self.number_density))
        set_(self, "diameter", check_positive("diameter", self.diameter))
        area = 2.0 * self.diameter * self.number_density
        if not (0.0 < area < math.inf and 1.0 / area < math.inf):
            raise InputError(
                f"number_density: got {short(self.number_density)} at diameter "
                f"{short(self.diameter)}; the mean free path 1/(2 diameter number_density) must be "
                "a finite number above 0"
            )
        set_(self, "state", as_state(self.initial))
        set_(self, "times", _check_times(self.times))
        set_(self, "outputs", _check_outputs(self.outputs))
        if isinstance(self.harmonics, bool) or not 0 <= _whole(self.harmonics) <= 256:
            raise InputError(
                f"harmonics: got {short(self.harmonics)}; it must be a whole number from 0 to 256"
            )

    @property
    def mean_free_path(self) -> float:
        """l = 1/(2 d rho_0), in d."""
        return 1.0 / (2.0 * self.diameter * self.number_density)


def _whole(value: Any) -> int:
    return int(value) if isinstance(value, int | np.integer) else -1


def _check_times(times: Any) -> FloatArray:
    allowed = "times must be real, finite, not negative and not falling, at least one"
    try:
        array = np.atleast_1d(np.asarray(times))
        if array.dtype.kind == "c":
            raise TypeError
        array = array.astype(float)
    except (TypeError, ValueError):
        raise InputError(f"times: got {short(times)}; {allowed}") from None
    if array.ndim != 1 or array.size == 0 or not np.all(np.isfinite(array)):
        raise InputError(f"times: got {short(times)}; {allowed}")
    if array[0] < 0.0 or np.any(np.diff(array) < 0.0):
        raise InputError(f"times: got {short(times)}; {allowed}")
    array.flags.writeable = False
    return array


def _check_outputs(outputs: Any) -> tuple[str, ...]:
    if isinstance(outputs, str) or not isinstance(outputs, Iterable):
        outputs = (outputs,)
    names = tuple(dict.fromkeys(outputs))
    if not names:
        raise InputError(f"outputs: got {short(outputs)}; name at least one of {_known()}")
    for name in names:
        if name not in OUTPUTS:
            near = difflib.get_close_matches(str(name), OUTPUTS, n=1)
            hint = f"did you mean {near[0]!r}? " if near else ""
            raise InputError(f"outputs: got {name!r}; {hint}known are {_known()}")
    return names


def _known() -> str:
    return ", ".join(OUTPUTS)
