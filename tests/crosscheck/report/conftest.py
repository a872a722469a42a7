"""One tiny report of each kind of system, made once and shared by all tests of the report."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from kinetics.crosscheck.report import Report, algebra, make_report
from kinetics.crosscheck.report.systems import DRIVES, Cooling, Driven

TINY = {"count": 400, "media": 12, "tracers": 10, "free_tracers": 2000, "n_times": 6}
FEW = {"collisions": 150_000, "groups": 40, "most_tracers": 8000, "time_rtol": 1e-4}
TINY |= {"rtol": 1e-6, "position_rtol": 1e-3, "final_times": (60.0,)}
SYSTEMS: dict[str, Any] = {
    "paper": Cooling(restitutions=(0.4, 0.7), **TINY),
    "rough": Cooling(restitutions=(1.0,), tangential_restitution=0.5, **TINY),
    "spheres": Cooling(restitutions=(0.5, 0.99), dimension=3, **TINY),
    "elastic": Cooling(restitutions=(1.0,), **TINY),
    **{
        name: Driven((0.5,) if name == "field" else (), name=name, dimension=d, **FEW)
        for name, d in zip(DRIVES, (2, 2, 3, 2), strict=True)
    },
}  # fmt: skip


@dataclass(frozen=True)
class Made:
    report: Report
    folder: Path
    stages: list[str]

    @property
    def name(self) -> str:
        return self.report.results.system.name

    @property
    def page(self) -> Path:
        return self.folder / f"{self.name}.html"


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Made]:
    @cache
    def make(kind: str) -> Made:
        stages: list[str] = []
        with pytest.MonkeyPatch.context() as patch:
            if kind != "paper":  # whose derivations take seconds, once
                patch.setattr(algebra, "derive", lambda system: [])
            report = make_report(SYSTEMS[kind], stages.append)
        folder = tmp_path_factory.mktemp(kind)
        report.write(folder, ("png",) if kind == "elastic" else ())
        return Made(report, folder, stages)

    return make
