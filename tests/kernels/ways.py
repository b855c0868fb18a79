"""Ways in which a function reaches a value that numba freezes when it compiles the function.

Run with a folder it imports a module for each way from there, looks at its function ``f``, makes its
change, looks again, and prints what it found: fingerprints, and of those that are named what compiled
code and plain Python give.
"""

from __future__ import annotations

import importlib
import json
import re
import sys
from pathlib import Path
from typing import NamedTuple

FOLLOWED = "followed"
REFUSED = "refused"  # by geomint, with a typed error
UNKNOWN = "unknown to numba"  # which raises an error of its own


class Way(NamedTuple):
    """A module with a function f(x), one that it imports, and a change that is run in its namespace.

    An edit of the files is ``2.0`` becoming ``3.0`` in all of them.
    """

    source: str
    helper: str
    change: str
    outcome: str


# ``name | change | outcome``, by default K = 3.0, in the helper module if there is one, and followed.
# Then lines of the module, and after > more of the module `hlp`, which has K = 2.0 and g(x): K * x.
# ``@f(x): …`` is a recorded function, ``… => …`` one that returns what comes last.
TEXT = """
global
  K = 2.0 => K * x
global complex | K = 3.0 + 1j
  K = 2.0 + 1j => K.real * x
string | K = 'k'
  K = 'k2.0' => x if K == 'k2.0' else 1.5 * x
sets, whose order is that of the process | | unknown
  K, S = 2.0, frozenset('abcdef') => K * x if S and 'a' in {'a', 'b', 'c', 'd'} else x
sign of zero | K = -0.0
  K = 0.0 * (2.5 - 2.0) => math.copysign(x, K)
tuple | K = (1.0, (3.0, 5.0))
  K = (1.0, (2.0, 5.0)) => K[1][0] * x
default of a named tuple | P.__new__.__defaults__ = (3.0,) | unknown
  P = namedtuple('P', 'a b', defaults=(2.0,)) => P(x).b * x
builtin name | builtins.K_OF_ALL = 3.0
  builtins.K_OF_ALL = 2.0 => K_OF_ALL * x
shadowed builtin | abs = gi.helper(lambda x: 7.0 * x)
  @f(x): return abs(x) * 2.0
type | D = np.float64
  D = np.float32 if 2.0 < 2.5 else np.float64 => D(x / 3)
names of geomint, which are made on demand
  K = 2.0 => gi.sqrt(K * x) + gi.select(x > 1.0, 0.5, K)
array | K[1] = 3
  K = np.array([1.0, 2.0]) => K[1] * x
array through its base | B[1] = 3.0
  B = np.array([1.0, 2.0, 4.0, 8.0])
  K = B[1::2] => K[0] * x
middle of a large array | K[100_000] = 3.0
  K = np.ones(200_000)
  K[100_000] = 2.0 => K[100_000] * x
structured array | K['a'] = 3.0
  K = np.array([(2.0, 1)], dtype=[('a', 'f8'), ('b', 'i8')]) => K[0]['a'] * x
array in a tuple | K[1][0] = 3
  K = (1.0, np.array([2.0])) => K[1][0] * x
default | g.function.__defaults__ = (3.0,)
  @g(x, k=2.0): return k * x
  @f(x): return g(x)
default array | A[0] = 3.0
  A = np.array([2.0])
  @g(x, k=A): return k[0] * x
  @f(x): return g(x)
closure | f.function.__closure__[0].cell_contents = 3.0
  f = (lambda k: gi.helper(lambda x: k * x))(2.0)
closure read inside | f.function.__closure__[0].cell_contents = 3.0
  f = (lambda k: gi.helper(lambda x: (lambda z: z * k)(x)))(2.0)
name of an outer variable declared global inside
  K = 2.0
  def make():
      K = 5.0
      def f(x):
          def g(z):
              global K
              return K * z
          return g(x) + K
      return gi.helper(f)
  f = make()
code | f.function.__code__ = (lambda x: 7.0 * x).__code__
  @f(x): return 2.0 * x
function of a recorded one | f.function = lambda x: 7.0 * x
  @f(x): return 2.0 * x
lambda
  K = 2.0
  @f(x): g = lambda z: K * z; return g(x)
comprehension
  K = 2.0 => sum([K * x for i in range(2)])
default of a nested function
  K = 2.0
  @f(x): g = lambda z, k=K: k * z; return g(x)
beyond 255 names
  globals().update({f'N{i}': 1.0 for i in range(300)})
  many = ' + '.join(f'N{i}' for i in range(300))
  f = gi.helper(eval(f'lambda x: {many} + hlp.K * x'))
helper
  K = 2.0
  @g(x): return K * x
  @f(x): return g(x)
helper defined anew | g = gi.helper(lambda x: 7.0 * x)
  @g(x): return 2.0 * x
  @f(x): return g(x)
helper of another name | c = h
  @g(x): return 2.0 * x
  @h(x): return 7.0 * x
  a, b, c = g, h, g => a(x) + 10.0 * b(x) + 100.0 * c(x)
helpers in a tuple | PAIR = (h, g)
  @g(x): return 2.0 * x
  @h(x): return 7.0 * x
  PAIR = (g, g) => PAIR[0](x) * 1.0
helper given as an argument
  K = 2.0
  @g(x): return K * x
  @twice(g, x): return g(g(x))
  @f(x): return twice(g, x)
helper that calls itself a library's
  K = 2.0
  g = gi.helper(functools.wraps(np.linalg.norm)(lambda x: K * x)) => g(x)
module loaded again | again(hlp)
  @f(x): return hlp.g(x)
  def again(module):
      path = pathlib.Path(module.__file__)
      path.write_text(path.read_text().replace('K = ', 'K = 1 + '))
      importlib.invalidate_caches()
      importlib.reload(module)
attribute
  @f(x): return hlp.K * x
function of a module
  @f(x): return hlp.g(x)
another module | hlp = types.ModuleType('hlp'); hlp.K = 3.0
  @f(x): return hlp.K * x
attribute of a subpackage | hlp.sub.K = 3.0
  hlp.sub = types.ModuleType('hlp.sub')
  hlp.sub.K = hlp.K => hlp.sub.K * x
attribute made on demand
  @f(x): return hlp.L * x
  > def __getattr__(name):
  >     if name == 'L':
  >         return K
  >     raise AttributeError(name)
local alias
  @f(x): m = hlp; return m.K * x
function of a local alias
  @f(x): m = hlp; return m.g(x)
alias unpacked
  @f(x): m, z = hlp, x; return m.K * z
alias in an expression | | unknown
  @f(x): return (m := hlp).K * x + m.K
alias of a submodule | hlp.sub.K = 3.0
  hlp.sub = types.ModuleType('hlp.sub')
  hlp.sub.K = hlp.K
  @f(x): m = hlp.sub; return m.K * x
submodule of an alias | hlp.sub.K = 3.0
  hlp.sub = types.ModuleType('hlp.sub')
  hlp.sub.K = hlp.K
  @f(x): m = hlp; return m.sub.K * x
alias read inside
  @f(x): m = hlp; g = lambda z: m.K * z; return g(x)
module as an argument | | refused
  @g(m, x): return m.K * x
  @f(x): return g(hlp, x)
module as a result
  @which(): return hlp
  @f(x): return which().K * x
module as a default
  @g(x, m=hlp): return m.K * x
  @f(x): return g(x)
module in a tuple | | unknown
  MS = (hlp, 1.0) => MS[0].K * x
module of a closure
  f = (lambda mod: gi.helper(lambda x: (mod if x > 0.0 else mod).K * mod.K * x))(hlp)
getattr | | refused
  @f(x): return getattr(hlp, 'K') * x
getattr of what is not there yet | hlp.L = 3.0 | refused
  @f(x): return getattr(hlp, 'L', 2.0) * x
member | E = enum.Enum('E', {'A': 3.0})
  E = enum.Enum('E', {'A': 2.0}) => E.A.value * x
value of a member | E.A._value_ = 3
  E = enum.IntEnum('E', {'A': int(2.0)}) => E.A.value * x
whole member | K = enum.IntEnum('E', {'A': 3}).A | unknown
  K = enum.IntEnum('E', {'A': int(2.0)}).A => K * x
attribute of a class | C.K = 3.0 | unknown
  C = type('C', (), {'K': 2.0}) => C.K * x
attribute of an object | c.K = 3.0 | unknown
  c = types.SimpleNamespace(K=2.0) => c.K * x
list | K[0] = 3.0 | unknown
  K = [2.0] => K[0] * x
dict | K[1] = 3.0 | unknown
  K = {1: 2.0} => K[1] * x
partial | g = functools.partial(pow, 3.0) | unknown
  g = functools.partial(pow, 2.0) => g(x)
plain function | | unknown
  K = 2.0
  g = lambda x: K * x
  @f(x): return g(x)
numba function | | refused
  K = 2.0
  g = numba.njit(lambda x: K * x) => g(x)
numba ufunc | | refused
  K = 2.0
  g = numba.vectorize(lambda x: K * x) => g(x)
overload | | refused
  K = 2.0
  g = lambda x: K * x
  numba.extending.overload(g)(lambda x: lambda x: K * x)
  @f(x): return g(x)
jitable | | refused
  K = 2.0
  g = numba.extending.register_jitable(lambda x: K * x) => g(x)
intrinsic | | refused
  K = 2.0
  @numba.extending.intrinsic
  def g(context, x):
      def generate(c, builder, s, a):
          return builder.fmul(a[0], c.get_constant(numba.float64, K))
      return numba.float64(numba.float64), generate
  @f(x): return g(x)
jitclass | | refused
  K = 2.0
  @numba.experimental.jitclass([('a', numba.float64)])
  class C:
      def __init__(self, a):
          self.a = a * K
  @f(x): return C(x).a
bytes that can change | K[0] = 3 | refused
  K = bytearray([int(2.0)]) => K[0] * x
address | g = of('cosh')
  libm = ctypes.CDLL(ctypes.util.find_library('m'))
  def of(name):
      g = libm[name]
      g.argtypes, g.restype = [ctypes.c_double], ctypes.c_double
      return g
  g = of('exp' if 2.0 < 2.5 else 'cosh') => g(x)
"""
HEAD = """
import builtins, ctypes, ctypes.util, enum, functools, importlib, math, pathlib, types
import numba, numba.experimental, numba.extending
import numpy as np
import geomint as gi
from collections import namedtuple
"""


