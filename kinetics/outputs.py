"""What a Scene may ask for: one table. To add an output, add a row to `ALL_OUTPUTS`.

An average needs a row in the table of `kinetics.moments.outputs` too, with the function that makes
it and what it is made of. This file needs no NumPy.
"""

from __future__ import annotations

from dataclasses import dataclass

# Parts of a result, as the plan, error estimates and messages name them.
AVERAGES = "averages"
INITIAL_STATE = "initial state"
VELOCITY = "moments of the velocity"
COLLISIONS = "collision number"
DISPLACEMENT = "displacement"
POSITION = "position density"
SCATTERING = "intermediate scattering"
DENSITIES = "densities"


@dataclass(frozen=True)
class Axis:
    """What an output that is a function depends on: `Output.shape` names it.

    Parameters
    ----------
    name, unit, description : of the coordinate of a dataset
    points : the name under which points are given to `Solution.to_xarray`
    """

    name: str
    unit: str
    description: str
    points: str


#: The axes, by the names of their lengths in a shape.
AXES: dict[str, Axis] = {
    "n_v": Axis("v", "U", "speed", "speeds"),
    "n_phi": Axis("phi", "rad", "angle of the velocity to the x axis", "angles"),
    "n_r": Axis("r", "d", "distance from the start", "radii"),
    "n_R": Axis("R", "1", "r over its root mean square", "scaled_radii"),
    "n_k": Axis("k", "1/d", "wave number", "wave_numbers"),
}


@dataclass(frozen=True)
class Companion:
    """A second array that comes with an output."""

    name: str
    symbol: str
    unit: str


