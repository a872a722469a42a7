"""What the closed form and the solver of the scaled distribution share.

The collision law of the arguments, the checks of a power of the speed, and the dataset. Begin with
:class:`kinetics.scaling.closed_form.ScalingSolution`, which is such a state.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw, law_in_medium, law_of
from kinetics.collision.medium import word_for_scatterers
from kinetics.numerics import LARGEST_LOG, ROUNDING, FloatArray
from kinetics.results.frame import Variable, dataset, variable
from kinetics.results.labels import system_items
from kinetics.results.plot import axes_of_figure
from kinetics.results.result import Result
from kinetics.results.table import Table, wrapped
from kinetics.results.value import fields_shown
from kinetics.scaling.scaled_figure import draw_moments, draw_vdf, tail_of
from kinetics.validation import finite_line, real_number, refuse

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

#: Largest |p| of a moment <c^p>. Chosen: near it moments leave the range of doubles for small e.
MAX_POWER = 300.0

#: Units of the numbers that a notebook shows.
UNITS_OF_FIGURES = {"h": "1", "a2": "1", "d<r^2>/dln(t)": "l^2"}
#: Powers p of the moments in a dataset. Chosen: the lowest six.
TABULATED_POWERS = np.arange(1.0, 7.0)
#: Largest scaled speed in a dataset, unless speeds are given. Chosen: F is below 1e-3 beyond.
MAX_TABULATED_SPEED = 4.0
#: Speeds in a dataset. Chosen: steps of 0.02.
N_TABULATED_SPEEDS = 200


@dataclass(frozen=True, eq=False, repr=False)
class ScaledState(Result, ABC):
    """The self-similar cooling state of one collision law, of which a subclass knows F(c).

    The arguments are those of :class:`kinetics.ScalingSolution`. After construction they are as
    the law has them: a law given as ``restitution`` fills in the others.
    """

    restitution: float | CollisionLaw
    tangential_restitution: float | None = 1.0
    dimension: int = 2
    scatterers: str = "dilute"
    number_density: float | None = None
    diameter: float = 1.0
    density_order: str = "second"
    mass_ratio: float = math.inf

    _points = ("c",)
    _on_demand = ("moment", "vdf")
    _attributes: ClassVar[Mapping[str, str]] = MappingProxyType({})  # of the dataset

    def __post_init__(self) -> None:
        self.store(**self.law.arguments, scatterers=word_for_scatterers(self.scatterers))

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law of these restitutions, in this dimension and medium."""
        law = law_of(self.restitution, self.tangential_restitution, self.dimension, self.mass_ratio)
        return law_in_medium(
            law, self.scatterers, self.number_density, self.diameter, self.density_order
        )

    @property
    @abstractmethod
    def cooling_rate(self) -> float:
        """h(e), from v0 = 2 l/(h t) in the scaling state (paper, label ``compare2``)."""

    @property
    @abstractmethod
    def a2(self) -> float:
        """<c^4> d/(d+2) - 1 (paper, label ``sonine5``)."""

    @abstractmethod
    def moment(self, p: float) -> float:
        """<c^p>."""

    @abstractmethod
    def _tabulated_vdf(self, c: FloatArray) -> FloatArray:
        """Return F(c) for a dataset, shape of c."""

    @property
    def _system(self) -> tuple[str, ...]:
        """What the title of a figure says."""
        names = ("restitution", "tangential_restitution", "mass_ratio")
        arguments = {name: getattr(self, name) for name in names}
        if self.number_density is not None:
            arguments["number_density"] = self.number_density * math.prod(
                [self.diameter] * self.dimension
            )
        return system_items(arguments, self.scatterers, self.dimension)

    def _checked_power(self, p: float) -> float:
        """Return the power p of a moment; InputError where this law has no such moment."""
        power = real_number("p", p, -MAX_POWER, MAX_POWER)
        if power <= self.law.lowest_power:
            refuse("p", p, f"moments of this law exist for p > {self.law.lowest_power:g} only")
        return power

    def _moment_from_log(self, p: float, log_moment: float) -> float:
        """Return <c^p> from its logarithm; InputError where it overflows."""
        if log_moment > LARGEST_LOG:
            refuse("p", p, "<c^p> overflows double precision there")
        return math.exp(log_moment)

    def _speeds_from_rest(self, c: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the speeds, shape (n,), at which to evaluate F, and an array of F(0) to fill.

        Where bounces come as near to rest as one likes, F ~ c^(q - d), with -q the lowest power of
        the law: it is infinite at rest, or (q = d) finite there and evaluated at a speed close by.
        Elsewhere F(0) is 0.
        """
        if not self.law.reaches_rest:
            return c, np.zeros(c.shape)
        power = -self.law.lowest_power - self.law.dimension
        if power == 0.0:
            c = np.where(c == 0.0, ROUNDING, c)  # F changes by a relative amount of that order
        density_at_rest = math.inf if power < 0.0 else 0.0
        return c, np.full(c.shape, density_at_rest)

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> xarray.Dataset:
        """Return h, a2, moments and, unless bounces are elastic, F(c)."""
        speeds = np.linspace(0.0, MAX_TABULATED_SPEED, N_TABULATED_SPEEDS + 1)[1:]
        if points.get("c") is not None:
            speeds = finite_line("c", points["c"], "speeds must be finite, and not negative", 0.0)
        variables = {
            "cooling_rate": variable((), self.cooling_rate, "1", "h(e), from v0 = 2 l/(h t)", "h"),
            "a2": variable((), self.a2, "1", "<c^4> d/(d+2) - 1", "a2"),
        }
        if only is None or "moment" in only:
            variables["moment"] = self._moments_variable()
        is_vdf_requested = not only or "vdf" in only
        if is_vdf_requested and self.cooling_rate > 0.0:
            variables["vdf"] = self._vdf_variable(speeds)
        coordinates = {
            "c": variable(("c",), speeds, "1", "speed over the thermal speed"),
            "p": variable(("p",), TABULATED_POWERS, "1", "power of the speed"),
        }
        title = f"Scaled velocity distribution: {self.law.described}"
        return dataset(self, title, self, variables, coordinates, **self._attributes)

    def plot(self, name: str | None = None, ax: Axes | None = None, **points: Any) -> Any:
        """Draw F(c) or moments on ``ax``, or on new axes; without a name, both.

        "vdf" is F(c) on a logarithmic ordinate, with the Gaussian of the same <c^2> and with its
        own exponential tail; "moment" is <c^p> at a few powers, as points.

        Parameters
        ----------
        name
            "vdf" or "moment".
        ax
            Axes of matplotlib.
        points
            ``c``, the scaled speeds at which F is drawn.

        Returns
        -------
        matplotlib.axes.Axes
            Or an array of them, without a name; of elastic tracers, which have no F(c), one.

        Raises
        ------
        InputError
            An unknown name.
        """
        if name is None:
            return super().plot(None, ax, **points)
        return self._draw(name, ax, self._system, points)

    def plot_all(self, **points: Any) -> NDArray[Any]:
        """Draw F(c) and the moments, each in axes of its own; returns an array of axes."""
        names = ["vdf", "moment"] if self.cooling_rate > 0.0 else ["moment"]
        axes = axes_of_figure(len(names), self._system)
        for name, ax in zip(names, axes, strict=True):
            self._draw(name, ax, (), points)
        return np.array(axes)

    def _draw(
        self, name: str, ax: Axes | None, system: tuple[str, ...], points: Mapping[str, Any]
    ) -> Axes:
        """Draw one of `_on_demand` on axes; InputError for another name."""
        values = self._quantity(name, points)[0]
        if name == "moment":
            return draw_moments(values["p"].values, values.values, self.dimension, ax, system)
        if name != "vdf":
            refuse("name", name, "it is one number; plot draws 'vdf' and 'moment'")
        tail = tail_of(self._tabulated_vdf, self.cooling_rate, self._tail_power)
        speeds = values["c"].values
        shows_all = "c" in points
        return draw_vdf(speeds, values.values, tail, self.dimension, ax, system, shows_all)

    @property
    def _tail_power(self) -> float:
        """The power of c before the exponential tail; NaN where the tail is another one."""
        return self.law.tail_exponent - self.dimension

    def _moments_variable(self) -> Variable:
        """Return <c^p> at the tabulated powers."""
        moments = [self.moment(float(p)) for p in TABULATED_POWERS]
        description = "<c^p>, c the speed over the thermal speed"
        return variable(("p",), moments, "1", description, "<c^p>")

    def _vdf_variable(self, speeds: FloatArray) -> Variable:
        """Return F at these scaled speeds."""
        description = (
            f"scaled velocity distribution F(c), of integral 1 in {self.dimension} dimensions"
        )
        return variable(("c",), self._tabulated_vdf(speeds), "1", description, "F")

    def _figures(self) -> dict[str, str]:
        """Return the numbers that a repr and a notebook show, as text."""
        return {"h": f"{self.cooling_rate:.12g}", "a2": f"{self.a2:.12g}"}

    @property
    def _accuracy(self) -> str:
        """The status and the error, in words."""
        return "closed form, exact to rounding"

    def _table(self) -> Table:
        """Return what a notebook shows: h, a2 and how well they are known."""
        rows = [(name, text, UNITS_OF_FIGURES[name]) for name, text in self._figures().items()]
        title = f"{type(self).__name__}: {', '.join(self._system)}"
        return Table(title, ("", "value", "unit"), rows, [self._accuracy])

    def __repr__(self) -> str:
        figures = ", ".join(f"{name} = {text}" for name, text in self._figures().items())
        arguments = self._arguments_shown
        return wrapped(f"{type(self).__name__}({arguments}): {figures}, {self._accuracy}")

    @property
    def _arguments_shown(self) -> str:
        """The arguments that are not as by default."""
        return ", ".join(f"{name}={text}" for name, text in fields_shown(self).items())
