"""Rows of evidence: what the samples of a campaign say about its model, one row per thing seen, with its 1 sigma.

`excitation` is what the sensors went through, `residual_rows` the rows of dwells, rotations, rests and soaks,
`thermal_soaks` and `rate_points` those of long recordings and of turntables, `linear_model` a fit to the rows,
`candidates` the effects that they can show, `refit` the model solved again with effects in it, and
`residual_patterns` what is left.
"""
