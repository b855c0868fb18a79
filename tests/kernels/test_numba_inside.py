"""What is private to numba is there, by name; and it stands in one file, of which this is the list."""

from __future__ import annotations

import ast
import operator
import pkgutil
import re
from pathlib import Path
from typing import Any

import numba
import pytest

import geomint as gi
from geomint.kernels import numba_inside
from geomint.kernels.compiling.compile import compile_function

NAMES = re.findall(r"\S+", """
numba.core.codegen:JITCodeLibrary numba.core.codegen:JITCodeLibrary.has_dynamic_globals
numba.core.compiler:CompileResult numba.core.compiler:CompileResult._rebuild
numba.core.compiler_lock:global_compiler_lock numba.core.serialize:dumps
numba.core.callconv:RETCODE_OK numba.core.callconv:RETCODE_NONE
numba.core.ir_utils:_add_alias numba.core.ir_utils:alias_analysis_extensions
numba.core.registry:cpu_target numba.core.registry:cpu_target.target_context
numba.core.typeconv.rules:default_type_manager.set_compatible
numba.core.typing.templates:make_intrinsic_template
numba.core.typing.typeof:typeof numba.core.typing.typeof:Purpose.constant
dispatcher.compile dispatcher.overloads dispatcher.get_call_template dispatcher.py_func
result._reduce result.fndesc.llvm_func_name result.signature.args result.library._codegen
result.library._codegen._library_class result.library._codegen._engine.is_symbol_defined
result.library._codegen.set_env result.library._codegen.magic_tuple
result.library._object_caching_enabled result.library._compiled_object result.library._finalized
result.library._optimize_final_module result.library._finalize_final_module
result.library._get_compiled_object result.library._ensure_finalized
result.library._final_module.global_variables result.library._final_module.get_function
result.library.get_pointer_to_function
result.typing_context.refresh result.typing_context._lookup_global
overload._overload_func intrinsic._definition_func function._defn
""")  # fmt: skip
OWN = {"_waits", "_make", "_at_once", "_defines"}
# Those of numba's modules that extensions use.
EXTENSIONS = r"numba(\.core(\.(types|errors|imputils|ir|typeconv|typing\.templates))?|\.extending)?"


@pytest.mark.parametrize("name", NAMES)
def test_numba_has(name: str) -> None:
    own = numba.float64(numba.float64)
    result: Any = compile_function(gi.helper(lambda x: gi.maximum(x, 1.0)), own).kept[0]
    result.library.enable_object_caching()
    intrinsic, overload = numba_inside.templates_of(gi.maximum)
    objects = {
        "dispatcher": numba.njit(lambda x: x),
        "result": result,
        "overload": overload,
        "intrinsic": intrinsic,
        "function": numba.extending.intrinsic(lambda context, x: None),
    }
    root, _, path = name.partition(".")
    assert pkgutil.resolve_name(name) if ":" in name else [operator.attrgetter(path)(objects[root])]


def test_no_other_name_is_used() -> None:
    """In that file; and in no other one a module of numba that extensions do not use."""
    inside, listed = Path(numba_inside.__file__), " ".join(NAMES)
    words = set(re.findall(r"\.(_[a-z]\w*)", inside.read_text("utf-8")))
    assert words - OWN <= set(re.findall(r"\w+", listed))
    for path in inside.parents[1].rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("numba."):
                own = path == inside and all(
                    f"{node.module}:{x.name}" in listed for x in node.names
                )
                assert own or re.fullmatch(EXTENSIONS, node.module), (path, node.module)
