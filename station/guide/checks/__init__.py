"""Is it done well: `face_and_stillness` judges each second, `cube_tracking` and `cube_pose` follow the cube.

The limits of motion at rest are those of `station.stream.live.stillness`.
`dwell_attempt` collects the accepted seconds of a dwell, `seating` compares how the cube sits with earlier dwells,
`turn_closure` says whether turns agree, `transfers` whether samples lead from one placement to the next.
"""
