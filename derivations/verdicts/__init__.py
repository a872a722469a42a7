"""Printed against derived: the verdict on every labelled equation.

``difference`` decides whether two formulas state the same, ``checks`` gives one :class:`Check`
per label. May import: ``symbols``, ``formal``, ``typesetting``, ``printed``, ``derived``. Begin
reading with ``checks``.
"""

from .checks import Check, report_subset, verify

__all__ = ["Check", "report_subset", "verify"]
