"""slewtrack from Python: plans made in this process, or by a running service.

    plan = slewtrack.next_pass(Path("examples/my_city.json"))
    print(plan, plan.table["alpha_deg"])

`Client` and `AsyncClient` ask a running service, which keeps what it makes.  The functions here
have the same names, take the same and answer the same, in this process, which keeps the last
thousand plans while it runs; `spacecraft` has those of the imaging spacecraft.  What can't be
read or flown raises `Refused`; its `problem` names the field, the limit and the ways out.
"""

from typing import TYPE_CHECKING

from slewtrack import client as _client
from slewtrack.here import calls_here as _here

if TYPE_CHECKING:
    from slewtrack.client import AsyncClient as AsyncClient
    from slewtrack.client import Client as Client

BadAnswer = _client.BadAnswer
Cancelled = _client.Cancelled
Columns = _client.Columns
Job = _client.Job
NoAnswer = _client.NoAnswer
NotFinished = _client.NotFinished
Plan = _client.Plan
Problem = _client.Problem
Progress = _client.Progress
Refused = _client.Refused
ServiceError = _client.ServiceError

campaign = _here.campaign
check = _here.check
compare = _here.compare
delete = _here.delete
request = _here.request
submit = _here.submit
wait = _here.wait
draw_comparison = _here.draw_comparison
estimate_vertical = _here.estimate_vertical
export = _here.export
export_campaign = _here.export_campaign
fly = _here.fly
get = _here.get
next_pass = _here.next_pass
opportunities = _here.opportunities
places = _here.places
plan = _here.plan
platforms = _here.platforms
spacecraft = _here.spacecraft
stars = _here.stars
table = _here.table
view = _here.view

_public = {name for name in globals() if not name.startswith("_")}
__all__ = sorted(_public - {"TYPE_CHECKING", "client", "here"} | {"AsyncClient", "Client"})


def __dir__() -> list[str]:
    return __all__


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"slewtrack has no {name}")
    return getattr(_client, name)
