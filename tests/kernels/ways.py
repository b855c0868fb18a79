"""Ways in which a function reaches a value that numba freezes when it compiles the function.

Run with a folder it imports a module for each way from there, compiles its function ``f``, makes
its change, compiles again, and prints what compiled code and plain Python give.
"""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from typing import NamedTuple

FOLLOWED = "followed"
REFUSED = "refused"  # by geomint, with a typed error
UNKNOWN_TO_NUMBA = "unknown to numba"  # which raises an error of its own


class Way(NamedTuple):
    """A module with a function f(x), what it imports, and a change: both are run in its namespace.

    An edit of the files is ``2.0`` becoming ``3.0`` in all of them.
    """

    source: str
    change: str = "K = 3.0"
    helper: str = ""
    outcome: str = FOLLOWED


G = "@gi.helper\n"
F = G + "def f(x):\n    "
H = "K = 2.0\n@gi.helper\ndef g(x):\n    return K * x\n"
HLP = "hlp.K = 3.0"

WAYS = {
    # values of names
    "global": Way("K = 2.0\n" + F + "return K * x"),
    "global integer": Way("K = int(2.0)\n" + F + "return K * x", "K = 3"),
    "global complex": Way("K = 2.0 + 1j\n" + F + "return K.real * x", "K = 3.0 + 1j"),
    "global numpy number": Way(
        "import numpy as np\nK = np.float32(2.0)\n" + F + "return K * x", "K = np.float32(3.0)"
    ),
    "string": Way("K = 'k2.0'\n" + F + "return x if K == 'k2.0' else 1.5 * x", "K = 'k'"),
    "sets, whose order is that of the process": Way(
        "K = 2.0\nS = frozenset('abcdef')\n"
        + F
        + "return K * x if S and 'a' in {'a', 'b', 'c', 'd'} else x",
        outcome=UNKNOWN_TO_NUMBA,
    ),
    "sign of zero": Way(
        "import math\nK = 0.0 * (2.5 - 2.0)\n" + F + "return math.copysign(x, K)", "K = -0.0"
    ),
    "tuple": Way("K = (1.0, (2.0, 5.0))\n" + F + "return K[1][0] * x", "K = (1.0, (3.0, 5.0))"),
    "nesting": Way(
        "K = ((1.0, 2.0), 5.0)\n" + F + "return x * len(K[0])", "K = ((1.0, 2.0, 5.0), 5.0)"
    ),
    "named tuple": Way(
        "from collections import namedtuple\nP = namedtuple('P', 'a b')\nK = P(2.0, 1.0)\n"
        + F
        + "return K.a * x",
        "K = P(3.0, 1.0)",
    ),
    "default of a named tuple": Way(
        "from collections import namedtuple\nP = namedtuple('P', 'a b', defaults=(2.0,))\n"
        + F
        + "return P(x).b * x",
        "P.__new__.__defaults__ = (3.0,)",
        outcome=UNKNOWN_TO_NUMBA,
    ),
    "builtin name": Way(
        "import builtins\nbuiltins.K_OF_ALL = 2.0\n" + F + "return K_OF_ALL * x",
        "builtins.K_OF_ALL = 3.0",
    ),
    "shadowed builtin": Way(F + "return abs(x) * 2.0", "abs = gi.helper(lambda x: 7.0 * x)", ""),
    "type": Way(
        "import numpy as np\nD = np.float32 if 2.0 < 2.5 else np.float64\n" + F + "return D(x / 3)",
        "D = np.float64",
    ),
    # contents that change in place
    "array": Way(
        "import numpy as np\nK = np.array([1.0, 2.0])\n" + F + "return K[1] * x", "K[1] = 3"
    ),
    "array through its base": Way(
        "import numpy as np\nB = np.array([1.0, 2.0, 4.0, 8.0])\nK = B[1::2]\n"
        + F
        + "return K[0] * x",
        "B[1] = 3.0",
    ),
    "middle of a large array": Way(
        "import numpy as np\nK = np.ones(200_000)\nK[100_000] = 2.0\n"
        + F
        + "return K[100_000] * x",
        "K[100_000] = 3.0",
    ),
    "array of integers": Way(
        "import numpy as np\nK = np.array([2.0]).astype(int)\n" + F + "return K[0] * x", "K[0] = 3"
    ),
    "structured array": Way(
        "import numpy as np\nK = np.array([(2.0, 1)], dtype=[('a', 'f8'), ('b', 'i8')])\n"
        + F
        + "return K[0]['a'] * x",
        "K['a'] = 3.0",
    ),
    "array in a tuple": Way(
        "import numpy as np\nK = (1.0, np.array([2.0]))\n" + F + "return K[1][0] * x", "K[1][0] = 3"
    ),
    # functions: defaults, closures, code
    "default": Way(
        G + "def g(x, k=2.0):\n    return k * x\n" + F + "return g(x)",
        "g.function.__defaults__ = (3.0,)",
    ),
    "default array": Way(
        "import numpy as np\nA = np.array([2.0])\n"
        + G
        + "def g(x, k=A):\n    return k[0] * x\n"
        + F
        + "return g(x)",
        "A[0] = 3.0",
    ),
    "keyword default": Way(
        G + "def g(x, *, k=2.0):\n    return k * x\n" + F + "return g(x)",
        "g.function.__kwdefaults__['k'] = 3.0",
        outcome=UNKNOWN_TO_NUMBA,
    ),
    "closure": Way(
        "def make(k):\n    def put(v):\n        nonlocal k\n        k = v\n"
        "    def f(x):\n        return k * x\n    return gi.helper(f), put\nf, put = make(2.0)",
        "put(3.0)",
    ),
    "closure array": Way(
        "import numpy as np\ndef make(k):\n    def f(x):\n        return k[0] * x\n"
        "    return gi.helper(f)\nA = np.array([2.0])\nf = make(A)",
        "A[0] = 3.0",
    ),
    "closure read inside": Way(
        "def make(k):\n    def put(v):\n        nonlocal k\n        k = v\n    def f(x):\n"
        "        g = lambda z: z * k\n        return g(x)\n    return gi.helper(f), put\n"
        "f, put = make(2.0)",
        "put(3.0)",
    ),
    "name of an outer variable declared global inside": Way(
        "K = 2.0\ndef make():\n    K = 5.0\n    def f(x):\n        def g(z):\n"
        "            global K\n            return K * z\n        return g(x) + K\n"
        "    return gi.helper(f)\nf = make()",
    ),
    "code": Way(
        F + "return 2.0 * x\ndef other(x):\n    return 7.0 * x",
        "f.function.__code__ = other.__code__",
    ),
    "function of a recorded one": Way(
        F + "return 2.0 * x\ndef other(x):\n    return 7.0 * x", "f.function = other"
    ),
    "nested function": Way("K = 2.0\n" + F + "def g(z):\n        return K * z\n    return g(x)"),
    "lambda": Way("K = 2.0\n" + F + "g = lambda z: K * z\n    return g(x)"),
    "comprehension": Way("K = 2.0\n" + F + "return sum([K * x for i in range(2)])"),
    "default of a nested function": Way(
        "K = 2.0\n" + F + "def g(z, k=K):\n        return k * z\n    return g(x)"
    ),
    "beyond 255 names": Way(
        "\n".join(f"N{i} = 1.0" for i in range(300))
        + "\nimport hlp\n"
        + F
        + "z = "
        + " + ".join(f"N{i}" for i in range(300))
        + "\n    return z + hlp.K * x",
        HLP,
        H,
    ),
    # helpers
    "helper": Way(H + F + "return g(x)"),
    "helper defined anew": Way(
        H + F + "return g(x)", "@gi.helper\ndef g(x):\n    return 7.0 * x\n"
    ),
    "helper imported": Way("from hlp import g\nimport hlp\n" + F + "return g(x)", HLP, H),
    "helper of another name": Way(
        G
        + "def g(x):\n    return 2.0 * x\n"
        + G
        + "def h(x):\n    return 7.0 * x\na, b, c = g, h, g\n"
        + F
        + "return a(x) + 10.0 * b(x) + 100.0 * c(x)",
        "c = h",
    ),
    "helper's helper": Way(
        "import hlp\n" + F + "return hlp.h(x)",
        HLP,
        H + "@gi.helper\ndef h(x):\n    return g(x) + 1.0\n",
    ),
    "helpers in a tuple": Way(
        H + G + "def h(x):\n    return 7.0 * x\nPAIR = (g, g)\n" + F + "return PAIR[0](x) * 1.0",
        "PAIR = (h, g)",
    ),
    "helper given as an argument": Way(
        H + G + "def twice(g, x):\n    return g(g(x))\n" + F + "return twice(g, x)"
    ),
    "helper that calls itself a library's": Way(
        "import functools, numpy as np\nK = 2.0\n@gi.helper\n@functools.wraps(np.linalg.norm)\n"
        "def g(x):\n    return K * x\n" + F + "return g(x)"
    ),
    "module loaded again": Way(
        "import hlp, importlib, pathlib\n" + F + "return hlp.g(x)",
        "p = pathlib.Path(hlp.__file__)\np.write_text(p.read_text().replace('K = ', 'K = 1 + '))\n"
        "importlib.invalidate_caches()\nimportlib.reload(hlp)",
        H,
    ),
    # modules
    "attribute": Way("import hlp\n" + F + "return hlp.K * x", HLP, H),
    "function of a module": Way("import hlp\n" + F + "return hlp.g(x)", HLP, H),
    "another module": Way(
        "import hlp, types\n" + F + "return hlp.K * x",
        "hlp = types.SimpleNamespace(K=3.0)\nhlp = types.ModuleType('hlp')\nhlp.K = 3.0",
        H,
    ),
    "attribute of a subpackage": Way(
        "import hlp, types\nhlp.sub = types.ModuleType('hlp.sub')\nhlp.sub.K = hlp.K\n"
        + F
        + "return hlp.sub.K * x",
        "hlp.sub.K = 3.0",
        H,
    ),
    "attribute made on demand": Way(
        "import hlp\n" + F + "return hlp.L * x",
        HLP,
        H + "def __getattr__(name):\n    if name == 'L':\n        return K\n"
        "    raise AttributeError(name)\n",
    ),
    "local alias": Way("import hlp\n" + F + "m = hlp\n    return m.K * x", HLP, H),
    "function of a local alias": Way("import hlp\n" + F + "m = hlp\n    return m.g(x)", HLP, H),
    "alias in a helper": Way(
        "import hlp\n" + G + "def g(x):\n    m = hlp\n    return m.K * x\n" + F + "return g(x)",
        HLP,
        H,
    ),
    "alias of an alias": Way("import hlp\n" + F + "a = hlp\n    b = a\n    return b.K * x", HLP, H),
    "alias unpacked": Way("import hlp\n" + F + "m, z = hlp, x\n    return m.K * z", HLP, H),
    "alias in an expression": Way(
        "import hlp\n" + F + "return (m := hlp).K * x + m.K", HLP, H, UNKNOWN_TO_NUMBA
    ),
    "alias of a submodule": Way(
        "import hlp, types\nhlp.sub = types.ModuleType('hlp.sub')\nhlp.sub.K = hlp.K\n"
        + F
        + "m = hlp.sub\n    return m.K * x",
        "hlp.sub.K = 3.0",
        H,
    ),
    "submodule of an alias": Way(
        "import hlp, types\nhlp.sub = types.ModuleType('hlp.sub')\nhlp.sub.K = hlp.K\n"
        + F
        + "m = hlp\n    return m.sub.K * x",
        "hlp.sub.K = 3.0",
        H,
    ),
    "alias read inside": Way(
        "import hlp\n" + F + "m = hlp\n    g = lambda z: m.K * z\n    return g(x)", HLP, H
    ),
    "module as an argument": Way(
        "import hlp\n" + G + "def g(m, x):\n    return m.K * x\n" + F + "return g(hlp, x)",
        HLP,
        H,
        REFUSED,
    ),
    "module as a result": Way(
        "import hlp\n" + G + "def which():\n    return hlp\n" + F + "return which().K * x", HLP, H
    ),
    "module as a default": Way(
        "import hlp\n" + G + "def g(x, m=hlp):\n    return m.K * x\n" + F + "return g(x)", HLP, H
    ),
    "module in a tuple": Way(
        "import hlp\nMS = (hlp, 1.0)\n" + F + "return MS[0].K * x", HLP, H, UNKNOWN_TO_NUMBA
    ),
    "module of a closure": Way(
        "import hlp\ndef make(mod):\n    def f(x):\n        m = mod\n        return m.K * mod.K * x\n"
        "    return gi.helper(f)\nf = make(hlp)",
        HLP,
        H,
    ),
    "module of a condition": Way(
        "import hlp, types\nother = types.ModuleType('other')\nother.K = 5.0\n"
        + F
        + "return (hlp if x > 0.0 else hlp).K * x",
        HLP,
        H,
    ),
    "getattr": Way("import hlp\n" + F + "return getattr(hlp, 'K') * x", HLP, H, REFUSED),
    "getattr by a name": Way(
        "import hlp\nN = 'K'\n" + F + "return getattr(hlp, N) * x", HLP, H, REFUSED
    ),
    "getattr of what is not there yet": Way(
        "import hlp\n" + F + "return getattr(hlp, 'L', 2.0) * x", "hlp.L = 3.0", H, REFUSED
    ),
    # classes
    "member": Way(
        "import enum\nclass E(enum.Enum):\n    A = 2.0\n" + F + "return E.A.value * x",
        "class E(enum.Enum):\n    A = 3.0\n",
    ),
    "value of a member": Way(
        "import enum\nclass E(enum.IntEnum):\n    A = int(2.0)\n" + F + "return E.A.value * x",
        "E.A._value_ = 3",
    ),
    "whole member": Way(
        "import enum\nclass E(enum.IntEnum):\n    A = int(2.0)\nK = E.A\n" + F + "return K * x",
        "class E(enum.IntEnum):\n    A = 3\nK = E.A",
        outcome=UNKNOWN_TO_NUMBA,
    ),
    "attribute of a class": Way(
        "class C:\n    K = 2.0\n" + F + "return C.K * x", "C.K = 3.0", "", UNKNOWN_TO_NUMBA
    ),
    "attribute of an object": Way(
        "import types\nc = types.SimpleNamespace(K=2.0)\n" + F + "return c.K * x",
        "c.K = 3.0",
        "",
        UNKNOWN_TO_NUMBA,
    ),
    "list": Way("K = [2.0]\n" + F + "return K[0] * x", "K[0] = 3.0", "", UNKNOWN_TO_NUMBA),
    "dict": Way("K = {1: 2.0}\n" + F + "return K[1] * x", "K[1] = 3.0", "", UNKNOWN_TO_NUMBA),
    "partial": Way(
        "import functools\ng = functools.partial(pow, 2.0)\n" + F + "return g(x)",
        "g = functools.partial(pow, 3.0)",
        "",
        UNKNOWN_TO_NUMBA,
    ),
    "plain function": Way(
        "K = 2.0\ndef g(x):\n    return K * x\n" + F + "return g(x)", outcome=UNKNOWN_TO_NUMBA
    ),
    # what numba compiles by itself
    "numba function": Way(
        "import numba\nK = 2.0\n@numba.njit\ndef g(x):\n    return K * x\n" + F + "return g(x)",
        outcome=REFUSED,
    ),
    "numba function of a module": Way(
        "import hlp\n" + F + "m = hlp\n    return m.n(x)",
        HLP,
        H + "import numba\n@numba.njit\ndef n(x):\n    return K * x\n",
        REFUSED,
    ),
    "numba ufunc": Way(
        "import numba\nK = 2.0\n@numba.vectorize\ndef g(x):\n    return K * x\n"
        + F
        + "return g(x)",
        outcome=REFUSED,
    ),
    "numba callback": Way(
        "import numba\nK = 2.0\n@numba.cfunc('f8(f8)')\ndef g(x):\n    return K * x\n"
        + F
        + "return g(x)",
        outcome=REFUSED,
    ),
    "overload": Way(
        "import numba.extending\nK = 2.0\ndef g(x):\n    return K * x\n"
        "@numba.extending.overload(g)\ndef _(x):\n    return lambda x: K * x\n" + F + "return g(x)",
        outcome=REFUSED,
    ),
    "jitable": Way(
        "import numba.extending\nK = 2.0\n@numba.extending.register_jitable\ndef g(x):\n"
        "    return K * x\n" + F + "return g(x)",
        outcome=REFUSED,
    ),
    "intrinsic": Way(
        "import numba.extending\nfrom numba import types\nK = 2.0\n@numba.extending.intrinsic\n"
        "def g(context, x):\n    def generate(c, builder, s, a):\n"
        "        return builder.fmul(a[0], c.get_constant(types.float64, K))\n"
        "    return types.float64(types.float64), generate\n" + F + "return g(x)",
        outcome=REFUSED,
    ),
    "jitclass": Way(
        "import numba\nfrom numba.experimental import jitclass\nK = 2.0\n"
        "@jitclass([('a', numba.float64)])\nclass C:\n"
        "    def __init__(self, a):\n        self.a = a * K\n" + F + "return C(x).a",
        outcome=REFUSED,
    ),
    "bytes that can change": Way(
        "K = bytearray([int(2.0)])\n" + F + "return K[0] * x", "K[0] = 3", "", REFUSED
    ),
    "address": Way(
        "import ctypes, ctypes.util\nlibm = ctypes.CDLL(ctypes.util.find_library('m'))\n"
        "def of(name):\n    g = libm[name]\n    g.argtypes, g.restype = [ctypes.c_double], "
        "ctypes.c_double\n    return g\ng = of('exp' if 2.0 < 2.5 else 'cosh')\n"
        + F
        + "return g(x)",
        "g = of('cosh')",
    ),
}


