"""The uncertainty budget: which source has which part in a parameter's variance, and what interval follows.

``sources``    the sources by name, and the estimates that their sizes rest on
``rows``       the variance of every whitened row of a fit, split by source
``triads``     through the fit's gain: the variance of k, E and D, split by source
``outside``    what a fit does not know: latitude, time base, temperature
``budget``     combined, with degrees of freedom and coverage factor (GTC)

A fit is Gauss-Newton on whitened rows ``r``, each of variance one: the estimate moves by ``G r`` with
``G = P J'`` (P the covariance, J the Jacobian), so that the covariance is ``sum over rows G_row G_row'``. Each
row's part belongs to the source of that row, and where its variance has several, to these as they share it.
"""
