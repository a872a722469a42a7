"""The stability sweep: solvers and particles at their limits, a verdict for each case.

`run.run_stress` runs it; `lorentz stress` is its command. It may import everything below the
cross-check (`kinetics`, `particles`) and `kinetics.crosscheck.references`. How bad input, random
scenes and other units end is not here but in the tests (tests/crosscheck/stress).

Begin reading at `case` (what a case is, and its verdict). The files `*_cases` hold the cases,
`limits` and `starts` what is known of their answers, `run` and `report` the rest.
"""
