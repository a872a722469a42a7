"""Missing values: masks and the markers of formats become NaN (None where values are texts)."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from kinetics.crosscheck.data.arrays import Column


def without_mask(values: ArrayLike) -> Column:
    """Return values as an array in which what is masked or missing is NaN (None where texts).

    Masked arrays, alone or in lists, and the missing values of pandas' nullable types are missing
    values as NaN is. What has none keeps its type.
    """
    if isinstance(values, list | tuple) and _holds_masked(values):
        return np.array([without_mask(item) for item in values])
    if isinstance(values, pd.Series | pd.Index):
        values = values.array
    if isinstance(values, pd.api.extensions.ExtensionArray):
        return _of_nullable(values)
    if np.ma.isMaskedArray(values):
        return _of_masked(values)
    return np.asarray(values)


def _of_masked(values: np.ma.MaskedArray) -> Column:
    """Return a masked array as a plain one."""
    mask = np.ma.getmaskarray(values)
    if not np.any(mask):
        return np.asarray(values.data)
    if values.dtype.kind in "iuf":
        return np.where(mask, np.nan, values.data)
    texts = values.data.astype(object)
    texts[mask] = None
    return np.asarray(texts)


def _of_nullable(values: pd.api.extensions.ExtensionArray) -> Column:
    """Return an extension array of pandas as one of NumPy."""
    is_number = pd.api.types.is_numeric_dtype(values.dtype)
    if not is_number or pd.api.types.is_bool_dtype(values.dtype):
        return np.asarray(values)
    if np.any(values.isna()):
        return np.asarray(values.to_numpy(dtype=float, na_value=np.nan))
    return np.asarray(values.to_numpy(dtype=getattr(values.dtype, "numpy_dtype", None)))


def _holds_masked(values: ArrayLike) -> bool:
    """Return whether values are a masked array or a masked number, or a list that holds some."""
    if isinstance(values, list | tuple):
        return any(_holds_masked(item) for item in values)
    return bool(np.ma.isMaskedArray(values))
