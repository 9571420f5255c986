"""Names as people type them: whatever the case, accents and punctuation, the same key."""

import re
import unicodedata
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from difflib import get_close_matches

_NEAREST = 3
_ALIKE = 0.7  # of difflib's measure: one letter in four may be wrong
_APOSTROPHES = re.compile("['’‘ʻʼʿ`´]")
_NOT_IN_WORDS = re.compile(r"[\W_]+")


# How many more names may be answered with others like them: to look takes a hundredth of a second.
_LEFT: ContextVar[list[int] | None] = ContextVar("suggestions", default=None)


@contextmanager
def suggest_at_most(count: int) -> Iterator[None]:
    """Inside, only so many wrong names are answered with names like them."""
    token = _LEFT.set([count])
    try:
        yield
    finally:
        _LEFT.reset(token)


def may_suggest() -> bool:
    """Whether names like a wrong one may be looked for, which is counted."""
    left = _LEFT.get()
    if left is None:
        return True
    left[0] -= 1
    return left[0] >= 0


def key_of(name: str) -> str:
    """What a name is looked up by: `São Paulo` and `SAO-PAULO` are both `sao paulo`."""
    folded = unicodedata.normalize("NFKD", unicodedata.normalize("NFKD", name).casefold())
    letters = "".join(one for one in folded if not unicodedata.combining(one))
    return _NOT_IN_WORDS.sub(" ", _APOSTROPHES.sub("", letters)).strip()


def nearest_keys(key: str, known: Iterable[str]) -> list[str]:
    """The keys most like this one, the likest first; none where none is like it."""
    about_as_long = [one for one in known if abs(len(one) - len(key)) <= max(2, len(key) // 4)]
    return get_close_matches(key, about_as_long, _NEAREST, _ALIKE)
