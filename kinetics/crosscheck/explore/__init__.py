"""The page to play with: tables that the solver makes (`tables.py`), and the page (`page.py`).

Its HTML, CSS and JavaScript are `explorer.*` in `kinetics/crosscheck/templates`.
"""
