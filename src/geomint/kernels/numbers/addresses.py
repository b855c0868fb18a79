"""Functions behind their addresses: what takes a stepper of any kind is compiled once for all kinds.

numba's functions as arguments have their signature in their type, and so has whatever takes them. Here
they lie in memory, and are given their types where they are called.
"""


def function_at(addresses, place: int, kind: str):
    """Return one of several functions, which is of that kind; in plain Python they are a tuple."""
    return addresses[place]


def functions_at(addresses, kind: str):
    """Return all but the first, a stepper of that kind, which takes them."""
    return addresses[1:]