def _written(lines: list[str]) -> str:
    """Return Python for lines of the text."""
    text = "\n".join(lines)
    text = re.sub(r"^(.*) => (.*)$", r"\1\n@f(x): return \2", text, flags=re.M)
    return re.sub(r"^@(\w+\(.*?\):)", r"@gi.helper\ndef \1", text, flags=re.M)


def _read() -> dict[str, Way]:
    found = {}
    for number, (head, *lines) in enumerate(
        part.splitlines() for part in re.split(r"\n+(?! )", TEXT.strip())
    ):
        name, change, outcome, *_ = [*map(str.strip, head.split("|")), "", ""]
        own = [line[2:] for line in lines if line[2] != ">"]
        source = _written(own)
        imports = f"import hlp_{number} as hlp\n" * ("hlp" in source)
        source = HEAD + imports + source.replace("from hlp ", f"from hlp_{number} ")
        helper = ["K = 2.0", "@g(x): return K * x", *(x[4:] for x in lines if x[2] == ">")]
        change = change or ("hlp.K = 3.0" if imports else "K = 3.0")
        kind = {"": FOLLOWED, "refused": REFUSED, "unknown": UNKNOWN}[outcome]
        way = Way(source, HEAD + _written(helper), change, kind)
        found[name] = Way(*(text.replace("K_OF_ALL", f"K_{number}") for text in way))
    return found


