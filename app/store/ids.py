"""The ids things are stored under."""

import secrets
import time
import uuid


def new_id() -> str:
    """A UUID of version 7 (RFC 9562, section 5.7): later ones sort after earlier ones."""
    since_1970_ms = time.time_ns() // 1_000_000
    bits = since_1970_ms << 80 | 0x7 << 76 | secrets.randbits(12) << 64
    return str(uuid.UUID(int=bits | 0b10 << 62 | secrets.randbits(62)))


def is_id(text: str) -> bool:
    """Whether it has the form of one."""
    try:
        return str(uuid.UUID(text)) == text
    except ValueError:
        return False