@dataclass(frozen=True, kw_only=True)
class Output:
    """One row of the table.

    Parameters
    ----------
    name : in ``Scene.outputs``, and of the attribute or method of the Solution
    step : the part of the result that it belongs to
    symbol, unit : for heads of columns; the unit is "1" for dimensionless quantities
    unit_in_space : the unit in three dimensions, where that is another one
    shape : of the array, n_times first; the arguments of the method, for those that are functions
    description : in words, with the paper's label
    companion : a second array that comes with it
    without_drive, with_field, with_drive : whether it is there for tracers that only collide, that
        a field alone moves, and that anything else drives
    """

    name: str
    step: str
    symbol: str
    unit: str
    unit_in_space: str = ""
    shape: tuple[str, ...] = ("n_times",)
    description: str
    companion: Companion | None = None
    without_drive: bool = True
    with_field: bool = True
    with_drive: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its arrays."""
        if self.companion is None:
            return (self.name,)
        return (self.name, self.companion.name)

    @property
    def is_function(self) -> bool:
        """Whether it depends on more than the time: it is a method of the Solution."""
        return any(length in AXES for length in self.shape)

    @property
    def head(self) -> str:
        """Symbol and unit, as the head of a column."""
        return self.symbol if self.unit == "1" else f"{self.symbol} [{self.unit}]"


ALL_OUTPUTS = (
    Output(
        name="thermal_speed",
        step=VELOCITY,
        symbol="v0",
        unit="U",
        description="sqrt(<v^2>) (paper, label v0defi)",
    ),
    Output(
        name="temperature",
        step=VELOCITY,
        symbol="T",
        unit="m U^2",
        description="<v^2>/d, d the dimension (paper, label thermo)",
    ),
    Output(
        name="a2",
        step=VELOCITY,
        symbol="a2",
        unit="1",
        description="<v^4>/(2 <v^2>^2) - 1 (paper, label sonine5); "
        "in space 3 <v^4>/(5 <v^2>^2) - 1",
    ),
    Output(
        name="collisions",
        step=COLLISIONS,
        symbol="collisions",
        unit="1",
        description="mean number of collisions per tracer since t = 0",
    ),
    Output(
        name="msd",
        step=DISPLACEMENT,
        symbol="<r^2>",
        unit="d^2",
        description="mean square displacement (paper, label msd)",
    ),
    Output(
        name="kurtosis",
        step=DISPLACEMENT,
        symbol="<r^4>/<r^2>^2",
        unit="1",
        description="<r^4>/<r^2>^2: 2 for a Gaussian in the plane, 5/3 in space",
        with_field=False,
        with_drive=False,
    ),
    Output(
        name="velocity_autocorrelation",
        step=DISPLACEMENT,
        symbol="<v(0).v>",
        unit="U^2",
        description="<v(0).v(t)>; its error is relative to v_rms(0) v_rms(t), "
        "against which it may be small",
        with_field=False,
        with_drive=False,
    ),
    Output(
        name="diffusion_coefficient",
        step=DISPLACEMENT,
        symbol="D",
        unit="d U",
        description="D = (1/4) d<r^2>/dt (1/6 in space); and msd_slope = d<r^2>/d ln t, in d^2",
        companion=Companion("msd_slope", "d<r^2>/d ln t", "d^2"),
        with_field=False,
    ),
    Output(
        name="mean_displacement",
        step=DISPLACEMENT,
        symbol="<r>",
        unit="d",
        shape=("n_times", "d"),
        description="(<x>, <y>), in space (<x>, <y>, <z>)",
    ),
    Output(
        name="position_density",
        step=POSITION,
        symbol="g",
        unit="1/d",
        shape=("n_times", "n_r"),
        description="radial density g(r, t) of the displacement, and the scaled G(R) "
        "(paper, Section 3.3)",
        companion=Companion("scaled_position_density", "G", "1"),
        with_field=False,
        with_drive=False,
    ),
    Output(
        name="intermediate_scattering",
        step=SCATTERING,
        symbol="F",
        unit="1",
        shape=("n_times", "n_k"),
        description="F(k, t) = <exp(i k.r)>",
        with_field=False,
        with_drive=False,
    ),
    Output(
        name="mean_velocity",
        step=VELOCITY,
        symbol="<v>",
        unit="U",
        shape=("n_times", "d"),
        description="(<v_x>, <v_y>), in space (<v_x>, <v_y>, <v_z>)",
    ),
    Output(
        name="velocity_tensor",
        step=VELOCITY,
        symbol="<v v>",
        unit="U^2",
        shape=("n_times", "d", "d"),
        description="<v_i v_j>",
    ),
    Output(
        name="speed_density",
        step=DENSITIES,
        symbol="f",
        unit="1/U",
        shape=("n_times", "n_v"),
        description="density of the speed, its integral over v is 1",
    ),
    Output(
        name="velocity_density",
        step=DENSITIES,
        symbol="f",
        unit="1/U^2",
        unit_in_space="1/U^3",
        shape=("n_times", "n_v", "n_phi"),
        description="f(v, phi) from its angular harmonics; in space phi is the angle to the x axis",
    ),
    Output(
        name="displacement_tensor",
        step=DISPLACEMENT,
        symbol="cov(r)",
        unit="d^2",
        shape=("n_times", "d", "d"),
        description="<(r_i - <r_i>)(r_j - <r_j>)>, with a field only",
        without_drive=False,
    ),
)

#: What people call outputs, and their names here.
ALIASES = {
    "mean_square_displacement": "msd",
    "mean_squared_displacement": "msd",
    "v0": "thermal_speed",
    "thermal_velocity": "thermal_speed",
    "sonine": "a2",
    "d": "diffusion_coefficient",
    "diffusion": "diffusion_coefficient",
    "vacf": "velocity_autocorrelation",
    "g": "position_density",
    "van_hove": "position_density",
    "scaled_position_density": "position_density",
    "f": "speed_density",
    "vdf": "velocity_density",
    "drift": "mean_velocity",
}

#: Outputs of tracers that only collide, by name, in the order in which they are listed.
OUTPUTS = {output.name: output for output in ALL_OUTPUTS if output.without_drive}
#: Outputs of tracers that a field alone moves, by name.
FIELD_OUTPUTS = {output.name: output for output in ALL_OUTPUTS if output.with_field}
#: Outputs of tracers that anything else drives, by name.
DRIVEN_OUTPUTS = {output.name: output for output in ALL_OUTPUTS if output.with_drive}


def described(name: str, dimension: int) -> tuple[str, str, str]:
    """Return unit, description and symbol of an array of a Solution, or of a function."""
    output = next(output for output in ALL_OUTPUTS if name in output.names)
    if output.companion is not None and name == output.companion.name:
        return output.companion.unit, output.description, output.companion.symbol
    unit = output.unit
    if dimension == 3 and output.unit_in_space:
        unit = output.unit_in_space
    return unit, output.description, output.symbol
