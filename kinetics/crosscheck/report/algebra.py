"""What the derivations give, as rows of text. They run in a process of their own.

    python -m kinetics.crosscheck.report.algebra

prints the rows of the report's labels as JSON.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterable
from typing import Any


def algebra_rows(labels: Iterable[str]) -> list[dict[str, Any]]:
    """One row per label: title, status, note, and both formulas as sympy's text and as MathML.

    ValueError for a label that does not exist.
    """
    from derivations import verify

    return [
        {
            "label": check.label,
            "title": check.title,
            "status": str(check.status),
            "proof": check.proof,
            "printed": _text(check.printed),
            "derived": _text(check.derived),
            "note": check.note,
            "numbers": {number.name: float(number.value) for number in check.numbers},
            "printed_mathml": check.printed_mathml,
            "derived_mathml": check.derived_mathml,
        }
        for check in verify(labels)
    ]


def _text(formula: object) -> str:
    return "" if formula is None else str(formula)


class AlgebraProcess:
    """`algebra_rows` of the report's labels in a process of its own, so that it costs no time.

    A context manager: leaving it by an exception ends the process.
    """

    def __init__(self) -> None:
        # The child must find the packages where this process did, installed or not.
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p))
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "kinetics.crosscheck.report.algebra"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment,
            text=True,
            # Ctrl-C reaches the parent alone, which then ends the child.
            start_new_session=True,
        )

    def rows(self) -> list[dict[str, Any]]:
        """Wait for the rows. RuntimeError with the child's last line if it failed."""
        out, err = self._process.communicate()
        if self._process.returncode:
            last = (err.strip().splitlines() or ["no message"])[-1]
            raise RuntimeError(f"the derivations failed: {last}")
        rows: list[dict[str, Any]] = json.loads(out)
        return rows

    def __enter__(self) -> "AlgebraProcess":
        return self

    def __exit__(self, *exception: object) -> None:
        if self._process.poll() is None:
            self._process.kill()
        with self._process:  # waits, and closes the pipes
            pass


if __name__ == "__main__":
    from derivations import report_subset

    json.dump(algebra_rows(report_subset), sys.stdout)
