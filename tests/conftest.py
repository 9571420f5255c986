"""How do all tests run?"""

import atexit
import os
import tempfile

from hypothesis import settings

# The user's own data is no business of tests.
_data = tempfile.TemporaryDirectory(prefix="slewtrack-tests-")
atexit.register(_data.cleanup)
os.environ["SLEWTRACK_DATA_DIR"] = _data.name
# Starlette's test client calls itself "testserver".
os.environ["SLEWTRACK_ALLOWED_HOSTS"] = "localhost,127.0.0.1,[::1],testserver"

# A loaded machine is slow; slowness is measured in bench/, not asserted here.
settings.register_profile("slewtrack", deadline=None)
settings.load_profile("slewtrack")
