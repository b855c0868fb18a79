"""Properties that every space, group, problem and method has: checks of one's own.

Each check raises `AssertionError` with a sentence that says what does not hold, and by how much.
"""

from .groups import check_group
from .methods import check_method
from .problems import check_problem
from .spaces import check_space
from .watchers import check_watcher

__all__ = ["check_group", "check_method", "check_problem", "check_space", "check_watcher"]
