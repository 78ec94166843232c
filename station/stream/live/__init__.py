"""A live stream as seconds: blocks with their noise, stillness, turns, and from accepted blocks to samples."""
