"""A camera as a port of bytes: JPEG images, each a part of a multipart/x-mixed-replace stream; docs/camera.md."""

from drivers.camera.decoder import CameraDecoder, CameraImage

__all__ = ["CameraDecoder", "CameraImage"]
