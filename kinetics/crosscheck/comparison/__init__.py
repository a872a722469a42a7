"""The comparison of particle data, from any code, with the kinetic equation.

For: reading data (`data/`), reducing them to sums over independent groups (`reduction`, `sample`),
solving the kinetic equation for them (`theory`), chi-squares and verdicts (`statistics`,
`data_and_theory`, `judging`), and what may explain a difference (`hypotheses`). May import:
`kinetics` and `particles`, and of the cross-check `verdicts`, `strict_json`, `text_tables`, `files`
and the drawing and templates of `report`. Begin reading at `question.compare_data`, then
`judging.compare`.
"""
