"""The journal of a run: each configuration as it is done, appended to a file beside the run's own.

The file of a run (particles.storage.file) is always written as a whole. That takes longer the more
it holds, so it cannot be done after every configuration. In between, each configuration becomes one
record of `<file>.journal`, which the system has received before the run goes on. The journal is
emptied when the file has been written, and removed when the run ends.

Layout: HEAD; SHA-256 of the plan (32 bytes); records. A record is the length of its contents
(8 bytes, little-endian), the CRC-32 of these 8 bytes (4 bytes), the SHA-256 of the contents
(32 bytes), the contents: one line of JSON, which names the configuration and its arrays with their
types and shapes, and then the arrays.

While a run goes on it has its journal locked. It opens and locks the journal before it looks at
anything else, and the system unlocks it when the process ends, in whatever way.

A process that is killed while it appends leaves the beginning of a record at the end of the file.
That part is cut off, and its configuration is run again, to the same bits. Any other difference
from what was written is damage, and the journal is refused. Only the file of the run is safe
against a loss of power: records are not forced to the disk.
"""

import json
import os
import struct
import warnings
import zlib
from collections.abc import Iterator
from contextlib import suppress
from hashlib import sha256
from io import FileIO
from weakref import WeakSet

import numpy as np

from particles.configuration import Tally
from particles.storage.whole_files import SAFELY, require_regular, write_all

try:
    import fcntl
except ImportError:  # pragma: no cover - Windows: nothing keeps two runs from one file
    fcntl = None  # type: ignore[assignment]

HEAD = b"inelastic-lorentz particles journal 1\n"
_LENGTH = struct.Struct("<QI")
_DIGEST = 32

_open_journals: WeakSet["Journal"] = WeakSet()


def _close_all() -> None:
    """Close the journals of the parent process: its lock would last as long as the child does."""
    for journal in _open_journals:
        journal.close()


if hasattr(os, "register_at_fork"):  # Windows has no fork
    os.register_at_fork(after_in_child=_close_all)


class Journal:
    """An open journal, created if it is not there; other processes cannot open it meanwhile.

    plan: SHA-256 of the plan. created: whether it was not there. Raises ValueError where another
    process has it open, or it is not a file; OSError where it cannot be written.
    """

    def __init__(self, path: str, plan: bytes) -> None:
        self.path = path
        self._head = HEAD + plan
        self._end = 0
        while True:
            descriptor, self.created = _open(path)
            # Not buffered: what an interruption leaves unwritten must not follow later.
            self._file = open(descriptor, "r+b", buffering=0)  # noqa: SIM115 - closed by `close`
            try:
                require_regular(path)
                _lock(self._file, path)
                if _is_still(self._file, path):
                    _open_journals.add(self)
                    return
            except BaseException:
                self.close()
                raise
            self.close()  # the process that had it locked has removed it: begin again

    def close(self) -> None:
        """Close the journal, keep its contents and unlock it."""
        self._file.close()

    def recover(self, done: int) -> list[Tally]:
        """Return the tallies from configuration `done` on. Nothing is changed.

        Raises ValueError where the journal is damaged or belongs to another run.
        """
        file = self._file
        file.seek(0)
        head = file.read(len(self._head))
        self._end = 0
        tallies: list[Tally] = []
        if head != self._head:
            # A process killed at once leaves no configuration, and perhaps not the whole head.
            if not file.read(1) and HEAD.startswith(head[: len(HEAD)]):
                return tallies
            what = "belongs to another run" if head.startswith(HEAD) else "is not a journal"
            raise ValueError(f"{self.path}: {what}; nothing was changed")
        self._end = file.tell()
        for tally, end in self._records():
            self._end = end
            # What was done before the run's file was written: killed before it could be emptied.
            if tally.configuration < done:
                continue
            if tally.configuration != done + len(tallies):
                raise self._damaged(f"configuration {done + len(tallies)} is not in it")
            tallies.append(tally)
        return tallies

    def begin(self) -> None:
        """Make ready for more: cut off what is not whole, and write the head if it is missing."""
        self._file.truncate(self._end)
        if not self._end:
            write_all(self._file.fileno(), self._head)

    def append(self, tally: Tally) -> None:
        """Append the next configuration."""
        contents = _pack(tally)
        length = len(contents).to_bytes(8, "little")
        head = _LENGTH.pack(len(contents), zlib.crc32(length))
        write_all(self._file.fileno(), head + sha256(contents).digest() + contents)

    def clear(self) -> None:
        """Remove all records."""
        self._file.truncate(len(self._head))

    def remove(self) -> None:
        """Delete the journal."""
        os.unlink(self.path)
        self.close()

    def _records(self) -> Iterator[tuple[Tally, int]]:
        """Yield each whole record's tally and where the record ends."""
        file = self._file
        size = os.fstat(file.fileno()).st_size
        while len(head := file.read(_LENGTH.size)) == _LENGTH.size:
            length, check = _LENGTH.unpack(head)
            if zlib.crc32(head[:8]) != check:
                raise self._damaged(f"at byte {file.tell() - len(head)}")
            if file.tell() + _DIGEST + length > size:
                return
            digest, contents = file.read(_DIGEST), file.read(length)
            if sha256(contents).digest() != digest:
                raise self._damaged(f"at byte {file.tell() - length}")
            try:
                tally = _unpack(contents)
            except Exception:  # only a record that was made to do harm comes here
                raise self._damaged(f"at byte {file.tell() - length}") from None
            yield tally, file.tell()

    def _damaged(self, how: str) -> ValueError:
        return ValueError(
            f"{self.path}: is damaged ({how}); without it, the run goes on from its own file"
        )


def _open(path: str) -> tuple[int, bool]:
    """Return the descriptor of a journal, and whether it was not there before."""
    flags = os.O_RDWR | os.O_APPEND | SAFELY
    while True:
        with suppress(FileExistsError):
            return os.open(path, flags | os.O_CREAT | os.O_EXCL, 0o666), True
        if os.path.islink(path):
            raise ValueError(f"{path}: is a symbolic link, not a file")
        with suppress(FileNotFoundError):  # removed in between
            return os.open(path, flags), False


def _lock(file: FileIO, path: str) -> None:
    """Lock a file for as long as it is open; the system unlocks it when a process is killed."""
    if fcntl is None:  # pragma: no cover
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise ValueError(f"{path}: in use by another process") from None
    except OSError as error:
        warnings.warn(
            f"{path} cannot be locked ({error.strerror}): let no other process save to this run",
            stacklevel=2,
        )


def _is_still(file: FileIO, path: str) -> bool:
    """Tell whether an open file is the one that has this path now."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.lstat(path))
    except FileNotFoundError:
        return False


def _pack(tally: Tally) -> bytes:
    arrays = {
        "moments": tally.moments,
        "totals": tally.totals,
        "statuses": tally.statuses,
        "traps": tally.traps,
        **({"field_sums": tally.field_sums} if tally.field_sums.size else {}),
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
