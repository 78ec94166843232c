"""A live device as a stream: read by a process of its own, journalled, watched, recorded, replayed."""
