"""An Ensemble as plots, data frames and datasets."""

import io
import json
import sys
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from particles import OBSERVABLES, BoltzmannGrad, HardDisks, simulate

TIMES = [0.0, 1.0, 30.0, 1000.0]
HISTOGRAMS = [name for name in OBSERVABLES if name.endswith("histogram")]


@pytest.fixture(scope="module")
def ensemble() -> Any:
    return simulate(
        HardDisks(0.04, 400), 0.7, times=TIMES, media=4, tracers=20, observables=HISTOGRAMS
    )


@pytest.fixture(scope="module")
def falling() -> Any:
    return simulate(
        BoltzmannGrad(0.04),
        0.7,
        "rest",
        times=[1.0, 9.0],
        media=4,
        tracers=20,
        field=0.1,
        depth=2.0,
    )


def test_a_data_frame_has_every_estimate_with_its_error(ensemble: Any, falling: Any) -> None:
    pytest.importorskip("pandas")
    frame = ensemble.to_dataframe()
    assert frame.time.tolist() == TIMES
    assert frame.msd.tolist() == ensemble.msd.value.tolist()
    assert frame.msd_error.tolist() == ensemble.msd.error.tolist()
    assert frame.attrs["units"]["msd"] == "d^2"
    frame = falling.to_dataframe()
    assert frame.dispersion_xy_error.tolist() == falling.dispersion.error[:, 0, 1].tolist()
    assert frame.passed.tolist() == falling.passed.value.tolist()


@pytest.mark.parametrize("name", HISTOGRAMS)
def test_a_data_frame_of_a_histogram_has_a_row_for_each_bin(ensemble: Any, name: str) -> None:
    pytest.importorskip("pandas")
    frame, found = ensemble.to_dataframe(name), getattr(ensemble, name)
    assert frame.density.tolist() == found.density.value.ravel().tolist()
    if name != "free_path_histogram":
        share = frame.density * (frame.high - frame.low)
        total = share.groupby(frame.time).sum()
        outside = found.below + found.above
        np.testing.assert_allclose(total, 1.0 - outside, rtol=1e-12)


def test_a_dataset_goes_through_a_netcdf_file(ensemble: Any, falling: Any) -> None:
    xarray = pytest.importorskip("xarray")
    for run in (ensemble, falling):
        found = run.to_xarray()
        written = io.BytesIO(bytes(found.to_netcdf(engine="scipy")))
        assert xarray.open_dataset(written, engine="scipy").identical(found)
        assert found.thermal_speed.attrs["units"] == "U"
        assert json.loads(found.attrs["scene"])["restitution"] == 0.7
        assert "finished" in found.attrs["status"]
        for name in {*run.outputs} - {"passage_times"}:  # of single tracers
            assert name in found
            assert f"{name}_error" in found


@pytest.mark.parametrize("name", ["thermal_speed", "a2", "msd", "collisions", *HISTOGRAMS])
def test_what_is_drawn_is_labelled_with_its_unit(ensemble: Any, name: str) -> None:
    axes = Figure().subplots()
    assert ensemble.plot(name, ax=axes) is axes
    if name in HISTOGRAMS:
        assert len(axes.patches) == (1 if name.startswith("free") else len(TIMES))
        assert axes.get_xlabel().endswith(("[U]", "[d]"))
    else:
        assert axes.lines[0].get_ydata().tolist() == getattr(ensemble, name).value.tolist()
        assert axes.get_xlabel() == "t [d/U]"
    axes.figure.canvas.draw()


def test_each_component_of_a_tensor_is_drawn(falling: Any) -> None:
    axes = falling.plot("dispersion", ax=Figure().subplots())
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == [f"dispersion {ij}" for ij in ("xx", "xy", "yx", "yy")]


def test_what_is_not_there_is_refused_by_name(
    ensemble: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ValueError, match=r"'drift'.*thermal_speed"):
        ensemble.plot("drift")
    with pytest.raises(ValueError, match="one number"):
        ensemble.plot("mean_free_path")
    with pytest.raises(ValueError, match="no histogram"):
        ensemble.to_dataframe("msd")
    for module, method in (("pandas", "to_dataframe"), ("xarray", "to_xarray")):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(ValueError, match=rf"inelastic-lorentz\[{module}\]"):
            getattr(ensemble, method)()
