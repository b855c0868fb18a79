"""Structure-preserving integration on Lie groups and constraint manifolds.

Importing geomint imports neither numba nor matplotlib: both come when they are needed.
"""

import lazy_loader

__version__ = "0.1.0"

# The public names are listed in __init__.pyi and imported when they are first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
