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
from slewtrack.client import (
    BadAnswer as BadAnswer,
)
from slewtrack.client import (
    Cancelled as Cancelled,
)
from slewtrack.client import (
    Columns as Columns,
)
from slewtrack.client import (
    Job as Job,
)
from slewtrack.client import (
    NoAnswer as NoAnswer,
)
from slewtrack.client import (
    NotFinished as NotFinished,
)
from slewtrack.client import (
    Plan as Plan,
)
from slewtrack.client import (
    Problem as Problem,
)
from slewtrack.client import (
    Progress as Progress,
)
from slewtrack.client import (
    Refused as Refused,
)
from slewtrack.client import (
    ServiceError as ServiceError,
)
from slewtrack.here import calls_here as _here

if TYPE_CHECKING:
    from slewtrack.client import AsyncClient as AsyncClient
    from slewtrack.client import Client as Client

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
