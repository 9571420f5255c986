"""The views last asked for, kept so that a page that draws one again needn't wait."""

from collections import OrderedDict

MOST_BYTES = 64 * 2**20


class ViewCache:
    """Bytes by the ETag that names them; those asked for longest ago go first.

    Of the event loop alone.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._held_bytes = 0
        self._views: OrderedDict[str, bytes] = OrderedDict()

    def get(self, tag: str) -> bytes | None:
        """None where it isn't held."""
        if tag in self._views:
            self._views.move_to_end(tag)
        return self._views.get(tag)

    def keep(self, tag: str, view: bytes) -> None:
        """Unless it is larger than all there may be."""
        if len(view) > self._most_bytes:
            return
        self._held_bytes += len(view) - len(self._views.pop(tag, b""))
        self._views[tag] = view
        while self._held_bytes > self._most_bytes:
            _, dropped = self._views.popitem(last=False)
            self._held_bytes -= len(dropped)
