"""What is private to numba is there, by name; and it stands in one file, of which this is the list."""

from __future__ import annotations

import ast
import operator
import pkgutil
import re
from pathlib import Path
from types import SimpleNamespace

import numba
import pytest

import geomint as gi
from geomint.kernels import numba_inside
from geomint.kernels.numbers.typing_lanes import insert_lane

NAMES = re.findall(r"\S+", """
numba.core.codegen:JITCodeLibrary numba.core.compiler:CompileResult._rebuild
numba.core.codegen:JITCodeLibrary._optimize_final_module numba.core.ir_utils:_add_alias
numba.core.codegen:JITCodeLibrary._finalize_final_module numba.core.typing.typeof:typeof
numba.core.codegen:JITCodeLibrary._get_compiled_object numba.core.registry:cpu_target
numba.core.codegen:JITCodeLibrary._ensure_finalized numba.core.serialize:dumps
numba.core.codegen:JITCodeLibrary.has_dynamic_globals numba.core.typing.typeof:Purpose.constant
numba.core.codegen:JITCodeLibrary.enable_object_caching numba.core.compiler:CompileResult
numba.core.compiler_lock:global_compiler_lock numba.core.ir_utils:alias_analysis_extensions
numba.core.typeconv.rules:default_type_manager.set_compatible
numba.core.typing.templates:make_intrinsic_template
codegen._library_class codegen.set_env codegen._engine.is_symbol_defined codegen.magic_tuple
library._object_caching_enabled library._compiled_object library._finalized library._codegen
library._final_module.global_variables library._final_module.get_function
library.get_pointer_to_function typing.refresh typing._lookup_global
dispatcher.compile dispatcher.overloads dispatcher.get_call_template dispatcher.py_func
result.library result.signature.args result.fndesc.llvm_func_name result._reduce
overload._overload_func intrinsic._definition_func intrinsic._defn
""")  # fmt: skip
OWN = {"_waits", "_make", "_at_once", "_defines"}
# Those of numba's modules that extensions use.
EXTENSIONS = r"numba(\.core(\.(types|errors|imputils|ir|typeconv|typing\.templates))?|\.extending)?"


@pytest.fixture(scope="module")
def objects() -> SimpleNamespace:
    """Objects of numba's, by the words that names begin with."""
    dispatcher, types = numba.njit(lambda x: x), numba_inside.cpu_target.typing_context
    codegen = numba_inside.cpu_target.target_context.codegen()
    library = codegen.create_library("of a test")
    library.enable_object_caching()
    result = numba_inside.compiled(dispatcher.py_func, numba.float64(numba.float64))
    overload, intrinsic = (numba_inside.templates_of(x)[0] for x in (gi.sqrt, insert_lane))
    intrinsic._defn = insert_lane._defn
    names = {"codegen": codegen, "library": library, "typing": types, "dispatcher": dispatcher}
    return SimpleNamespace(**names, result=result, overload=overload, intrinsic=intrinsic)


@pytest.mark.parametrize("name", NAMES)
def test_numba_has(name: str, objects: SimpleNamespace) -> None:
    assert pkgutil.resolve_name(name) if ":" in name else [operator.attrgetter(name)(objects)]


def test_no_other_name_is_used() -> None:
    """In that file; and in no other one a module of numba that extensions do not use."""
    inside, listed = Path(numba_inside.__file__), " ".join(NAMES)
    words = set(re.findall(r"\.(_[a-z]\w*)", inside.read_text("utf-8")))
    assert words - OWN <= set(re.findall(r"\w+", listed))
    for path in inside.parents[1].rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("numba."):
                names = [f"{node.module}:{x.name}" in listed for x in node.names]
                own = path == inside and all(names)
                assert own or re.fullmatch(EXTENSIONS, node.module), (path, node.module)
