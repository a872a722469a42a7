"""The report: the three methods on one system, compared number by number, as a page and as JSON.

May import the core of `kinetics`, `particles` and (inside functions, as SymPy is slow to load)
`derivations`, `kinetics.crosscheck.{files,strict_json,text_tables,verdicts}`, and no other room of
the cross-check. `lorentz compare` borrows the drawing and the templates from here.

Begin with `report.py`, which calls the others in this order:

- `settings`: what is asked; `case`: what the methods answer, as plain arrays
- `run_methods`, `scans`, `algebra`: run the solver, the particles and the derivations
- `observables`: reduces densities and averages to numbers that can be compared
- `row`, `case_rows`: one comparison and its verdict; all comparisons of one restitution
- `questions`: the claims of the paper as questions, answered with these numbers
- `causes`, `claims`, `headline`: what lifts the paper's 1.45, the paper's claims judged, and the
  findings with which the page opens; `picture`: tracers among the disks
- `figure_lines`, `all_figures`, `scan_figures`: the data of each figure; `figures`: makes files of
  them, with `strokes` (colours, markers), `drawing` (one panel) and `layout` (all of them)
- `citations`: the paper's equations by their numbers
- `templates`, `page`: sentences and the HTML page, whose prose stands in `../templates`

The report of tracers in a uniform field (`lorentz report --field`) shares rows, figures and the
frame of the document (`frame`) with it, and has files of its own, of which `field_report.py` comes
first: `field_settings`, `field_runs`, `field_density`, `field_limits`, `field_rows`,
`field_figures` and `field_page`.
"""
