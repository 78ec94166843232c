"""Which causes the rows of evidence show: the posterior probability of hypotheses that are columns with a prior.

`hypotheses` makes columns of named effects, `smooth_functions` of what no catalogue holds, `priors` states every
chosen number, also from which probability on a cause is likely or established; `board` lays them next to the
evidence, `marginal` weighs them, `search` keeps the likely models,
`posterior` says what these say together, and `infer` runs it all. `odds` is the rule for what is no row.
"""
