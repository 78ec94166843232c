"""What is done now: `guide` hands each second of the stream to one `stage`, which returns the next stage.

In the order of a campaign: `unit_recognition_stage`, `warm_up_stage`, `placement_stage`, then `dwell_stage`,
`monitor_stage` or `turn_stage`, and placement again. `stage_context` holds what all stages share.
"""
