"""Images as multipart/x-mixed-replace, the way ustreamer sends them."""

BOUNDARY = "boundarydonotcross"
CONTENT_TYPE = f"multipart/x-mixed-replace; boundary={BOUNDARY}"


def part(jpeg: bytes, stamp_s: float | None = None, age_s: float | None = None) -> bytes:
    """Return an image as a part; ``stamp_s`` is the sender's clock when it was taken, ``age_s`` how old it is."""
    fields = ["Content-Type: image/jpeg", f"Content-Length: {len(jpeg)}"]
    if stamp_s is not None:
        fields.append(f"X-Timestamp: {stamp_s:.6f}")
    if age_s is not None:
        fields.append(f"X-Age: {age_s:.6f}")
    return b"\r\n".join([b"--" + BOUNDARY.encode(), *(field.encode() for field in fields), b"", jpeg, b""])
