"""What a Scene may ask for: one table. To add an output, add one row to :data:`OUTPUTS`.

Arrays of averages are made by the functions in the table of `kinetics.moments.outputs`, which says
what they are made of. This file needs no NumPy.
"""

from __future__ import annotations

from typing import NamedTuple

AVERAGES = "averages"
INITIAL_STATE = "initial state"
VELOCITY = "moments of the velocity"
COLLISIONS = "collision number"
DISPLACEMENT = "displacement"
POSITION = "position density"
SCATTERING = "intermediate scattering"
DENSITIES = "densities"


class Output(NamedTuple):
    """One row of the table.

    name : in ``Scene.outputs``, and of the attribute or method of the Solution
    step : the step of the plan that makes it
    symbol, unit : for heads of columns; the unit is "1" for dimensionless quantities
    shape : of the array, n_times first; the arguments of the method, for those that are functions
    description : in words, with the paper's label
    also : name, unit and symbol of a second array that comes with it
    in_space : the unit in three dimensions, where that is another one
    """

    name: str
    step: str
    symbol: str
    unit: str
    shape: tuple[str, ...]
    description: str
    also: tuple[tuple[str, str, str], ...] = ()
    in_space: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its arrays."""
        return (self.name, *(name for name, _, _ in self.also))

    @property
    def is_function(self) -> bool:
        """Whether it depends on more than the time: it is a method of the Solution."""
        return any(size in AXES for size in self.shape)

    @property
    def head(self) -> str:
        """Symbol and unit, as the head of a column."""
        return self.symbol if self.unit == "1" else f"{self.symbol} [{self.unit}]"


_PER_TIME = ("n_times",)

_ROWS = (
    Output("thermal_speed", VELOCITY, "v0", "U", _PER_TIME, "sqrt(<v^2>) (paper, label v0defi)"),
    Output("temperature", VELOCITY, "T", "m U^2", _PER_TIME,
           "<v^2>/d, d the dimension (paper, label thermo)"),
    Output("a2", VELOCITY, "a2", "1", _PER_TIME,
           "<v^4>/(2 <v^2>^2) - 1 (paper, label sonine5); in space 3 <v^4>/(5 <v^2>^2) - 1"),
    Output("collisions", COLLISIONS, "collisions", "1", _PER_TIME,
           "mean number of collisions per tracer since t = 0"),
    Output("msd", DISPLACEMENT, "<r^2>", "d^2", _PER_TIME,
           "mean square displacement (paper, label msd)"),
    Output("kurtosis", DISPLACEMENT, "<r^4>/<r^2>^2", "1", _PER_TIME,
           "<r^4>/<r^2>^2: 2 for a Gaussian in the plane, 5/3 in space"),
    Output("velocity_autocorrelation", DISPLACEMENT, "<v(0).v>", "U^2", _PER_TIME,
           "<v(0).v(t)>; its error is relative to v_rms(0) v_rms(t), "
           "against which it may be small"),
    Output("diffusion_coefficient", DISPLACEMENT, "D", "d U", _PER_TIME,
           "D = (1/4) d<r^2>/dt (1/6 in space); and msd_slope = d<r^2>/d ln t, in d^2",
           also=(("msd_slope", "d^2", "d<r^2>/d ln t"),)),
    Output("mean_displacement", DISPLACEMENT, "<r>", "d", ("n_times", "d"),
           "(<x>, <y>), in space (<x>, <y>, <z>)"),
    Output("position_density", POSITION, "g", "1/d", ("n_times", "n_r"),
           "radial density g(r, t) of the displacement, and the scaled G(R) (paper, Section 3.3)",
           also=(("scaled_position_density", "1", "G"),)),
    Output("intermediate_scattering", SCATTERING, "F", "1", ("n_times", "n_k"),
           "F(k, t) = <exp(i k.r)>"),
    Output("mean_velocity", VELOCITY, "<v>", "U", ("n_times", "d"),
           "(<v_x>, <v_y>), in space (<v_x>, <v_y>, <v_z>)"),
    Output("velocity_tensor", VELOCITY, "<v v>", "U^2", ("n_times", "d", "d"), "<v_i v_j>"),
    Output("speed_density", DENSITIES, "f", "1/U", ("n_times", "n_v"),
           "density of the speed, its integral over v is 1"),
    Output("velocity_density", DENSITIES, "f", "1/U^2", ("n_times", "n_v", "n_phi"),
           "f(v, phi) from its angular harmonics; in space phi is the angle to the x axis",
           in_space="1/U^3"),
    Output("displacement_tensor", DISPLACEMENT, "cov(r)", "d^2", ("n_times", "d", "d"),
           "<(r_i - <r_i>)(r_j - <r_j>)>, with a field only"),
)  # fmt: skip

_FREE_ONLY = {
    "kurtosis", "velocity_autocorrelation", "position_density", "intermediate_scattering"
}  # fmt: skip

_TABLE = {row.name: row for row in _ROWS}

OUTPUTS = {name: row for name, row in _TABLE.items() if name != "displacement_tensor"}
"""Name -> row, in the order in which outputs are listed."""

DRIVEN_OUTPUTS = {name: row for name, row in _TABLE.items() if name not in _FREE_ONLY}
"""Name -> row for scenes with driven tracers, which `kinetics.driven` solves."""

FIELD_OUTPUTS = {n: row for n, row in DRIVEN_OUTPUTS.items() if n != "diffusion_coefficient"}
"""Name -> row for scenes with a field, which `kinetics.driven` solves."""


class Axis(NamedTuple):
    """What an output that is a function depends on: `Output.shape` names it."""

    name: str
    unit: str
    description: str
    points: str  # the name under which points are given to `Solution.to_xarray`


AXES: dict[str, Axis] = {
    "n_v": Axis("v", "U", "speed", "speeds"),
    "n_phi": Axis("phi", "rad", "angle of the velocity to the x axis", "angles"),
    "n_r": Axis("r", "d", "distance from the start", "radii"),
    "n_R": Axis("R", "1", "r over its root mean square", "scaled_radii"),
    "n_k": Axis("k", "1/d", "wave number", "wave_numbers"),
}


def described(name: str, dimension: int) -> tuple[str, str, str]:
    """Unit, words and symbol of an array of a Solution, or of a function."""
    row = next(row for row in (FIELD_OUTPUTS | OUTPUTS).values() if name in row.names)
    also = {also: (unit, row.description, symbol) for also, unit, symbol in row.also}
    unit = row.in_space if dimension == 3 and row.in_space else row.unit
    return also.get(name, (unit, row.description, row.symbol))
