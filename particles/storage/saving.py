"""Saving a run while it goes on: each configuration is appended to a journal when it is done."""

import os
import time

from particles.checks import short
from particles.configuration import Plan, Tally
from particles.storage.file import difference, plan_digest, read, write
from particles.storage.journal import Journal
from particles.storage.whole_files import cannot_write, remove_leftovers, require_regular
from particles.totals import Totals

# Writing the whole file may take this share of the time between two such writings; the journal
# keeps what has been done in between.
SHARE = 0.02


class Saver:
    """Saves a run to its file (particles.storage.file) and journal (particles.storage.journal)."""

    def __init__(self, path: str, plan: Plan) -> None:
        self.path = path
        self.plan = plan
        self._journal: Journal
        self._saved = -1
        self._next = 0.0

    def begin(self, resume: bool) -> Totals:
        """Return the totals to go on from, and make sure that the run can be saved.

        Raises ValueError for a run that exists (without resume), is in use, is damaged or is
        another one, or if it cannot be written. What is refused is left as it was.
        """
        require_regular(self.path)
        try:
            self._journal = Journal(f"{self.path}.journal", plan_digest(self.plan))
        except OSError as error:
            raise cannot_write(self.path, error) from None
        try:
            return self._begin(resume)
        except BaseException:
            if self._journal.created:
                self._journal.remove()
            self._journal.close()
            raise

    def _begin(self, resume: bool) -> Totals:
        totals = Totals(self.plan)
        exists = os.path.exists(self.path)
        if exists and not resume:
            raise _exists(self.path)
        if exists:
            found, arrays, self._saved = read(self.path)
            if other := difference(self.plan, found):
                raise ValueError(
                    f"output = {short(self.path, 200)}: holds another run, with {other}"
                )
            totals = Totals.restore(self.plan, arrays)
        self._add_journal(totals)
        if totals.configurations and not resume:
            raise _exists(self._journal.path)
        remove_leftovers(self.path)
        try:
            self._journal.begin()
        except OSError as error:
            raise cannot_write(self._journal.path, error) from None
        if not exists:
            self._save(totals)
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
        """Save what is complete after an exception; one configuration may be half added by then.

        Where that cannot be done, as on a full disk, the journal stays and the run goes on from it.
        """
        try:
            _, arrays, self._saved = read(self.path)
            totals = Totals.restore(self.plan, arrays)
            self._add_journal(totals)
            self._journal.begin()
            self.finish(totals)
        finally:
            self._journal.close()

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


def _exists(path: str) -> ValueError:
    return ValueError(
        f"output = {short(path, 200)}: exists; resume=True (--resume) would go on from it"
    )
