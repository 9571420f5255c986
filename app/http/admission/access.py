"""API keys and their scopes, checked for each request.

Open only between processes of this machine: both ends of the connection on loopback, nothing
that says a proxy passed it on, a Host of ours, and no web page behind it.  All else needs a key,
which is found at a cost that wrong secrets can't drive up.
"""

import asyncio
import ipaddress
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from http import HTTPStatus

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import Scope

from app.http.admission.limits import RateLimit
from app.store.api_keys import Key, KeyScope, digest

# They say what is in the repository, not what the installation holds; and a browser that opens
# a page can't send a key.
PAGES = frozenset({"/", "/docs", "/redoc", "/openapi.json"})
PAGE_FILES = "/page-files/"
BUILT_FILES = "/assets/"
# First parts of the planner's page's own addresses (web/src/rooms.ts).
PAGE_ROOMS = frozenset(
    {"plans", "timeline", "horizon", "spacecraft", "campaigns", "flights", "telemetry"}
)
PROBES = frozenset({"/healthz", "/readyz"})
# What proxies add; of X-Forwarded-..., whatever they call it.
PASSED_ON = ("forwarded", "via", "x-real-ip", "cf-connecting-ip", "true-client-ip")
PASSED_ON_PREFIX = "x-forwarded-"


@dataclass(frozen=True, kw_only=True)
class Caller:
    """Whom limits count: a key, or an address without one."""

    name: str
    key: Key | None


LIST_AGE_MAX_S = 1.0

FindKey = Callable[[str], Awaitable[Key | None]]
ListDigests = Callable[[], Awaitable[frozenset[str]]]


