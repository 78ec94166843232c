"""Results of measurements, for people and files.

`campaign_results` makes the results of a campaign: `solution_json`, `verdict`, `report` and `diagnosis`.
`history`, `resolve`, `fixtures` and `certificate` follow from stored results. `plan_inputs`
and `plan_document` plan the next campaign. Report, history, plan and certificate are typed values, made once;
text, page and JSON lay them out. `result_formats` describes every file.
"""
