"""Which causes a residual shows: one rule, the posterior probability of hypotheses that are columns with a prior."""
