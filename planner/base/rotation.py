"""SciPy's `Rotation`, loaded when the first one is made.

Its package takes 0.15 s, for which who only reads a request needn't wait.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation as Rotation
else:

    class _OnFirstUse(type):
        def __getattr__(cls, name: str) -> Any:  # noqa: ANN401 (as Python calls it)
            from scipy.spatial import transform

            return getattr(transform.Rotation, name)

    class Rotation(metaclass=_OnFirstUse):
        """Makes SciPy's by each of its class methods, and names them in annotations."""
