"""The horizon cameras a request may name."""

from estimator.camera import HorizonCamera
from estimator.request import MAX_CAMERAS


def require_cameras(field: str, cameras: tuple[HorizonCamera, ...]) -> None:
    """Raise ValueError unless there are one to sixteen, each with a name of its own."""
    if not 1 <= len(cameras) <= MAX_CAMERAS:
        raise ValueError(f"{field} must hold 1 to {MAX_CAMERAS} of them, not {len(cameras)}")
    names = [camera.name for camera in cameras]
    if len(set(names)) < len(names):
        raise ValueError(f"{field} need names of their own, not {names}")
