"""From bytes to accepted steps on the disk: decoding with gaps seen, cutting, writing, hashing."""
