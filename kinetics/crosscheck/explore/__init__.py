"""The page to play with: tables that the solver makes (`tables.py`), and the page (`page.py`).

The page itself, HTML, CSS and JavaScript, is `explorer.*` in `kinetics/crosscheck/templates`. It
imports `kinetics`, and of the cross-check only what writes files. Begin with `tables.py`.
"""
