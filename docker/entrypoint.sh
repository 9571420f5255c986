#!/bin/sh
# The root filesystem is read-only and compiled code must be where it can be added to.
set -eu
[ -d "$NUMBA_CACHE_DIR" ] || cp -r --preserve=timestamps /opt/slewtrack/compiled "$NUMBA_CACHE_DIR"
exec "$@"
