"""Which cases of a test run by default."""

from collections.abc import Iterable
from typing import Any

import pytest


def slow_but(kept: Iterable[Any], cases: Iterable[Any]) -> list[Any]:
    """Return the cases for `parametrize`; those that are not among the kept ones run with -m slow.

    A case of several arguments is a tuple.
    """
    kept = list(kept)

    def mark(case: Any) -> Any:
        values = case if isinstance(case, tuple) else (case,)
        return pytest.param(*values, marks=[] if case in kept else pytest.mark.slow)

    return [mark(case) for case in cases]
