"""The uncertainty budget: which source has which part in a parameter's variance, and what interval follows.

A fit is Gauss-Newton on whitened rows ``r`` of variance one: the estimate moves by ``G r``, ``G = P J'`` (P the
covariance, J the Jacobian). Each row's part of ``sum over rows G_row G_row'`` belongs to the row's `sources`, as
`row_variance` and `excess_scatter` split it; `budget` carries it to k, E and D. `sources` names them.
"""
