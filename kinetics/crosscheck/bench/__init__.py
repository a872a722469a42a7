"""The benchmark: run time against error, on the same problems for every method.

`run.run_bench` measures; `lorentz bench` is its command. It may import everything below the
cross-check (`kinetics`, `particles`) and the values of `kinetics.crosscheck.references`. Speed from
one version of this package to the next is not its business: see ``tests/benchmarks``.

Begin reading at `run` (the cases, each in a process of its own) and `measuring` (how a piece of
work becomes a row, `record`). `precision` and `position` hold the problems and the five methods,
`accuracy` error asked against error reached, `skipping` what skipping saves, `cost` the run time
against the amount of work, `throughput` the particles. `analysis`, `tables` and `figures` make the
report from the rows.
"""
