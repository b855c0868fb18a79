"""Machine code of what is called alone: functions that are linked into others stay LLVM's code.

numba optimises every function when it is compiled and makes machine code of it, also of those that
are only linked into the code of a caller, where both is done once more: half of the time that compiling
took. A library here does so when an address or its object code is asked for.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

PASSES = 2  # over linked code: what one inlines the next simplifies; steps on SO(n) gain 15 %

# Of numba's own, not promised to anyone; without them functions are compiled as numba does.
_NEEDED = (
    "_finalize_final_module", "_optimize_final_module", "_get_compiled_object", "_ensure_finalized",
    "has_dynamic_globals",
)  # fmt: skip


class Linked(JITCodeLibrary):
    """A library of numba's whose machine code is made at need."""

    environments: ClassVar[dict[str, Any]] = {}  # where functions, by symbol, have constants
    _waits = False  # for machine code to be asked for

    @property
    def _at_once(self) -> bool:
        """Whether it is not to wait: numba's runtime, called by its names, and code from the disk."""
        return not self._object_caching_enabled or self._compiled_object is not None

    def _optimize_final_module(self) -> None:
        if self._at_once:
            super()._optimize_final_module()

    def _finalize_final_module(self) -> None:
        if self._at_once:
            super()._finalize_final_module()
        else:
            self._waits = self._finalized = True

    def _make(self) -> None:
        if not self._waits:
            return
        codegen: Any = self._codegen
        with global_compiler_lock:
            self._waits = False
            for _ in range(PASSES):
                super()._optimize_final_module()
            names = {variable.name for variable in self._final_module.global_variables}
            super()._finalize_final_module()
            for name in names & self.environments.keys():
                codegen.set_env(name, self.environments[name])

    def _defines(self, name: str) -> bool:
        try:
            return not self._final_module.get_function(name).is_declaration
        except NameError:
            return False

    def get_pointer_to_function(self, name: str):
        """Return the address of a function, 0 for one that is not here."""
        self._ensure_finalized()
        if self._waits and not self._defines(name):
            return 0
        self._make()
        return super().get_pointer_to_function(name)

    @property
    def has_dynamic_globals(self) -> bool:
        """Whether addresses of this process are left in the code when it has been optimised."""
        self._make()
        return bool(super().has_dynamic_globals)

    def _get_compiled_object(self):
        self._make()
        return super()._get_compiled_object()


@contextmanager
def linked() -> Iterator[None]:
    """Let what is compiled meanwhile be `Linked`; other threads compile before or after."""
    codegen = cpu_target.target_context.codegen()
    known = hasattr(codegen, "_library_class") and hasattr(codegen, "set_env")
    if not (known and all(hasattr(JITCodeLibrary, name) for name in _NEEDED)):
        yield
        return
    with global_compiler_lock:
        plain, set_env = codegen._library_class, codegen.set_env

        def set_later(name: str, environment) -> None:
            """Tell a function where its constants are, once it has an address."""
            Linked.environments[name] = environment
            if codegen._engine.is_symbol_defined(name):
                set_env(name, environment)

        codegen._library_class, codegen.set_env = Linked, set_later
        try:
            yield
        finally:
            codegen._library_class, codegen.set_env = plain, set_env
