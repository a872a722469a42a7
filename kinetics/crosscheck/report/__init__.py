"""The report: the three methods on one system, compared number by number, as a page and JSON.

Begin with `report.py`.
"""
