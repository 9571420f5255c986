#!/bin/sh
# Does every kind of work run with what the image holds?  Fails the build otherwise.
set -eu
PATH=/opt/slewtrack/bin:$PATH
slewtrack plan examples/las_vegas_2015.json --export netcdf=/tmp/plan.nc
slewtrack plan examples/three_sessions.json --plot /tmp/plan.pdf
slewtrack fly examples/las_vegas_2015.json --runs 8 --plot /tmp/flights.png
slewtrack compare examples/las_vegas_2015.json examples/las_vegas_telemetry.csv --plot /tmp/telemetry.svg
slewtrack windows examples/opportunities_sky.json
slewtrack campaign examples/campaign_cities.json
slewtrack windows examples/opportunities_smallsat.json
slewtrack campaign examples/campaign_smallsat.json
slewtrack horizon examples/horizon_estimate.json examples/horizon_ahead.png examples/horizon_right.png
slewtrack spacecraft examples/spacecraft_four_modes.json

# The service, a scheduler and a worker: one plan by HTTP, and the page.
scheduler=tcp://127.0.0.1:18786
dask scheduler --no-dashboard --dashboard-address 127.0.0.1:0 --host 127.0.0.1 --port 18786 &
processes=$!
slewtrack worker --scheduler $scheduler --solves 1 &
processes="$! $processes"
SLEWTRACK_DATA_DIR=/tmp/served SLEWTRACK_DASK_SCHEDULER=$scheduler slewtrack serve --port 18000 &
processes="$! $processes"
# The service ends first, and what it asks afterwards.
trap 'for process in $processes; do kill $process && wait $process || true; done' EXIT
python3 -c 'import psycopg; assert psycopg.pq.__impl__ == "binary"'
python3 - examples/las_vegas_2015.json <<'ASK'
import sys
from pathlib import Path
from urllib.request import urlopen

import slewtrack

# It asks again until there is one, however slow the machine that builds.
with slewtrack.Client("http://127.0.0.1:18000", patience_s=300) as client:
    plan = client.plan(Path(sys.argv[1]).read_bytes())
print(plan.state, len(plan.table.t_s), "rows over HTTP, solved by a worker")
assert b"<script" in urlopen("http://127.0.0.1:18000/").read(), "the page isn't in the image"
ASK
