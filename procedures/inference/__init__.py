"""Which causes a residual shows: the posterior probability of hypotheses that are columns with a prior."""
