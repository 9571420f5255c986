"""Is uvicorn still inside as our protocol expects, which overrides what uvicorn keeps private?"""

import ast
import inspect
import tomllib
from importlib.metadata import version
from pathlib import Path

import uvicorn
from packaging.requirements import Requirement
from uvicorn.protocols.http import flow_control, h11_impl

from app.http.door import protocol

PROJECT = Path(__file__).parents[2] / "pyproject.toml"
BASE, CYCLE = h11_impl.H11Protocol, h11_impl.RequestResponseCycle


def test_the_release_is_one_this_was_tested_with():
    wanted = tomllib.loads(PROJECT.read_text())["project"]["dependencies"]
    [ours] = [one for one in map(Requirement, wanted) if one.name == "uvicorn"]
    major, minor, *_ = map(int, version("uvicorn").split("."))
    assert version("uvicorn") in ours.specifier
    assert f"{major}.{minor + 1}.0" not in ours.specifier


def attributes_set_by(cls: type) -> set[str]:
    """Those of `self` that its methods assign, and the methods."""
    tree = ast.parse(inspect.getsource(cls))
    return {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
    } | set(vars(cls))


def attributes_used_of(owner: str, cls: type) -> set[str]:
    """What our protocol reads and calls of `self.<owner>`."""
    tree = ast.parse(inspect.getsource(cls))
    return {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == owner
    }


def test_what_our_protocol_uses_is_there():
    ours = protocol.GuardedProtocol
    own = attributes_set_by(ours) | set(ours.__annotations__)
    assert attributes_used_of("self", ours) - own <= attributes_set_by(BASE)
    assert attributes_used_of("self.cycle", ours) <= attributes_set_by(CYCLE)
    assert attributes_used_of("self.flow", ours) <= attributes_set_by(flow_control.FlowControl)
    assert attributes_used_of("super()", ours) <= set(vars(BASE)) | {"__init__"}


def test_what_our_protocol_overrides_is_called():
    """Those without an underscore, but for what connections.py asks of it, are uvicorn's."""
    asked = {"waits_for_client", "unsent_bytes", "give_way", "has_key", "network", "is_let_in"}
    public = {name for name in vars(protocol.GuardedProtocol) if not name.startswith("_")}
    assert public - asked <= set(vars(BASE)) | set(protocol.GuardedProtocol.__annotations__)
    source = inspect.getsource(BASE)
    assert source.count("self.send_400_response(") == 1
    assert "on_response=self.on_response_complete" in source
    assert '"state": self.app_state.copy()' in source
    assert "self.flow.write_paused" in inspect.getsource(CYCLE.send)


def test_the_server_stops_as_ours_expects():
    assert inspect.iscoroutinefunction(uvicorn.Server.shutdown)
    assert "self.shutdown(" in inspect.getsource(uvicorn.Server)
