"""The journal of a run: each configuration as it is done, appended to a file beside the run's own.

The file of a run (particles.storage.file) is always written as a whole. That takes longer the more
it holds, so it cannot be done after every configuration. In between, each configuration becomes one
record of `<file>.journal`, which the system has received before the run goes on. The journal is
emptied when the file has been written, and removed when the run ends.

Layout: HEAD; SHA-256 of the plan (32 bytes); records. A record is the length of its contents
(8 bytes, little-endian), the CRC-32 of these 8 bytes (4 bytes), the SHA-256 of the contents
(32 bytes), the contents: one line of JSON, which names the configuration and its arrays with their
types and shapes, and then the arrays.

A process that is killed while it appends leaves the beginning of a record at the end of the file.
That part is cut off, and its configuration is run again, to the same bits. Any other difference
from what was written is damage, and the journal is refused. Only the file of the run is safe
against a loss of power: records are not forced to the disk.
"""

import json
import os
import struct
import zlib
from collections.abc import Iterator
from hashlib import sha256

import numpy as np

from particles.configuration import Tally

try:
    import fcntl
except ImportError:  # pragma: no cover - Windows: nothing keeps two runs from one file
    fcntl = None  # type: ignore[assignment]

HEAD = b"inelastic-lorentz particles journal 1\n"
_LENGTH = struct.Struct("<QI")
_DIGEST = 32


class Journal:
    """An open journal, created if it is not there; other processes cannot open it meanwhile.

    plan: SHA-256 of the plan. Raises ValueError where the journal is damaged, belongs to another
    run or is in use, OSError where it cannot be written.
    """

    def __init__(self, path: str, plan: bytes) -> None:
        self.path = path
        self._head = HEAD + plan
        # Not buffered: what an interruption leaves unwritten must not follow later.
        self._file = open(path, "a+b", buffering=0)  # noqa: SIM115 - closed by `close`
        if fcntl is not None:
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                self.close()
                raise ValueError(f"{path}: another process is at this run") from None

    def close(self) -> None:
        """Close the journal and keep its contents."""
        self._file.close()

    def recover(self, done: int) -> list[Tally]:
        """Return the tallies from configuration `done` on; nothing is changed if this raises."""
        file = self._file
        file.seek(0)
        head = file.read(len(self._head))
        tallies: list[Tally] = []
        if head != self._head:
            if not self._head.startswith(head):
                what = "belongs to another run" if head.startswith(HEAD) else "is not a journal"
                raise ValueError(f"{self.path}: {what}; nothing was changed")
            self.clear()
            return tallies
        end = file.tell()
        for tally, end in self._records():  # noqa: B007 - the last end is used
            # What was done before the run's file was written: killed before it could be emptied.
            if tally.configuration < done:
                continue
            if tally.configuration != done + len(tallies):
                raise self._damaged(f"configuration {done + len(tallies)} is not in it")
            tallies.append(tally)
        file.truncate(end)
        return tallies

    def append(self, tally: Tally) -> None:
        """Append the next configuration."""
        contents = _pack(tally)
        length = len(contents).to_bytes(8, "little")
        head = _LENGTH.pack(len(contents), zlib.crc32(length))
        self._write(head + sha256(contents).digest() + contents)

    def clear(self) -> None:
        """Remove all records."""
        self._file.truncate(0)
        self._write(self._head)

    def remove(self) -> None:
        """Delete the journal."""
        os.unlink(self.path)
        self.close()

    def _write(self, data: bytes) -> None:
        rest = memoryview(data)
        while rest:
            rest = rest[self._file.write(rest) :]

    def _records(self) -> Iterator[tuple[Tally, int]]:
        """Yield each whole record's tally and where the record ends."""
        file = self._file
        while len(head := file.read(_LENGTH.size)) == _LENGTH.size:
            length, check = _LENGTH.unpack(head)
            if zlib.crc32(head[:8]) != check:
                raise self._damaged(f"at byte {file.tell() - len(head)}")
            digest, contents = file.read(_DIGEST), file.read(length)
            if len(digest) < _DIGEST or len(contents) < length:
                return
            if sha256(contents).digest() != digest:
                raise self._damaged(f"at byte {file.tell() - length}")
            yield _unpack(contents), file.tell()

    def _damaged(self, how: str) -> ValueError:
        return ValueError(
            f"{self.path}: is damaged ({how}); without it, the run goes on from its own file"
        )


def _pack(tally: Tally) -> bytes:
    arrays = {
        "moments": tally.moments,
        "totals": tally.totals,
        "statuses": tally.statuses,
        "traps": tally.traps,
        **{f"histograms/{name}": array for name, array in tally.histograms.items()},
        **{f"raw/{name}": array for name, array in tally.raw.items()},
    }
    shapes = [(name, array.dtype.str, array.shape) for name, array in arrays.items()]
    line = json.dumps({"configuration": tally.configuration, "arrays": shapes})
    return b"".join([line.encode(), b"\n", *(array.tobytes() for array in arrays.values())])


def _unpack(contents: bytes) -> Tally:
    line, _, rest = contents.partition(b"\n")
    described = json.loads(line)
    groups: dict[str, dict[str, np.ndarray]] = {"": {}, "histograms": {}, "raw": {}}
    at = 0
    for name, kind, shape in described["arrays"]:
        count = int(np.prod(shape))
        array = np.frombuffer(rest, kind, count, at).reshape(shape)
        group, _, key = name.rpartition("/")
        groups[group][key] = array
        at += array.nbytes
    own, histograms, raw = groups.values()
    return Tally(described["configuration"], **own, histograms=histograms, raw=raw)
