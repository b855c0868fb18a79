"""What is private to numba, all of it that geomint uses: other files use what numba's extensions do.

Those have types, data models, signatures, ``lower_builtin``, ``cgutils``, `numba.extending` and errors.
What is here may change with each version of numba: `tests/kernels/test_numba_inside.py` names each
name, so that one that is missing is told. What is not here is how numba's functions are called:
`geomint.kernels.compiling.call` does so before numba is there.

Functions that are linked into others stay LLVM's code. numba optimises every function when it is
compiled and makes machine code of it, also of those that are only linked into the code of a caller,
where both is done once more: half of the time that compiling took. A library here does so when an
address or its object code is asked for.
"""

import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult
from numba.core.compiler_lock import global_compiler_lock
from numba.core.ir_utils import _add_alias as add_alias, alias_analysis_extensions
from numba.core.registry import cpu_target
from numba.core.serialize import dumps
from numba.core.typeconv.rules import default_type_manager
from numba.core.typing.templates import make_intrinsic_template
from numba.core.typing.typeof import Purpose, typeof

__all__ = [
    "add_alias", "alias_analysis_extensions", "default_type_manager", "global_compiler_lock",
    "make_intrinsic_template",
]  # fmt: skip

PASSES = 2  # over linked code: what one inlines the next simplifies; steps on SO(n) gain 15 %
_njit: Any = numba.njit


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
    with global_compiler_lock:
        codegen = cpu_target.target_context.codegen()
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


def compiled(function: Callable[..., Any], signature, **options):
    """Return what numba makes of a function for a signature."""
    dispatcher = _njit(**options)(function)
    dispatcher.compile(signature)
    return dispatcher.overloads[signature.args]


def address_of(result) -> int:
    """Return where the machine code of a result begins."""
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


def packed(result) -> bytes | None:
    """Return a result as bytes; None if it holds addresses of this process."""
    return None if result.library.has_dynamic_globals else dumps(result._reduce())


def unpacked(content: bytes):
    """Return a result again. Nothing of what numba knows about types is needed, nor imported."""
    return CompileResult._rebuild(cpu_target.target_context, *pickle.loads(content))


def machine() -> tuple[Any, ...]:
    """Return what machine code depends on beside its source: the processor and its features."""
    return tuple(cpu_target.target_context.codegen().magic_tuple())


def dispatcher_of(function, tell: Callable[[tuple[Any, ...]], None], **options):
    """Return a dispatcher that tells the types of what it is called with in other compiled code."""
    dispatcher = _njit(**options)(function)
    template = dispatcher.get_call_template

    def told(args, kws):
        tell((*args, *dict(kws).values()))
        return template(args, kws)

    dispatcher.get_call_template = told
    return dispatcher


def templates_of(value) -> tuple[Any, ...] | None:
    """Return what numba has for a function or another value by its identity; None if nothing."""
    context = cpu_target.typing_context
    context.refresh()
    found = context._lookup_global(value)
    return found if found is None else tuple(getattr(found, "templates", ()))


def source_of(template):
    """Return the function that an overload, an intrinsic or another template is made of."""
    of = vars(template)
    function = of.get("_overload_func") or of.get("_definition_func") or of.get("generic")
    return getattr(function, "__func__", function)


def function_in(value):
    """Return the function in a dispatcher or an intrinsic; None if there is none."""
    return getattr(value, "py_func", None) or getattr(value, "_defn", None)


def has_type(value) -> bool:
    """Tell whether a value can be a constant of compiled code."""
    try:
        return typeof(value, Purpose.constant) is not None
    except Exception:  # whatever an unknown object makes of it
        return False
