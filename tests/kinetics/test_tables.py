"""Plots, data frames and datasets of results: names, units, numbers, attributes."""

import io
import json
import sys
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from kinetics import Beam, InputError, ScalingSolution, Scene, solve, solve_field, solve_scaled
from kinetics.outputs import OUTPUTS
from kinetics.tables import printed

AVERAGES = tuple(row.name for row in OUTPUTS.values() if row.values is not None)
TIMES = [1.0, 30.0, 1e3]


@pytest.fixture(scope="module")
def averages() -> Any:
    return solve(Scene(0.7, initial=Beam(), times=TIMES, outputs=AVERAGES))


@pytest.fixture(scope="module")
def densities() -> Any:
    outputs = ("speed_density", "position_density", "intermediate_scattering", "velocity_density")
    return solve(Scene(0.7, times=[30.0, 300.0], outputs=outputs, harmonics=0), 1e-4)


RESULTS = {
    "scaled": lambda: solve_scaled(0.7),
    "closed form": lambda: ScalingSolution(0.7, dimension=3),
    "in a field": lambda: solve_field(0.7, rtol=1e-6),
    "over time in a field": lambda: solve(
        Scene(0.7, field=0.1, initial="rest", times=[1.0, 5.0], outputs="mean_velocity"), 1e-3
    ),
}


def test_a_dataset_says_what_was_asked_and_reached(averages: Any) -> None:
    pytest.importorskip("xarray")
    found = averages.to_xarray()
    for name, values in averages.values.items():
        np.testing.assert_array_equal(found[name], values)
        assert found[name].attrs["units"]
        assert found[name].attrs["long_name"]
    assert found.msd.attrs["units"] == "d^2"
    assert found.velocity_tensor.dims == ("time", "component", "component2")
    assert found.velocity_tensor.sel(component="x", component2="x")[0] == pytest.approx(
        averages.velocity_tensor[0, 0, 0]
    )
    assert found.attrs["status"] == "converged"
    assert found.attrs["tolerance_asked"] == averages.rtol
    assert found.attrs["tolerance_reached"] == averages.error_estimate
    scene = json.loads(found.attrs["scene"])
    assert scene["restitution"] == 0.7
    assert scene["initial"]["class"] == "Beam"
    assert scene["times"] == TIMES


def test_densities_are_at_the_points_that_are_asked_for(densities: Any) -> None:
    pytest.importorskip("xarray")
    v, r, big, k = [0.1, 0.2], [1.0, 5.0, 9.0], [0.5, 1.0], [0.01]
    found = densities.to_xarray(speeds=v, radii=r, scaled_radii=big, wave_numbers=k, angles=[0.0])
    np.testing.assert_array_equal(found.speed_density, densities.speed_density(v))
    np.testing.assert_array_equal(found.position_density, densities.position_density(r))
    np.testing.assert_array_equal(
        found.scaled_position_density, densities.scaled_position_density(big)
    )
    np.testing.assert_array_equal(found.velocity_density, densities.velocity_density(v, [0.0]))
    f = densities.intermediate_scattering(k)
    np.testing.assert_array_equal(found.intermediate_scattering, f)


def test_a_complex_quantity_is_split_into_its_parts() -> None:
    pytest.importorskip("xarray")
    solution = solve(Scene(0.7, initial=Beam(), times=TIMES, outputs="intermediate_scattering"))
    found = solution.to_xarray(wave_numbers=[0.01], direction=0.5)
    f = solution.intermediate_scattering([0.01], 0.5)
    np.testing.assert_array_equal(found.intermediate_scattering_real, f.real)
    np.testing.assert_array_equal(found.intermediate_scattering_imag, f.imag)


def test_a_dataset_goes_through_a_netcdf_file(averages: Any) -> None:
    xarray = pytest.importorskip("xarray")
    found = averages.to_xarray()
    written = io.BytesIO(bytes(found.to_netcdf(engine="scipy")))
    assert xarray.open_dataset(written, engine="scipy").identical(found)