class KeyLookup:
    """Keys as the database has them.

    Within its failures a minute each secret of an address is looked up in the database.  Beyond
    them only one that a list of all good keys knows, which is read once a second at most: a good
    key is answered however many wrong ones come from the same address, and a revoked one never.

    find_key: the good key of a secret.  list_digests: those of all good keys.
    """

    def __init__(
        self,
        find_key: FindKey,
        list_digests: ListDigests,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._find_key = find_key
        self._list_digests = list_digests
        self._clock_s = clock_s
        self._digests: frozenset[str] = frozenset()
        self._listed_s = float("-inf")
        self._listing = asyncio.Lock()

    async def find(self, secret: str, *, sparing: bool) -> Key | None:
        """The good key; sparing: look only for what may be one."""
        if sparing and digest(secret) not in await self._good():
            return None
        return await self._find_key(secret)

    async def _good(self) -> frozenset[str]:
        async with self._listing:
            now_s = self._clock_s()
            if now_s - self._listed_s >= LIST_AGE_MAX_S:
                self._listed_s = now_s  # also when it fails: a sick database isn't asked on and on
                self._digests = await self._list_digests()
            return self._digests


class Access:
    """Decides by the connection and the head of a request.

    origins: whose web pages may ask as programs of this machine do.
    failures_per_minute: of one address; more cost the others nothing.
    """

    def __init__(
        self,
        keys: KeyLookup,
        *,
        require_keys: bool,
        hosts: tuple[str, ...],
        origins: frozenset[str] = frozenset(),
        failures_per_minute: int,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._keys = keys
        self._require_keys = require_keys
        self._hosts = frozenset(host.lower() for host in hosts)
        self._origins = origins
        self._failures = RateLimit(
            "{per_minute} requests a minute from one address may come without a good key, and "
            "more did; one with a good key is answered all the same, others again in {wait_s} s",
            clock_s,
        )
        self._failures_per_minute = failures_per_minute

    async def caller(self, scope: Scope, address: str) -> Caller:
        """Who asks; raises 401, 403, 421 or, where too many came without a good key, 429."""
        most, failed = self._failures_per_minute, False
        if may_fail := self._failures.has_room(address, most):
            self._failures.charge(address, most)  # at once, so that many at a time don't look, too
        try:
            return await self._caller(scope, address, sparing=not may_fail)
        except HTTPException as refusal:
            failed = refusal.status_code == HTTPStatus.UNAUTHORIZED
            if failed and not may_fail:
                self._failures.charge(address, most)
            raise
        finally:
            if may_fail and not failed:
                self._failures.give_back(address, most)

    async def _caller(self, scope: Scope, address: str, *, sparing: bool) -> Caller:
        headers = Headers(scope=scope)
        secret = _bearer(headers)
        if secret is not None:
            key = await self._key(secret, scope, sparing=sparing)
            return Caller(name=f"key {key.id}", key=key)
        anonymous = Caller(name=f"address {address}", key=None)
        if not is_page(scope):
            self._require_open(scope, headers)
        return anonymous

    async def _key(self, secret: str, scope: Scope, *, sparing: bool) -> Key:
        key = await self._keys.find(secret, sparing=sparing)
        if key is None:
            raise _unauthorized("this API key is unknown or revoked", ', error="invalid_token"')
        needed = scope_needed(scope["method"], scope["path"])
        if not key.may(needed):
            raise HTTPException(
                HTTPStatus.FORBIDDEN,
                f"this needs a key with the scope {needed}; this one has {', '.join(key.scopes)}",
            )
        return key

    def _require_open(self, scope: Scope, headers: Headers) -> None:
        if self._require_keys or not all(_is_here(scope.get(end)) for end in ("client", "server")):
            raise _unauthorized(
                "send an API key: Authorization: Bearer ...; `slewtrack keys create` makes one"
            )
        if any(name in PASSED_ON or name.startswith(PASSED_ON_PREFIX) for name in headers):
            raise _unauthorized(
                "this request was passed on by a proxy, so it needs an API key: "
                "Authorization: Bearer ..."
            )
        host = headers.get("host", "")
        if _name_of(host) not in self._hosts:
            raise HTTPException(
                HTTPStatus.MISDIRECTED_REQUEST,
                f"without a key this service answers to {', '.join(sorted(self._hosts))} only, "
                "which the Host header doesn't name; SLEWTRACK_ALLOWED_HOSTS adds names",
            )
        if headers.get("origin", "").lower() in self._origins:
            return
        if not _from_no_other_site(scope, headers, host):
            raise HTTPException(
                HTTPStatus.FORBIDDEN,
                "web pages of other sites may not use this service; SLEWTRACK_ALLOWED_ORIGINS "
                "names those that may",
            )


def scope_needed(method: str, path: str) -> KeyScope:
    if path.startswith("/v1/audit"):
        return "admin"
    return "read" if method in ("GET", "HEAD") else "write"


def is_page(scope: Scope) -> bool:
    """Documentation and the planner's page without what it asks: the same for everyone."""
    path: str = scope["path"]
    is_one = (
        path in PAGES
        or path.startswith((PAGE_FILES, BUILT_FILES))
        or path.removeprefix("/").split("/")[0] in PAGE_ROOMS
    )
    return scope["method"] in ("GET", "HEAD") and is_one


def is_loopback(host: str) -> bool:
    """Whether what listens there can be reached from this machine only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _bearer(headers: Headers) -> str | None:
    given = headers.get("authorization")
    if given is None:
        return None
    kind, _, secret = given.partition(" ")
    if kind.lower() != "bearer" or not secret.strip():
        raise _unauthorized("the Authorization header must hold an API key: Bearer ...")
    return secret.strip()


def _unauthorized(detail: str, error: str = "") -> HTTPException:
    """How to send a key, and as `error` what is wrong with the one sent: RFC 6750."""
    challenge = f'Bearer realm="slewtrack"{error}'
    return HTTPException(HTTPStatus.UNAUTHORIZED, detail, {"WWW-Authenticate": challenge})


def _is_here(end: tuple[str, int | None] | None) -> bool:
    """A name or nothing is no network's: a Unix socket, or a client in this process."""
    if end is None:
        return True
    try:
        return ipaddress.ip_address(end[0]).is_loopback
    except ValueError:
        return True


def _name_of(host: str) -> str:
    """Without the port: `[::1]:8000` is `[::1]`."""
    name, colon, port = host.rpartition(":")
    return (name if colon and port.isdecimal() else host).lower()


def _from_no_other_site(scope: Scope, headers: Headers, host: str) -> bool:
    """A browser says who asks; other clients say nothing."""
    origin = headers.get("origin")
    if origin is not None and origin.partition("://")[2].lower() != host.lower():
        return False
    if headers.get("sec-fetch-site", "none") in ("none", "same-origin"):
        return True
    # Following a link shows the answer to the user, never to the page with the link.
    return scope["method"] == "GET" and headers.get("sec-fetch-mode") == "navigate"
