"""A live stream as blocks of a second.

`live_feed` cuts the stream into blocks and watches it (`stream_trouble`: silent channels, power cycles, counters);
`stillness` judges whether the unit rests; `rotation_detection` finds a manual rotation between two rests.
"""