WAYS = _read()


def write(folder: Path, old: str = "2.0", new: str = "2.0") -> None:
    """Write the modules of all ways, with a replacement in each."""
    for number, way in enumerate(WAYS.values()):
        for kind, text in (("way", way.source), ("hlp", way.helper)):
            path = folder / f"{kind}_{number}.py"
            path.write_text(text.replace(old, new) + "\n", encoding="utf-8")


def outcome(module) -> object:
    """Return what compiled code and Python give, or how the function is refused."""
    from numba.core import types

    from geomint import DomainError
    from geomint.kernels.compiling.compile import compile_function

    try:
        entry = compile_function(module.f, types.float64(types.float64))
        return [entry(1.25), float(module.f(1.25))]
    except DomainError:
        return REFUSED
    except Exception:
        return UNKNOWN


def main(folder: str, *names: str) -> None:
    """Print what each way has, at first and after the change."""
    sys.path.insert(0, folder)
    result = {}
    for number, (name, way) in enumerate(WAYS.items()):
        module, found = importlib.import_module(f"way_{number}"), []
        for change in ("", way.change):
            exec(change, vars(module))
            found.append([module.f.fingerprint, outcome(module) if name in names else None])
        result[name] = found
    print(json.dumps(result))


if __name__ == "__main__":
    main(*sys.argv[1:])
