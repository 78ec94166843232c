"""A camera as a port of bytes: JPEG images, each a part of a multipart/x-mixed-replace stream.

docs/how-to/camera.md describes it.
"""

from drivers.camera.decoder import CameraDecoder, CameraImage

__all__ = ["CameraDecoder", "CameraImage"]
