"""A guided campaign and its folder.

`readiness` and `port_check` come before it; `campaign_start` begins or resumes it, `live_campaign`
drives it. `checklist` and `sequential_campaign` say which step comes next; `folder_recorder` writes accepted
steps, `accepted_steps` is what they leave for later ones; `verdict` is the end.
"""
