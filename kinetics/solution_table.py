"""What a Solution holds, as a table: its averages, and its densities at chosen points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.averaging import averages_of
from kinetics.moments.displacement import root_mean_square
from kinetics.numerics import FloatArray
from kinetics.outputs import FIELD_OUTPUTS, OUTPUTS, UNITS
from kinetics.scene import Scene
from kinetics.status import SolverStatus
from kinetics.tables import COMPONENTS, ROWS, Quantity, Table, Tabular, attributes_of
from kinetics.validation import finite_line, not_negative_line, speeds

_TYPICAL_SPEEDS = (1e-2, 5.0)  # between which densities of the speed are tabulated by default
_SCALED_RADII = np.linspace(0.0, 5.0, 101)
_SCALED_WAVE_NUMBERS = np.geomspace(1e-2, 10.0, 61)  # times the root mean square displacement
_SPEEDS, _ANGLES, _RADII = 200, 73, 121
_FARTHEST = 5.0  # of the radii, in the largest root mean square displacement
_ROWS = {**OUTPUTS, **FIELD_OUTPUTS}
_POINTS = {
    "speed_density": ("speeds",),
    "velocity_density": ("speeds", "angles"),
    "position_density": ("radii", "scaled_radii"),
    "intermediate_scattering": ("wave_numbers", "direction"),
}
_MADE_WITH = {
    "uncollided": "speed_density",
    "scaled_position_density": "position_density",
    "front_radius": "position_density",
    "front_weight": "position_density",
}


class SolutionTable(Tabular):
    """The table of a Solution.

    Points, by default where the distributions are: speeds in U, angles in radians, radii in d,
    scaled_radii, wave_numbers in 1/d and the direction of the wave in radians.
    """

    _points = tuple(dict.fromkeys(name for names in _POINTS.values() for name in names))

    scene: Scene
    rtol: float
    values: Mapping[str, FloatArray]
    status: SolverStatus
    message: str
    error_estimate: float
    _typical_speed: FloatArray

    def _table(self, only: str | None = None, **points: Any) -> Table:
        times = np.asarray(self.scene.times)
        letters = np.array(list("xyz"[: self.scene.dimension]))
        coordinates = [Quantity("time", ("time",), times, "d/U", "time since the start", "t")]
        coordinates += [Quantity(c, (c,), letters, "1", "component") for c in COMPONENTS]
        found = [_average(name, values) for name, values in self.values.items()]
        for output in self._densities(only):
            axes, more = getattr(self, f"_of_{output}")(
                *(points.get(name) for name in _POINTS[output])
            )
            there = {one.name for one in coordinates}
            coordinates += [one for one in axes if one.name not in there]
            found += more
        return Table(tuple(coordinates), tuple(found), self._attributes())

    def _densities(self, only: str | None) -> list[str]:
        """The outputs that are functions of more than the time, or the one that is needed."""
        if only == ROWS or only in self.values:
            return []
        outputs = [name for name in self.scene.outputs if name in _POINTS]
        needed = _MADE_WITH.get(only or "", only)
        return [needed] if needed in outputs else outputs

    def _attributes(self) -> dict[str, Any]:
        scene = self.scene
        return attributes_of(
            f"Solution of the inelastic Lorentz equation: {scene._system()}",
            scene,
            (self.rtol, self.error_estimate),
            status=self.status.name.lower(),
            message=self.message,
        )

    def _of_speed_density(self: Any, v: ArrayLike | None) -> Any:
        at = _speed_axis(self._speeds(v))
        values = self.speed_density(at.values)
        peak = "share of tracers of a start of one speed that have not collided (or e = 1)"
        return (at,), (
            _density("speed_density", ("time", "v"), values, self.scene),
            Quantity("uncollided", ("time",), self.uncollided, "1", peak),
        )

    def _of_velocity_density(self: Any, v: ArrayLike | None, phi: ArrayLike | None) -> Any:
        half = np.pi if self.scene.dimension == 3 else 2.0 * np.pi
        angles = np.linspace(0.0, half, _ANGLES) if phi is None else finite_line("angles", phi)
        at = _speed_axis(self._speeds(v))
        turn = Quantity("phi", ("phi",), angles, "rad", "angle of the velocity to the x axis")
        values = self.velocity_density(at.values, angles)
        return (at, turn), (_density("velocity_density", ("time", "v", "phi"), values, self.scene),)

    def _speeds(self, v: ArrayLike | None) -> FloatArray:
        if v is not None:
            return speeds(v)
        low, high = _TYPICAL_SPEEDS
        usual = self._typical_speed
        usual = usual[usual > 0.0] if np.any(usual > 0.0) else np.ones(1)  # at rest it is 0
        return np.geomspace(low * usual.min(), high * usual.max(), _SPEEDS)

    def _of_position_density(self: Any, r: ArrayLike | None, scaled: ArrayLike | None) -> Any:
        far = _FARTHEST * max(float(self._spread().max()), 1e-12)
        radii = np.linspace(0.0, far, _RADII) if r is None else not_negative_line("radii", r)
        big = _SCALED_RADII if scaled is None else not_negative_line("scaled_radii", scaled)
        g = self.position_density(radii)
        scaled_g = self.scaled_position_density(big)
        front_radius, front_weight = self.ballistic_front
        axes = [
            Quantity("r", ("r",), radii, "d", "distance from the start"),
            Quantity("R", ("R",), big, "1", "r over its root mean square"),
        ]
        found = [
            _density("position_density", ("time", "r"), g, self.scene),
            Quantity(
                "scaled_position_density", ("time", "R"), scaled_g, "1",
                "G(R) = sqrt(<r^2>) g(r, t), R = r/sqrt(<r^2>)", "G", True,
            ),
        ]  # fmt: skip
        if front_radius.shape[1]:
            numbers = np.arange(front_radius.shape[1])
            axes.append(Quantity("front", ("front",), numbers, "1", "number of a sharp speed"))
            where, share = "radius of tracers that have not collided", "share of these tracers"
            dims = ("time", "front")
            found += [
                Quantity("front_radius", dims, np.asarray(front_radius), "d", where),
                Quantity("front_weight", dims, np.asarray(front_weight), "1", share),
            ]
        return axes, found

    def _of_intermediate_scattering(self: Any, k: ArrayLike | None, direction: float | None) -> Any:
        if k is None:
            k = _SCALED_WAVE_NUMBERS / max(float(self._spread().max()), 1e-12)
        at = not_negative_line("wave_numbers", k)
        values: NDArray[Any] = self.intermediate_scattering(at, direction)
        row = OUTPUTS["intermediate_scattering"]
        wave = Quantity("k", ("k",), at, "1/d", "wave number")
        found = Quantity(row.name, ("time", "k"), values, row.unit, row.description, row.symbol)
        return (wave,), (found,)

    def _spread(self) -> FloatArray:
        """The root mean square displacement in d, (n_times,)."""
        return np.asarray(root_mean_square(averages_of(self.scene, self.rtol)))


def _average(name: str, values: FloatArray) -> Quantity:
    """An output that is an array."""
    if name in _ROWS:
        words, symbol = _ROWS[name].description, _ROWS[name].symbol
    else:  # the second array of a row
        words, symbol = next((row.description, name) for row in _ROWS.values() if name in row.names)
    symbol = {"msd_slope": "d<r^2>/d ln t"}.get(name, symbol)
    dims = ("time", *COMPONENTS[: values.ndim - 1])
    return Quantity(name, dims, np.asarray(values), UNITS[name], words, symbol)


def _density(name: str, dims: tuple[str, ...], values: FloatArray, scene: Scene) -> Quantity:
    row = OUTPUTS[name]
    unit = row.unit_in(scene.dimension)
    return Quantity(name, dims, np.asarray(values), unit, row.description, row.symbol, True)


def _speed_axis(v: FloatArray) -> Quantity:
    return Quantity("v", ("v",), v, "U", "speed")
