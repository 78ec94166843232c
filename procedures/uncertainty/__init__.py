"""The uncertainty budget: which source has which part in a parameter's variance, and what interval follows.

`sources` (by name), `row_variance` (of every whitened row, split by source), `excess_scatter` (what the model does
not explain, temperature), `budget` (through the fit's gain to k, E and D; degrees of freedom, coverage factor).
The covariance of a solution is that of `procedures.calibration.triad_calibration`: the parts add up to it (a test
holds it). This is the only budget: reports, certificates and `calibration/1` print it. Other uncertainties are of
something else: of a plan before it is recorded `procedures.planning.design_sigmas`, of corrected samples
`station.calibrated.remaining_uncertainty`, of a cube's machining `procedures.tolerance`.

A fit is Gauss-Newton on whitened rows ``r``, each of variance one: the estimate moves by ``G r`` with
``G = P J'`` (P the covariance, J the Jacobian), so that the covariance is ``sum over rows G_row G_row'``. Each
row's part belongs to the source of that row, and where its variance has several, to these as they share it.
"""
