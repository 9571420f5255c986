"""Our protocol asks of uvicorn only what it offers to all, so that its updates can be installed."""

import ast
import asyncio
import inspect
import re
import tomllib
from pathlib import Path

import uvicorn
from packaging.requirements import Requirement

from app.http.admission import protocol
from app.http.serving import server
from app.settings import Settings

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


def test_no_later_release_is_kept_out():
    wanted = tomllib.loads(PROJECT.read_text())["project"]["dependencies"]
    [ours] = [one for one in map(Requirement, wanted) if one.name == "uvicorn"]
    assert "99.0.0" in ours.specifier


def test_of_uvicorns_protocol_only_what_every_protocol_has_is_used():
    assert protocol.GuardedProtocol.__bases__ == (asyncio.Protocol,)
    tree = ast.parse(inspect.getsource(protocol))
    used = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and ast.unparse(node.value).endswith("_inner")
    }
    assert used
    assert used <= set(dir(asyncio.Protocol))


def test_it_is_made_as_uvicorn_makes_protocols(tmp_path):
    """By the documented option `http`, as its own is, which takes the same by name."""
    config = server("127.0.0.1", 0, Settings(data_dir=tmp_path)).config
    assert issubclass(config.http, protocol.GuardedProtocol)
    taken = inspect.signature(config.http.by_h11.__init__).parameters
    assert {"config", "server_state", "app_state"} <= set(taken)


def test_no_part_of_uvicorn_is_imported_by_its_file():
    """Its `__init__` has what it promises to keep."""
    for path in (PROJECT.parent / "app").rglob("*.py"):
        assert not re.search(r"^\s*(from|import) uvicorn\.", path.read_text(), re.MULTILINE), path


def test_the_server_stops_as_ours_expects():
    assert inspect.iscoroutinefunction(uvicorn.Server.shutdown)
    assert "self.shutdown(" in inspect.getsource(uvicorn.Server)
