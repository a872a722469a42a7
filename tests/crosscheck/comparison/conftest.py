"""Made-up particle data and the files that hold them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from kinetics.crosscheck.comparison.sample import R2, R4, V2, V4, Sample

NAMES = ("time", "x", "y", "vx", "vy", "tracer", "medium")


def _made_up(tracers: int = 40, times: Any = (0.0, 1.0, 10.0)) -> dict[str, Any]:
    """Columns of `tracers` tracers, four to a configuration; at time 0 at the origin."""
    rng = np.random.default_rng(8)
    time = np.repeat(np.asarray(times, float), tracers)
    x, y = rng.normal(size=(2, time.size)) * time
    vx, vy = rng.normal(size=(2, time.size)) / (1 + time)
    tracer = np.tile(np.arange(tracers), len(times))
    return dict(zip(NAMES, (time, x, y, vx, vy, tracer, tracer // 4), strict=True))


def _text_of(data: dict[str, Any], separator: str = ",") -> str:
    lines = [separator.join(data)]
    lines += [separator.join(repr(v.item()) for v in row) for row in zip(*data.values())]  # noqa: B905
    return "\n".join(lines) + "\n"


def _moments(sample: Sample) -> Any:
    """Sums of v^2, v^4, r^2, r^4 in the sample's units: (n_groups, n_times, 4)."""
    v, r = sample.speed_scale**2, sample.length_scale**2
    return sample.sums[:, :, [V2, V4, R2, R4]] * np.stack([v, v**2, r, r**2], axis=-1)


def _write(folder: Path, kind: str, data: dict[str, Any]) -> Path:
    path = folder / f"data.{kind}"
    if kind == "csv":
        path.write_text(_text_of(data))
    elif kind == "npz":
        np.savez(path, **data)
    elif kind == "zip.npz":
        np.savez_compressed(path, **data)
    else:
        with h5py.File(path, "w") as file:
            for name, values in data.items():
                file[name] = values
    return path


def _tracers_at(times: Any, count: int, speed: Any = None, scale: float = 1.0) -> dict[str, Any]:
    """Tracers that spread as they fly; `speed`: all of them the same."""
    data = _made_up(count, times)
    data = {k: v for k, v in data.items() if k != "medium"}
    for name in ("x", "y", "vx", "vy"):
        data[name] = data[name] * scale
    if speed is not None:
        data["vx"], data["vy"] = np.full(data["time"].size, speed), np.zeros(data["time"].size)
    return data


@pytest.fixture
def made_up() -> Callable[..., Any]:
    return _made_up


@pytest.fixture
def text_of() -> Callable[..., Any]:
    return _text_of


@pytest.fixture
def moments() -> Callable[..., Any]:
    return _moments


@pytest.fixture
def write() -> Callable[..., Any]:
    return _write


@pytest.fixture
def tracers_at() -> Callable[..., Any]:
    return _tracers_at
