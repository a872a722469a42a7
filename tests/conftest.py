"""What all tests share."""

import os
import sys
from pathlib import Path
from typing import Any

import pytest

# the matrices are small: threads of the linear algebra only get into each other's way
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# the formulas behind the reference values: collision.py, cooling.py, displacement.py, densities.py
sys.path.insert(0, str(Path(__file__).with_name("references")))


# The first test compiles nearly all kernels while another process derives and solves: two processes
# that came to the same kernel at the same time would both compile it. Short tests come last.
ORDER = [
    "tests/particles/kernel/test_interpreted.py", "tests/derivations", "tests/kinetics",
    "tests/fuzz", "tests/particles", "tests/crosscheck", "tests",
]  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Sort the tests by ORDER."""

    def rank(item: pytest.Item) -> int:
        return next(k for k, start in enumerate(ORDER) if item.nodeid.startswith(start))

    items.sort(key=rank)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """The tests of a file run in one process, which prepares what they share once.

    So do all of the derivations, which share 15 s of algebra.
    """
    from xdist.scheduler import LoadFileScheduling

    config.option.loadscopereorder = False  # in the order above, not the files of most tests first

    class ByFile(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = super()._split_scope(nodeid)
            return "derivations" if file.startswith("tests/derivations/") else file

    return ByFile(config, log)
