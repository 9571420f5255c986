"""Text that a request may hold: short, and of visible characters only.

Names and ids end up in lists, file names, logs and terminals: a control character, an invisible
one or one that turns the direction of writing would make one look like another.
"""

import re
import unicodedata

CHARACTERS_MAX = 200
# Joiners, without which Persian and many Indian names can't be written.
_JOINERS = frozenset("\u200c\u200d")
_HIDDEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
_CONTROL_IN_MESSAGE = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff]")


def require_plain(text: str) -> str:
    """The text; ValueError for a name, id or time that is too long or not all visible."""
    if len(text) > CHARACTERS_MAX:
        raise ValueError(
            f"must have at most {CHARACTERS_MAX} characters, not {len(text)}; shorten it"
        )
    for place, character in enumerate(text):
        if _is_hidden(character):
            raise ValueError(_hidden_character(character, place))
    return text


def visible(text: str) -> str:
    """The text without what can't be seen, which files of some formats can't hold."""
    return "".join(character for character in text if not _is_hidden(character))


def _is_hidden(character: str) -> bool:
    return unicodedata.category(character) in _HIDDEN and character not in _JOINERS


def require_message(text: str) -> str:
    """The text; ValueError for what no CCSDS message may hold, however long it is."""
    if found := _CONTROL_IN_MESSAGE.search(text):
        raise ValueError(_hidden_character(found[0], found.start()))
    return text


def _hidden_character(character: str, place: int) -> str:
    return (
        f"must be plain text, but its character {place + 1} is U+{ord(character):04X}, which "
        "can't be seen; remove it"
    )
