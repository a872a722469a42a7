"""What all tests share."""

import json
import os
import signal
from collections.abc import Iterator
from typing import Any

import pytest

from kinetics import cli

# the matrices are small: threads of the linear algebra only get into each other's way
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


class Lorentz:
    """The command in this process: what it prints, or the one line with which it refuses."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys

    def __call__(self, *arguments: str) -> str:
        """Standard output of a command that ends well and says nothing else."""
        assert cli.main(list(arguments)) == 0
        out, err = self._capsys.readouterr()
        assert err == ""
        return out

    def json(self, *arguments: str) -> Any:
        return json.loads(self(*arguments, "--json"))

    def refused(self, *arguments: str) -> str:
        """The line on standard error of a command that is refused."""
        assert cli.main(list(arguments)) == cli.BAD_INPUT
        out, err = self._capsys.readouterr()
        assert out == ""
        assert err.startswith("lorentz: ")
        assert (err.count("\n"), err[-1]) == (1, "\n")
        assert len(err) < 410
        return err


@pytest.fixture
def lorentz(capsys: pytest.CaptureFixture[str]) -> Iterator[Lorentz]:
    handler = signal.getsignal(signal.SIGTERM)
    yield Lorentz(capsys)
    signal.signal(signal.SIGTERM, handler)


#: Folders whose tests derive the formulas of the paper.
WITH_DERIVATIONS = ("tests/derivations/", "tests/crosscheck/report/")

# The first test compiles nearly all kernels while another process derives and solves: two processes
# that came to the same kernel at the same time would both compile it. Then come the files that take
# longest.
ORDER = [
    "tests/particles/test_every_event.py", *WITH_DERIVATIONS,
    "tests/crosscheck/compare/test_verdicts.py",
    "tests/kinetics", "tests/particles", "tests/crosscheck", "tests",
]  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Sort the tests by ORDER."""

    def rank(item: pytest.Item) -> int:
        return next(k for k, start in enumerate(ORDER) if item.nodeid.startswith(start))

    items.sort(key=rank)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """The tests of a file run in one process, which prepares what they share once.

    So do all of the derivations, and the reports, which share 15 s of algebra.
    """
    from xdist.scheduler import LoadFileScheduling

    config.option.loadscopereorder = False  # in the order above, not the files of most tests first

    class ByFile(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = super()._split_scope(nodeid)
            return "derivations" if file.startswith(WITH_DERIVATIONS) else file

    return ByFile(config, log)
