"""Reports of a campaign, and the noise of channels (`noise/1`), each as a page with its figures.

`report` is put together from `result_tables` and draws the residuals; `noise_document` and `noise_page`
show noise; `svg` draws every figure.
"""
