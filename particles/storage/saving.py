"""Saving a run while it goes on: each configuration is appended to a journal when it is done."""

import os
import time
from os import PathLike

from particles.configuration import Plan, Tally
from particles.storage.file import cannot_write, difference, plan_digest, read, write
from particles.storage.journal import Journal
from particles.totals import Totals

# Writing the whole file may take this share of the time between two such writings; the journal
# keeps what has been done in between.
SHARE = 0.02


class Saver:
    """Saves a run to its file (particles.storage.file) and journal (particles.storage.journal)."""

    def __init__(self, path: str | PathLike[str], plan: Plan) -> None:
        self.path = os.fspath(path)
        self.plan = plan
        self._journal: Journal
        self._saved = -1
        self._next = 0.0

    def begin(self, resume: bool) -> Totals:
        """Return the totals to go on from, and make sure that the run can be saved.

        Raises ValueError for a file that exists (without resume), is damaged or holds another run,
        for such a journal, or if neither can be written. What is refused is left as it was.
        """
        totals = Totals(self.plan)
        journal = f"{self.path}.journal"
        exists = os.path.exists(self.path)
        if exists:
            if not resume:
                raise ValueError(
                    f"output = {self.path!r}: exists; resume=True (--resume) would go on from it"
                )
            found, arrays, self._saved = read(self.path)
            if other := difference(self.plan, found):
                raise ValueError(f"output = {self.path!r}: holds another run, with {other}")
            totals = Totals.restore(self.plan, arrays)
        elif os.path.exists(journal):
            raise ValueError(
                f"output = {self.path!r}: is not there, but its journal {journal!r} is; "
                f"put it back, or remove the journal"
            )
        try:
            self._journal = Journal(journal, plan_digest(self.plan))
        except OSError as error:
            raise cannot_write(self.path, error) from None
        try:
            self._add_journal(totals)
            if not exists:
                self._save(totals)
        except BaseException:
            if exists:
                self._journal.close()
            else:
                self._journal.remove()
            raise
        return totals

    def add(self, tally: Tally, totals: Totals) -> None:
        """Save one more configuration, which `totals` holds already."""
        try:
            self._journal.append(tally)
        except OSError as error:
            raise cannot_write(self._journal.path, error) from None
        if time.monotonic() >= self._next:
            self._save(totals)

    def finish(self, totals: Totals) -> None:
        """Save everything in the run's own file and remove the journal."""
        try:
            if totals.configurations > self._saved:
                self._save(totals)
            self._journal.remove()
        finally:
            self._journal.close()

    def stop(self) -> None:
        """Save what is complete after an exception; one configuration may be half added by then."""
        _, arrays, _ = read(self.path)
        totals = Totals.restore(self.plan, arrays)
        self._add_journal(totals)
        self.finish(totals)

    def _add_journal(self, totals: Totals) -> None:
        for tally in self._journal.recover(totals.configurations):
            totals.add(tally)

    def _save(self, totals: Totals) -> None:
        began = time.monotonic()
        write(self.path, self.plan, totals.arrays(), totals.configurations)
        self._journal.clear()
        self._saved = totals.configurations
        ended = time.monotonic()
        self._next = ended + (ended - began) / SHARE
