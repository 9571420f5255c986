"""The ids and the states of what is stored."""

import secrets
import time
import uuid
from typing import Literal, get_args

JobState = Literal["queued", "running", "done", "refused", "failed", "cancelled"]
STATES: tuple[JobState, ...] = get_args(JobState)
OPEN_STATES: tuple[JobState, ...] = ("queued", "running")


def new_id() -> str:
    """A UUID of version 7 (RFC 9562, section 5.7): later ones sort after earlier ones."""
    since_1970_ms = time.time_ns() // 1_000_000
    bits = since_1970_ms << 80 | 0x7 << 76 | secrets.randbits(12) << 64
    return str(uuid.UUID(int=bits | 0b10 << 62 | secrets.randbits(62)))


def is_id(text: str) -> bool:
    try:
        return str(uuid.UUID(text)) == text
    except ValueError:
        return False
