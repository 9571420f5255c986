"""What can the operator set, by `SLEWTRACK_*` environment variables?"""

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict


class Settings(BaseSettings):
    """Read once, when the service starts."""

    model_config = SettingsConfigDict(env_prefix="SLEWTRACK_", frozen=True)

    # Seven times NASA's 15-day OEM of the ISS in XML.
    max_body_bytes: int = Field(default=8 * 2**20, gt=0)
    # Sixteen uncompressed grey images of 4 megapixels; a child gets them a second time.
    max_upload_bytes: int = Field(default=64 * 2**20, gt=0)
