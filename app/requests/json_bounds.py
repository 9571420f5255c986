"""Bounds on a JSON text's depth and size, checked before anything is built from it.

Eight megabytes of `[],[],` would become 2.8 million lists, and of `[[[[` a stack overflow.
"""

import re

VALUES_MAX = 500_000
DEPTH_MAX = 50

_TOO_MANY = f"it has more than {VALUES_MAX} values"
# A string that never ends runs to the end, so that the search stays linear.
_STRING = re.compile(rb'"[^"\\]*+(?:\\.[^"\\]*+)*+"?', re.DOTALL)
_BRACKET = re.compile(rb"[][{}]")


def beyond_bounds(body: bytes) -> str | None:
    """What is too much, with the cap; None when nothing is."""
    # Each value has two strings at most, its name and itself: cheaper to count than to find.
    if body.count(b'"') - body.count(b'\\"') > 4 * VALUES_MAX:
        return _TOO_MANY
    outside_strings = _STRING.sub(b"", body)
    # A value follows each comma and each opening bracket, if not the bracket's end.
    values = sum(outside_strings.count(mark) for mark in (b",", b"[", b"{"))
    if values > VALUES_MAX:
        return _TOO_MANY
    depth = 0
    for bracket in _BRACKET.findall(outside_strings):
        depth += 1 if bracket in b"[{" else -1
        if depth > DEPTH_MAX:
            return f"it is nested more than {DEPTH_MAX} deep"
    return None
