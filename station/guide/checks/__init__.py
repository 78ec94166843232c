"""Is it done well: `face_and_stillness` judges each second (its limits of motion:
`station.stream.live.stillness`), `cube_tracking` and `cube_pose` follow the cube.

`dwell_attempt` collects the accepted seconds of a dwell, `seating` compares how the cube sits with earlier dwells,
`turn_closure` says whether turns agree, `transfers` whether samples lead from one placement to the next.
"""
