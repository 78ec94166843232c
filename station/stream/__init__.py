"""A live device as a stream.

`reader` is a process that reads and records bytes; `live.live_feed` decodes them (`recorder.sample_stream`) and
watches the stream; `recorder` writes accepted steps and plain recordings. `gnss_feed`, `camera` and `wheel` are
read alongside (`auxiliary`); `replay` makes devices of recordings; `stream_events` says what happened.
"""
