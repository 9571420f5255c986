"""How do all tests run?"""

import os

from hypothesis import settings

# Starlette's test client calls itself "testserver".
os.environ["SLEWTRACK_ALLOWED_HOSTS"] = "localhost,127.0.0.1,[::1],testserver"

# A loaded machine is slow; slowness is measured in bench/, not asserted here.
settings.register_profile("slewtrack", deadline=None)
settings.load_profile("slewtrack")
