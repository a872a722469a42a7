"""Which function derives which label. Registration order is the order of the rows."""

from __future__ import annotations

from collections.abc import Callable

from .record import Derived

Derivation = Callable[[], Derived]
REGISTRY: dict[str, Derivation] = {}


def derives(*labels: str) -> Callable[[Derivation], Derivation]:
    """Register a derivation for one or more labels (the paper repeats some formulas)."""

    def register(function: Derivation) -> Derivation:
        for label in labels:
            if label in REGISTRY:
                raise ValueError(f"label {label!r} is derived twice")
            REGISTRY[label] = function
        return function

    return register
