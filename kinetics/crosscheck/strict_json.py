"""Results as what JSON can hold, strictly: no NaN, no infinity, no NumPy."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """The value with arrays as lists, NumPy's numbers as Python's, and None for non-finite ones."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def dumps(value: Any) -> str:
    """Strict JSON of a value (see `plain`) and a newline."""
    return json.dumps(plain(value), allow_nan=False, indent=1) + "\n"