def test_a_data_frame_has_a_row_for_each_time(averages: Any) -> None:
    pytest.importorskip("pandas")
    frame = averages.to_dataframe()
    assert frame.time.tolist() == TIMES
    assert frame.msd.tolist() == averages.msd.tolist()
    assert frame.mean_velocity_x.tolist() == averages.mean_velocity[:, 0].tolist()
    assert frame.velocity_tensor_yy.tolist() == averages.velocity_tensor[:, 1, 1].tolist()
    assert frame.attrs["units"]["thermal_speed"] == "U"


def test_a_data_frame_of_a_density_has_a_row_for_each_point(densities: Any) -> None:
    pytest.importorskip("pandas")
    frame = densities.to_dataframe("speed_density", speeds=[0.1, 0.2])
    assert list(frame.columns) == ["time", "v", "speed_density"]
    assert frame.time.tolist() == [30.0, 30.0, 300.0, 300.0]
    assert frame.speed_density.tolist() == densities.speed_density([0.1, 0.2]).ravel().tolist()


@pytest.mark.parametrize("name", AVERAGES)
def test_an_average_is_drawn_over_time_with_its_unit(averages: Any, name: str) -> None:
    axes = Figure().subplots()
    assert averages.plot(name, ax=axes) is axes
    assert axes.get_xlabel() == "t [d/U]"
    assert len(axes.lines) == averages.values[name][0].size
    np.testing.assert_array_equal(
        axes.lines[0].get_ydata(), averages.values[name].reshape(3, -1)[:, 0]
    )
    assert ("[" in axes.get_ylabel()) == (OUTPUTS[name].unit != "1")


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("speed_density", "v [U]"),
        ("scaled_position_density", "R"),
        ("position_density", "r [d]"),
        ("intermediate_scattering", "k [1/d]"),
    ],
)
def test_a_density_is_drawn_at_each_time(densities: Any, name: str, label: str) -> None:
    axes = densities.plot(name, ax=Figure().subplots())
    assert axes.get_xlabel() == label
    assert len(axes.lines) == 2
    assert axes.get_legend().get_texts()[0].get_text() == "t = 30 d/U"


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_has_them_all(name: str) -> None:
    xarray = pytest.importorskip("xarray")
    result = RESULTS[name]()
    found = result.to_xarray()
    assert isinstance(found, xarray.Dataset)
    assert {"title", "status", "scene", "version"} <= set(found.attrs)
    drawn = {"over time in a field": "mean_velocity"}.get(name, "vdf")
    assert result.plot(drawn, ax=Figure().subplots()).lines
    assert len(result.to_dataframe())
    assert "<table>" in result._repr_html_()
    assert "np.float64" not in result._repr_html_()


def test_what_is_not_there_is_refused_by_name(averages: Any) -> None:
    with pytest.raises(InputError, match=r"'speed'.*thermal_speed"):
        averages.plot("speed")
    with pytest.raises(InputError, match="velocity: known are"):
        averages.plot("msd", velocity=[1.0])
    with pytest.raises(InputError, match="one number"):
        solve_scaled(0.7).plot("a2")


@pytest.mark.parametrize(("method", "extra"), [("to_xarray", "xarray"), ("to_dataframe", "pandas")])
def test_without_the_package_one_line_says_how_to_get_it(
    averages: Any, monkeypatch: pytest.MonkeyPatch, method: str, extra: str
) -> None:
    monkeypatch.setitem(sys.modules, extra, None)
    with pytest.raises(InputError, match=rf"inelastic-lorentz\[{extra}\]"):
        getattr(averages, method)()


@pytest.mark.parametrize(
    ("number", "text"),
    [(1e4, "10⁴"), (12345.0, "1.234×10⁴"), (-2.5e-7, "−2.5×10⁻⁷"), (0.012, "0.012"), (30, "30")],
)
def test_numbers_in_figures_are_not_in_the_notation_of_python(number: float, text: str) -> None:
    assert printed(number, 4) == text
