"""A cache of a fixed size that threads may share."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")


class Cache(Generic[Key, Item]):
    """Results by what they depend on; beyond its size the oldest ones are dropped.

    Threads may use one cache at the same time. Two of them that ask for the same missing result
    both compute it, and get the one that was stored first. A result must not be changed.

    Parameters
    ----------
    size : how many results are kept
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self._items: dict[Key, Item] = {}
        self._lock = Lock()

    def get(self, key: Key, compute: Callable[[], Item]) -> Item:
        """Return the result that is stored under a key; compute and store it if there is none."""
        try:
            return self._items[key]
        except KeyError:
            pass
        item = compute()  # without the lock, as it may need other results of this cache
        with self._lock:
            item = self._items.setdefault(key, item)
            if len(self._items) > self._size:
                oldest = next(iter(self._items))
                del self._items[oldest]
        return item
