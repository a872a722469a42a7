"""A cache of a fixed size that threads may share."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")


class Cache(Generic[Key, Item]):
    """Results by what they depend on; beyond its size the least recently used ones are dropped.

    Threads may use one cache at the same time. Two of them that ask for the same missing result
    both compute it, and get the one that was stored first. A result must not be changed.

    Parameters
    ----------
    size : how many results are kept
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self._items: OrderedDict[Key, Item] = OrderedDict()
        self._lock = Lock()

    def get(self, key: Key, compute: Callable[[], Item]) -> Item:
        """Return the result that is stored under a key; compute and store it if there is none."""
        with self._lock:
            if key in self._items:
                self._items.move_to_end(key)
                return self._items[key]
        item = compute()  # without the lock, as it may need other results of this cache
        with self._lock:
            item = self._items.setdefault(key, item)
            if len(self._items) > self._size:
                self._items.popitem(last=False)
        return item
