#!/bin/sh
# Does every kind of work run with what the image holds?  Fails the build otherwise.
set -eu
PATH=/opt/slewtrack/bin:$PATH
slewtrack plan examples/las_vegas_2015.json --export netcdf=/tmp/plan.nc
slewtrack plan examples/three_sessions.json
slewtrack windows examples/opportunities_sky.json
slewtrack campaign examples/campaign_cities.json
slewtrack horizon examples/horizon_estimate.json examples/horizon_ahead.png examples/horizon_right.png
slewtrack spacecraft examples/spacecraft_four_modes.json
