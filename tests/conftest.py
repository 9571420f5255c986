"""How do all tests run?"""

from hypothesis import settings

# A loaded machine is slow; slowness is measured in bench/, not asserted here.
settings.register_profile("slewtrack", deadline=None)
settings.load_profile("slewtrack")
