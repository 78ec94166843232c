"""A diagnosis as a document, as text and as a page: `diagnosis/2`.

`model_refinement` solves and diagnoses; `diagnosis_json` writes it (`uncalibrated`, `unsolvable_campaign`: where
nothing is solved); `proposed_terms` and `next_measurements` add to it; `diagnosis_wording`, `diagnosis_text`,
`diagnosis_html` and `finding_figure` show it. `means_document` is the calibration by a table of means, in the
words of `station.results.means_wording`.
"""
