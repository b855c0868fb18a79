"""Scenes: what is integrated, from where, for how long, how, and what is watched."""

import lazy_loader

# An unknown scene name is reported before anything that imports numpy.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
