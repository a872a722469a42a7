"""Which function derives which label; each runs at most once in a process."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from .record import Derived

Derivation = Callable[[], Derived]
REGISTRY: dict[str, Derivation] = {}


def derives(*labels: str) -> Callable[[Derivation], Derivation]:
    """Register a derivation for one or more labels (the paper repeats some formulas)."""

    def register(function: Derivation) -> Derivation:
        once = cache(function)
        for label in labels:
            if label in REGISTRY:
                raise ValueError(f"label {label!r} is derived twice")
            REGISTRY[label] = once
        return function

    return register
