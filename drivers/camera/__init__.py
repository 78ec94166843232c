"""A camera as a port of bytes: JPEG images, each a part of a multipart/x-mixed-replace stream.

`http_port` and `v4l2_port` give the stream, `decoder` its images by their markers (`jpeg`).
docs/how-to/camera.md describes it.
"""

from drivers.camera.decoder import CameraDecoder, CameraImage

__all__ = ["CameraDecoder", "CameraImage"]