def write(folder: Path, old: str = "", new: str = "") -> None:
    """Write the modules of all ways, with a replacement in each."""
    for number, way in enumerate(WAYS.values()):
        for kind, text in (("way", way.source), ("hlp", way.helper)):
            text = text.replace("import hlp", f"import hlp_{number} as hlp")
            text = text.replace("from hlp ", f"from hlp_{number} ").replace(
                "K_OF_ALL", f"K_{number}"
            )
            if old:
                text = text.replace(old, new)
            path = folder / f"{kind}_{number}.py"
            path.write_text(f"import geomint as gi\n{text}\n", encoding="utf-8")


def load(number: int):
    """Return the module of a way."""
    return importlib.import_module(f"way_{number}")


def change(number: int, module) -> None:
    """Make the change of a way."""
    text = list(WAYS.values())[number].change.replace("K_OF_ALL", f"K_{number}")
    exec(text, vars(module))


def outcome(module) -> object:
    """Return what compiled code and Python give, or how the function is refused."""
    from numba.core import types

    from geomint import DomainError
    from geomint.kernels.compiling.compiled import compiled

    try:
        entry = compiled(module.f, types.float64(types.float64))
        return [entry(1.25), float(module.f(1.25))]
    except DomainError:
        return REFUSED
    except Exception:
        return UNKNOWN_TO_NUMBA


def main(folder: str, task: str, *names: str) -> None:
    """Print, for each way, fingerprints or outcomes: at first, and after the change."""
    sys.path.insert(0, folder)
    result = {}
    for number, name in enumerate(WAYS):
        if names and name not in names:
            continue
        module = load(number)
        look = outcome if task == "compile" else (lambda m: m.f.fingerprint)
        first = look(module)
        change(number, module)
        result[name] = [first, look(module)]
    print(json.dumps(result))


if __name__ == "__main__":
    main(*sys.argv[1:])
