"""Base classes: a `Storable` value can be saved, a `Result` also becomes a dataset or a plot."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any, Self

from numpy.typing import NDArray

from kinetics.errors import InputError, short, suggestion
from kinetics.results.file import write_value
from kinetics.results.frame import MODEL_ERROR, averages_frame, dataset, quantity_frame
from kinetics.results.plot import DENSITY_BOTTOM, draw, draw_all
from kinetics.results.record import initial_fields
from kinetics.results.table import Table, html_of
from kinetics.results.value import Value, fields_shown

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes


class Storable(Value):
    """A value that can be saved; its class is registered with `record.stored_class`."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write this to a netCDF-4 file, whole or not at all; :func:`kinetics.load` reads it back.

        Raises
        ------
        InputError
            The file cannot be written; or this holds what a file cannot: a Python function, or an
            object of a class that is not of this package.
        """
        write_value(path, self, self._dataset(only=()))

    def _table(self) -> Table:
        """Return what a notebook shows."""
        return Table(type(self).__name__, ("argument", "value"), list(fields_shown(self).items()))

    def _repr_html_(self) -> str:
        return html_of(self._table())

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> xarray.Dataset:
        """Return what a file shows to other programs beside the record."""
        return dataset(self, type(self).__name__, self, {}, {})

    def _to_storage(self) -> dict[str, object]:
        """Return the parts of which `_from_storage` builds the value again."""
        return initial_fields(self)

    @classmethod
    def _from_storage(cls, parts: dict[str, Any]) -> Self:
        """Build the value of the parts that `_to_storage` gave; sequences are tuples there."""
        return cls(**parts)


class Result(Storable):
    """A value that becomes an `xarray.Dataset`, a data frame or a plot where one asks for it.

    A subclass writes ``_dataset(only, **points)`` with :func:`kinetics.results.frame.dataset`: all
    of it, or what ``only`` names, and always what depends on the first coordinate alone, and single
    numbers.

    Attributes
    ----------
    _points : the names of points at which functions can be evaluated
    _on_demand : the names of functions that ``_dataset`` makes only where they are asked for
    """

    _points: tuple[str, ...] = ()
    _on_demand: tuple[str, ...] = ()

    def to_xarray(self, **points: Any) -> xarray.Dataset:
        """Return an xarray Dataset of everything; its attributes say units, status and accuracy.

        Parameters
        ----------
        points
            Where functions are evaluated: for a Solution speeds, angles, radii, scaled_radii,
            wave_numbers and direction.

        Returns
        -------
        xarray.Dataset
            Complex quantities are split into ``_real`` and ``_imag``, so that ``to_netcdf`` takes
            them.

        Raises
        ------
        InputError
            Points that this result does not know.
        """
        return self._checked_dataset(None, points)

    def to_dataframe(self, name: str | None = None, **points: Any) -> pandas.DataFrame:
        """Return a pandas DataFrame: one row for each time (or other first coordinate).

        Parameters
        ----------
        name
            A quantity that depends on more, such as "speed_density": then there is one row for
            each point. By default all averages are columns.
        points
            Where functions are evaluated, as of :meth:`to_xarray`.

        Returns
        -------
        pandas.DataFrame
            Units, and the attributes of the result, are in ``frame.attrs``.

        Raises
        ------
        InputError
            An unknown name.
        """
        if name is None:
            return averages_frame(self._checked_dataset((), points))
        return quantity_frame(self._quantity(name, points))

    def plot(self, name: str | None = None, ax: Axes | None = None, **points: Any) -> Any:
        """Draw one quantity on ``ax``, or on new axes; without a name, everything.

        Averages are drawn over time, densities at up to eight of the times. The title says which
        system it is, the legend "equation". A run of `particles` draws the same quantity on the
        same kind of axes: ``run.plot("msd", ax=solution.plot("msd"))``. A band is the
        error of the equation itself, where it is stated.

        Parameters
        ----------
        name
            Of the quantity.
        ax
            Axes of matplotlib.
        points
            Where functions are evaluated, as of :meth:`to_xarray`.

        Returns
        -------
        matplotlib.axes.Axes
            Or an array of them, without a name.

        Raises
        ------
        InputError
            An unknown name.
        """
        if name is not None:
            self._require_text(name)
            points = self._points_of_plot(name, points)
            quantities = self._named_dataset(name, points)
            components = self._components(quantities, name)
            error = quantities.get(name + MODEL_ERROR)
            return draw(name, components, ax, self._system, self._density_bottom, error)
        if ax is not None:
            raise InputError("ax: got axes without a name; name what to draw on them")
        return self.plot_all(**points)

    def plot_all(self, **points: Any) -> NDArray[Any]:
        """Draw each quantity in axes of its own in one new figure; returns an array of axes."""
        points = self._points_of_plot(None, points)
        quantities = self._checked_dataset(None, points).data_vars
        return draw_all(quantities.values(), self._system, self._density_bottom)

    def _near(self, name: str, names: list[str]) -> str:
        """Return the end of a message on a name that this result does not have."""
        return suggestion(name, names)

    @property
    def _system(self) -> tuple[str, ...]:
        """What the title of a figure says: restitution, density and scatterers."""
        return ()

    @property
    def _density_bottom(self) -> float:
        """The least density in a figure, over the largest: below it there are but errors."""
        return DENSITY_BOTTOM

    def _points_of_plot(self, name: str | None, points: Mapping[str, Any]) -> dict[str, Any]:
        """Return the points at which a function of this name, or of any, is drawn."""
        return dict(points)

    def _checked_dataset(
        self, only: Collection[str] | None, points: Mapping[str, object]
    ) -> xarray.Dataset:
        """Return the dataset; InputError for points that this result does not know."""
        for name in points:
            if name not in self._points:
                allowed = ", ".join(("name", "ax", *self._points))
                raise InputError(f"{name}: known are {allowed}")
        return self._dataset(only=only, **points)

    def _named_dataset(self, name: str, points: Mapping[str, object]) -> xarray.Dataset:
        """Return the dataset of one quantity, and of its model error if it has one."""
        self._require_text(name)
        return self._checked_dataset((name,), points)

    @staticmethod
    def _require_text(name: object) -> None:
        """Raise InputError for a name that is no text."""
        if not isinstance(name, str):
            raise InputError(f"name: got {short(name)}; it must be the name of a quantity")

    def _quantity(self, name: str, points: Mapping[str, object]) -> list[xarray.DataArray]:
        """Return the quantity of a name, as its real and imaginary part if it is complex."""
        return self._components(self._named_dataset(name, points), name)

    def _components(self, quantities: xarray.Dataset, name: str) -> list[xarray.DataArray]:
        """Return the quantity of a name, as its real and imaginary part if it is complex."""
        labels = (name, f"{name}_real", f"{name}_imag")
        components = [quantities[label] for label in quantities if label in labels]
        if not components:
            names = [*map(str, quantities), *self._on_demand]
            allowed = ", ".join(dict.fromkeys(names))
            similar = self._near(name, names)
            raise InputError(f"name: got {short(name)}; this result has {allowed}{similar}")
        return components
