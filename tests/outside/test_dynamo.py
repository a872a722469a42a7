"""DynamO, event-driven molecular dynamics, is asked again where it is installed."""

import shutil

import dynamo_tracks
import numpy as np
import outside_tracks
import pytest

from kinetics import fit

needs_dynamo = pytest.mark.skipif(shutil.which("dynarun") is None, reason="needs DynamO")


@needs_dynamo
def test_head_on_collisions_leave_the_restitution_and_positions_run_on() -> None:
    """The tracer meets a disk, and then the image of it on the other side of the box."""
    disk = np.array([[5.0, 5.0]])
    place = np.array([[3.0, 5.0]])
    velocity = np.array([[1.0, 0.0]])
    text = dynamo_tracks.fill_template(0.5, 10.0, disk, place, velocity)
    # contacts at x = 4, t = 1 and x = -4, t = 17
    start, end = dynamo_tracks.follow(text, 1, (0.0, 19.0))[:, 0]
    np.testing.assert_allclose(end - start, [-3.5 - 3.0, 0.0, 0.25 - 1.0, 0.0], atol=1e-9)


@needs_dynamo
@pytest.mark.slow
@pytest.mark.parametrize(("restitution", "density"), [(0.4, 0.02), (0.9, 0.04)])
def test_dynamo_asked_again(restitution: float, density: float) -> None:
    rows = dynamo_tracks.run_dynamo(restitution, density, seed=2)
    result = fit(outside_tracks.columns_of(rows), scatterers="hard disks")
    assert result.verdict == "agrees"
    found = result.parameters["restitution"]
    assert abs(found.value - restitution) < 3.5 * found.error
