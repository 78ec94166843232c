"""Find what the residual says the model lacks, name it or say that it cannot be named, and add it.

`diagnose` corrects anomalies, infers causes, solves again with them and looks at the samples; `findings` states
the posterior as findings, `declared_effects` holds those of a user, `rate_tables` (and soaks) and
`single_channels` are recordings that determine no calibration, `validation_campaigns` tests findings on campaigns
of their own.
"""
