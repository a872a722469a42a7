"""The comparison of particle data, from any code, with the kinetic equation.

For: reading data (`data/`), reducing them to sums over independent groups (`reduction`, `sample`),
whether their units belong together (`units`), solving the kinetic equation for them (`theory`),
fitting what was not told (`fit`), chi-squares and verdicts (`statistics`, `data_and_theory`,
`judging`), what may explain a difference (`hypotheses`: one entry of a table each), and what is
noted in any case (`notes`). May import: `kinetics` and `particles`, and of the cross-check
`verdicts`, `strict_json`, `text_tables`, `files` and the drawing and templates of `report`. Begin
reading at `question.compare_data`, then `judging.compare`.
"""
