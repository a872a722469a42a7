"""What the derivations give, as rows of text. They run in a process of their own.

    python -m kinetics.crosscheck.report.algebra

prints the rows of the report's labels as JSON; labels may follow.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from kinetics.crosscheck.report.settings import ReportSettings

ANY_LAW = ("rule", "one-collision", "any-moments", "any-slope")
"""Labels of `derivations`, after "beyond:", that a report of another law than the paper's shows."""
IN_DIMENSION = {
    2: ("measure-plane", "plane-equal"),
    3: ("measure-space", "space-power", "space-log", "space-cosine", "space-e-zero"),
}
"""Those of one dimension beside them."""


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
            "printed": "" if check.printed is None else str(check.printed),
            "derived": "" if check.derived is None else str(check.derived),
            "note": check.note,
            "numbers": {number.name: float(number.value) for number in check.numbers},
            "printed_mathml": check.printed_mathml,
            "derived_mathml": check.derived_mathml,
        }
        for check in verify(labels)
    ]


@contextmanager
def algebra_process(settings: ReportSettings) -> Iterator["subprocess.Popen[str]"]:
    """A process that prints the rows of the report's labels, at no cost of time to this one.

    It ends with the context.
    """
    labels: list[str] = []  # those of the paper
    if not settings.is_papers_law:
        labels = [f"beyond:{name}" for name in ANY_LAW + IN_DIMENSION[settings.dimension]]
    # The child must find the packages where this process did, installed or not.
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p))
    with subprocess.Popen(
        [sys.executable, "-P", "-m", "kinetics.crosscheck.report.algebra", *labels],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=environment,
        start_new_session=True,  # Ctrl-C reaches the parent alone, which then ends the child
    ) as process:  # fmt: skip
        try:
            yield process
        finally:
            process.kill()


def printed_rows(process: "subprocess.Popen[str]") -> list[dict[str, Any]]:
    """Wait for the rows. RuntimeError with the child's last line if it failed."""
    out, err = process.communicate()
    if process.returncode:
        last = (err.strip().splitlines() or ["no message"])[-1]
        raise RuntimeError(f"the derivations failed: {last}")
    rows: list[dict[str, Any]] = json.loads(out)
    return rows


if __name__ == "__main__":
    from derivations import report_subset

    json.dump(algebra_rows(sys.argv[1:] or report_subset), sys.stdout)
