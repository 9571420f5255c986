"""The states of a job."""

from typing import Literal, get_args

JobState = Literal["queued", "running", "done", "refused", "failed", "cancelled"]
STATES: tuple[JobState, ...] = get_args(JobState)
OPEN_STATES: tuple[JobState, ...] = ("queued", "running")
