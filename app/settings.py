"""Settings of the service, from `SLEWTRACK_*` environment variables."""

import os
import re
from pathlib import Path

from pydantic import Field, ValidationError, field_validator
from pydantic_core import PydanticCustomError
from pydantic_settings import BaseSettings, SettingsConfigDict

from app.log.logs import LogFormat, LogLevel
from planner.base.errors import InvalidInput


def _user_data_dir() -> Path:
    """Where the XDG base directory specification has a user's data."""
    home = os.environ.get("XDG_DATA_HOME")
    return (Path(home) if home else Path.home() / ".local" / "share") / "slewtrack"


_ORIGIN = re.compile(r"https?://(?:\[[0-9a-f:]+\]|[a-z0-9.-]+)(?::\d{1,5})?")  # RFC 6454


class Settings(BaseSettings):
    """Read once, when the service starts."""

    model_config = SettingsConfigDict(env_prefix="SLEWTRACK_", frozen=True)

    data_dir: Path = Field(
        default_factory=_user_data_dir,
        description="Where the SQLite database is kept; default: ~/.local/share/slewtrack",
    )
    database_url: str = Field(
        default="",
        repr=False,  # it may hold a password
        description="postgresql+psycopg://USER:PASSWORD@HOST/NAME in place of SQLite",
    )

    workers: int = Field(
        default_factory=lambda: os.cpu_count() or 1,
        gt=0,
        description="Solves at a time, each in a process of its own; default: the processors",
    )
    dask_scheduler: str = Field(
        default="",
        description="tcp://HOST:PORT or tls://HOST:PORT of a Dask scheduler: then `workers` solves "
        "at a time run on its workers, not here",
    )
    queue_max: int = Field(
        default=1000, ge=0, description="Most plans that wait to be worked on; 503 beyond"
    )
    job_deadline_s: float = Field(
        default=300.0, gt=0.0, description="Processor time after which a solve is killed; then 422"
    )
    job_attempts: int = Field(
        default=3, gt=0, description="How often a job is begun whose process died at it"
    )
    lease_s: float = Field(
        default=15.0,
        ge=1.0,
        description="Time after which others take up the jobs of a service that died",
    )
    retention_days: float | None = Field(
        default=None,
        gt=0.0,
        description="Delete what finished so many days ago; default: keep everything",
    )

    # Seven times NASA's 15-day OEM of the ISS in XML.
    max_body_bytes: int = Field(
        default=8 * 2**20, gt=0, description="Most bytes of a JSON request; 413 beyond"
    )
    # Sixteen uncompressed grey images of 4 megapixels; a child gets them a second time.
    max_upload_bytes: int = Field(
        default=64 * 2**20, gt=0, description="Most bytes of a request with images; 413 beyond"
    )
    max_held_bytes: int = Field(
        default=512 * 2**20,
        gt=0,
        description="Most bytes of all bodies at work together; 503 beyond",
    )
    body_timeout_s: float = Field(
        default=60.0, gt=0.0, description="Time a request's whole body may take to come; then 408"
    )
    head_timeout_s: float = Field(
        default=10.0, gt=0.0, description="Time a request's head may take to come; then 408"
    )
    write_timeout_s: float = Field(
        default=30.0,
        gt=0.0,
        description="Time in which a client must take something of its answer; else it is cut off",
    )
    # Eight of the longest tables.
    max_unsent_bytes: int = Field(
        default=256 * 2**20,
        gt=0,
        description="Most bytes of all answers that clients have yet to take; the slowest are cut "
        "off beyond",
    )
    max_connections: int = Field(
        default=512, gt=0, description="Most connections at a time; 503 beyond"
    )

    require_keys: bool = Field(
        default=False,
        description="Ask for an API key on loopback, too; set it behind a reverse proxy",
    )
    allowed_hosts: str = Field(
        default="localhost,127.0.0.1,[::1]",
        description="Names in the Host header that are answered without a key; 421 for others",
    )
    allowed_origins: str = Field(
        default="",
        description="Origins such as https://planner.example whose web pages may use the service "
        "(CORS), separated by commas; a key is needed as without",
    )
    trusted_proxies: str = Field(
        default="",
        description="Addresses or networks of proxies whose X-Forwarded-For is believed, "
        "separated by commas",
    )
    rate_per_minute: int = Field(
        default=6000, gt=0, description="Most requests a minute per key, or per address; then 429"
    )
    failures_per_minute: int = Field(
        default=60,
        gt=0,
        description="Most requests a minute and address without a good key; then 429, but for "
        "good keys",
    )
    concurrency_per_key: int = Field(
        default=64, gt=0, description="Most requests at a time per key, or per address; then 429"
    )

    stapi_products: Path | None = Field(
        default=None,
        description="A JSON file of products that STAPI offers at /stapi; default: no STAPI",
    )

    log_level: LogLevel = Field(default="info", description="debug, info, warning or error")
    log_format: LogFormat = Field(default="console", description="json or console")

    @field_validator("allowed_origins")
    @classmethod
    def _require_origins(cls, text: str) -> str:
        if not all(map(_ORIGIN.fullmatch, _words(text))):
            raise PydanticCustomError(
                "origin",
                "Each must be an origin such as https://planner.example:8443, without a path",
            )
        return text

    @property
    def origins(self) -> frozenset[str]:
        """Of pages that may use the service."""
        return frozenset(_words(self.allowed_origins))


def _words(text: str) -> list[str]:
    """In a list with commas, in lower case."""
    return [word for part in text.split(",") if (word := part.strip().lower())]


def settings_of_environment() -> Settings:
    """Raises InvalidInput, which names the variable."""
    try:
        return Settings()
    except ValidationError as error:
        fault = error.errors()[0]
    (name,) = fault["loc"]
    detail = fault["msg"][0].lower() + fault["msg"][1:]
    raise InvalidInput(f"{detail}, not {fault['input']!r}", field=f"SLEWTRACK_{name}".upper())
