"""A file of a run that is not what was written is refused, and says how the run ended."""

import contextlib
import copy
import dataclasses
import importlib
import inspect
import itertools
import json
import os
import pickle
import pydoc
import random
import sys
import warnings

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.io import netcdf_file

import geomint as gi
from geomint.cli import main
from tests.fuzz.saved import sealed

# Steps are as long as a test wants them.
pytestmark = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")


@pytest.fixture(scope="module")
def solution():
    scene = gi.load_scene("sphere-n3").changed(time={"t_end": 5.0}, save={"every": 5})
    return gi.run_scene(scene, progress=False)


@pytest.fixture(scope="module")
def content(solution, tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "run.nc"
    solution.save(path)
    return path.read_bytes()


def refused(path, content):
    path.write_bytes(content)
    with pytest.raises(gi.GeomintError, match=r"run\.nc"):
        gi.load(path)


def test_nothing_is_read_later(solution, content, tmp_path):
    """What a file held when it was loaded is used to the end, whatever is there since."""
    path = tmp_path / "run.nc"
    path.write_bytes(content)
    loaded = gi.load(path)
    loaded.save(path)
    assert gi.load(path) == loaded
    path.write_bytes(b"something else")
    assert loaded == solution == solution.as_saved()
    assert repr(loaded) == repr(solution) == repr(solution.as_saved())
    lines = repr(solution).splitlines()  # as full as 80 columns may be
    assert max(map(len, lines)) <= 80
    assert all(len(one) + len(more.split()[0]) >= 80 for one, more in itertools.pairwise(lines))
    assert np.array_equal(loaded.y, solution.y)
    assert (loaded.problem, loaded.method) == (solution.problem, solution.method)
    one, other = (gi.solve(run, t_end=9.0, progress=False) for run in (loaded, solution))
    assert one == other


def test_whatever_byte_is_altered(content, tmp_path):
    """Where the header begins, and any of the others."""
    draw = random.Random(0)
    places = [*range(500), *(draw.randrange(500, len(content)) for _ in range(500))]
    for place in places:
        damaged = bytearray(content)
        damaged[place] ^= 1 << draw.randrange(8)
        refused(tmp_path / "run.nc", bytes(damaged))


def test_other_damages(content, tmp_path):
    """Cut off, longer, zeros in the place of the rest, turned around; files of other kinds."""
    draw = random.Random(0)
    for _ in range(10):
        at = draw.randrange(1, len(content))
        refused(tmp_path / "run.nc", content[:at])
        refused(tmp_path / "run.nc", content + content[:at] + b"\0")
        refused(tmp_path / "run.nc", content[:at] + bytes(len(content) - at + 1))
        refused(tmp_path / "run.nc", content[at:] + content[:at])
    for other in (b"", b"CDF", b"not a netcdf file at all", b"\x89HDF\r\n"):
        refused(tmp_path / "run.nc", other)
    with pytest.raises(FileNotFoundError):
        gi.load(tmp_path / "nothing.nc")


def foreign(path, **attributes):
    with netcdf_file(path, "w") as file:
        for name, value in attributes.items():
            setattr(file, name, value)
    return path


def test_what_is_no_run_of_this_version(tmp_path):
    path = tmp_path / "run.nc"
    with pytest.raises(gi.GeomintError, match="no run of geomint"):
        gi.load(foreign(path, title="weather"))
    for name in ("geomint-run-1", "geomint-run-2", "geomint-run-4"):
        with pytest.raises(gi.GeomintError, match=f"{name}.*run it again"):
            gi.load(foreign(path, checksum="0" * 64, format=name))
    path.unlink()
    os.mkfifo(path)
    for place in (path, tmp_path):
        with pytest.raises(gi.GeomintError, match="no regular file"):
            gi.load(place)


def read_or_refused(path, content, **given):
    """Return a run that was read, which all that shows it can show, or None where it is refused."""
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of numpy, of sizes
        try:
            found = gi.load(path, **given)
        except gi.GeomintError:
            return None
        repr(found), found._repr_html_(), found.to_xarray(), found.to_dataframe(), found.words()
        assert found == found.as_saved()
        found.save(path.with_name("again.nc"))
        assert gi.load(path.with_name("again.nc")) == found
    return found


@pytest.mark.parametrize("count", [50, pytest.param(3000, marks=pytest.mark.nightly)])
def test_sealed_by_somebody_else(count, content, tmp_path):
    """Sizes and places in the header that are none, and a checksum that fits: no other error either."""
    draw = random.Random(0)
    header = content.index(b"_problem_params")
    for _ in range(count):
        damaged = bytearray(content)
        at = draw.randrange(4, header)
        damaged[at : at + 4] = draw.choice(
            [b"\xff" * 4, b"\x80\0\0\0", b"\0\0\0\0", b"\x7f\xff\xff\xff", b"\0\0\0\x02"]
        )
        read_or_refused(tmp_path / "run.nc", sealed(damaged))


def rewritten(content, path, name, text):
    """Return a file whose attribute says something else, or is not there if that is None."""
    path.write_bytes(content)
    new = path.with_name("new.nc")
    with netcdf_file(path, mmap=False) as old, netcdf_file(new, "w", version=2) as file:
        for key, value in {**old._attributes, name: text}.items():
            if value is not None:
                setattr(file, key, value)
        for key, length in old.dimensions.items():
            file.createDimension(key, length)
        for key, one in old.variables.items():
            made = file.createVariable(key, one.typecode(), one.dimensions)
            made[...] = one.data
            for told, value in one._attributes.items():
                setattr(made, told, value)
    return sealed(new.read_bytes())


KINDS = ["x", None, -1, 1.5, True, [], {}, [[]], {"x": [1, "y"]}, 10**400, np.nan, "\ud800"]


def wrong(value):
    """Yield JSON of other kinds in the place of a value, and of each that is in it."""
    yield from KINDS
    if isinstance(value, dict):
        for key in value:
            yield from ({**value, key: other} for other in wrong(value[key]))
            yield {name: one for name, one in value.items() if name != key}
    elif isinstance(value, list):
        for i in range(min(len(value), 3)):
            yield from ([*value[:i], other, *value[i + 1 :]] for other in wrong(value[i]))


OPTIONAL = ("options", "kept", "events", "units", "status", "message")  # or said twice
STRICT = ("adaptive", "time", "format")
WORDS = ("run", "restart", "kept", "events", "options", "layout", "provenance", "units")
WORDS += ("problem", "method", "adaptive", "time", "status", "message", "format")


@pytest.mark.parametrize("count", [7, pytest.param(200, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("name", WORDS)
def test_attributes_of_somebody_else(name, count, rich, tmp_path):
    """Other kinds in every key, none, nested without an end: one error, or a run that can be shown."""
    content, path = rich[1], tmp_path / "run.nc"
    (tmp_path / "first.nc").write_bytes(content)
    with netcdf_file(tmp_path / "first.nc", mmap=False) as file:
        told = file._attributes.get(name, b"{}").decode()
    said = [None, b"", b"\xff\xfe", b"[" * 100_000, b"NaN", 7.0]
    with contextlib.suppress(ValueError):
        every = [json.dumps(one).encode() for one in wrong(json.loads(told))]
        said += random.Random(0).sample(every, min(len(every), count))
    for word in said:
        found = read_or_refused(path, rewritten(content, path, name, word))
        assert found is None or (word is not None and name not in STRICT) or name in OPTIONAL


def test_what_does_not_fit_together(rich, tmp_path):
    """Shapes that no run has, a variable that is named twice; attributes more do no harm."""
    found, content = rich
    path, kept = tmp_path / "run.nc", found.kept
    (met,) = found.events.values()
    changes = [
        {"kept": dataclasses.replace(kept, states=kept.states[:, :-2])},
        {"kept": dataclasses.replace(kept, times=kept.times[:-1])},
        {"kept": dataclasses.replace(kept, times=kept.times[:0], states=kept.states[:0])},
        {"restart": dataclasses.replace(found.restart, states=found.restart.states[:, :-2])},
        {"events": {"event": dataclasses.replace(met, y=met.y[:, :-1])}},
    ]
    for change in changes:
        dataclasses.replace(found, **change).save(path)
        with pytest.raises(gi.GeomintError, match="cannot be read as a run"):
            gi.load(path)
    path.write_bytes(content)
    with netcdf_file(path, mmap=False) as file:
        order = json.loads(file.layout)
    (piece,) = (entry for entry in order if entry[1] == "piece" and entry[0] == "gamma")
    twice = json.dumps([*order, [piece[0], "parameter", "again"]]).encode()
    other = {"tau": "_problem_params", "_problem_params": "tau"}
    changed = json.dumps([[other.get(name, name), *what] for name, *what in order]).encode()
    for layout in (twice, changed):
        assert read_or_refused(path, rewritten(content, path, "layout", layout)) is None
    assert read_or_refused(path, rewritten(content, path, "use_mmap", b"yes")) == found


@pytest.fixture(scope="module")
def rich(tmp_path_factory):
    """A run with all that a file may hold: events, dense output, warnings, estimates, a restart."""
    path = tmp_path_factory.mktemp("rich") / "run.nc"
    scene = gi.load_scene("hamiltonized-n3")
    found = gi.solve(
        scene.problem, scene.state, tau_end=3.0, step=0.5, method="gauss-4", dense=True, save_every=1,
        observe=["energy", "K"], events=gi.Event("gamma[0]"), estimate_error=True, progress=False,
    )  # fmt: skip
    found.save(path)
    return found, path.read_bytes()


MODULE = """
import geomint as gi

@gi.field
def turn(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -y[0]

@gi.observable
def energy(params, t, y, work):
    return 0.5 * (y[0] * y[0] + y[1] * y[1])

def problem(speed=1.0):
    pieces, energies = (("q", 1), ("p", 1)), {"energy": energy}
    return gi.Problem("turn", pieces, [speed], field=turn, invariants=energies)

class Own(gi.RungeKutta):
    pass
"""
MARKS = []


class Mark:
    """What a hostile pickle calls: it can be found by its name."""

    def __reduce__(self):
        return _marked, ()


def _marked():
    MARKS.append(1)
    raise RuntimeError("marked")


@pytest.fixture
def hostile(tmp_path, monkeypatch):
    """A run of an own problem by an own method whose code, in the file, leaves a mark."""
    (tmp_path / "own_turning.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    own = importlib.import_module("own_turning")
    run = gi.solve(
        own.problem(), [1.0, 0.0], t_end=2.0, step=0.05, method=own.Own("rk-4"), dense=True,
        save_every=1, observe=["energy"], compiled=False, progress=False,
    )  # fmt: skip
    path = tmp_path / "run.nc"
    run.save(path)
    content = path.read_bytes()
    with netcdf_file(path, mmap=False) as file:
        codes = [file.variables[f"_{of}_code"].data.tobytes() for of in ("problem", "method")]
    for code in codes:
        content = content.replace(code, pickle.dumps(Mark()).ljust(len(code), b"."))
    path.write_bytes(sealed(content))
    MARKS.clear()
    yield path, run
    sys.modules.pop("own_turning", None)


READERS = {
    "==": lambda s: (s == gi.load(s.path), s == s.run, s.run == s, s != s, s in [s.run]),
    "shown": lambda s: (repr(s), str(s), f"{s}", s._repr_html_(), hash(s), dir(s), vars(s)),
    "copies": lambda s: (copy.copy(s), copy.deepcopy(s), pickle.loads(pickle.dumps(s)), s.as_saved()),
    "fields": lambda s: (dataclasses.asdict(s), dataclasses.replace(s, steps=1)),
    "helped": lambda s: (pydoc.render_doc(s), inspect.getmembers_static(s), inspect.getdoc(s)),
    "tables": lambda s: (s.to_xarray()._repr_html_(), s.to_dataframe(), s.provenance, s.words()),
    "saved": lambda s: s.save(s.path.with_name("again.nc")),
    "numbers": lambda s: (s.t, s.piece("q"), s.drift["energy"], s.y_events, s.local_error),
    "drift": lambda s: s.plot_drift(),
    "plot": lambda s: s.plot(),
    "plot a quantity": lambda s: s.plot("energy"),
    "plot_phase": lambda s: s.plot_phase("q", "energy"),
    "plot_sphere": lambda s: s.plot_sphere(),
    "plot_trace": lambda s: s.plot_trace(),
    "animate": lambda s: s.animate(s.path.with_name("film.gif")),
    "cite": lambda s: gi.cite(s),
}  # fmt: skip


@pytest.mark.parametrize("name", READERS)
def test_readers_unpickle_nothing(hostile, name):
    """Whatever shows, compares, copies or draws a run leaves its pickles alone, trusted or not."""
    path, run = hostile
    for trust, kept in itertools.product([False, True], repeat=2):
        found = gi.load(path, trust=trust)
        found.path, found.run = path, run
        if not kept:
            found.kept = None
        with contextlib.suppress(gi.MissingCodeError, gi.DomainError):
            READERS[name](found)
        assert MARKS == []


@pytest.mark.parametrize("trust", [False, True])
def test_code_is_passed_on_with_trust_alone(hostile, trust):
    """A file that you made of a stranger's has no code of the stranger's."""
    path, run = hostile
    again = path.with_name("again.nc")
    gi.load(path, trust=trust).save(again)
    code = pickle.dumps(Mark())
    assert code in path.read_bytes()
    assert (code in again.read_bytes()) is trust
    found = gi.load(path, trust=trust)
    ways = pickle.dumps(found), pickle.dumps(found.as_saved()), pickle.dumps(copy.deepcopy(found))
    assert all((b"_marked" in sent) is trust for sent in ways)
    assert gi.load(again) == run
    mine = gi.load(again, trust=True)
    with pytest.raises(gi.MissingCodeError, match="marked" if trust else "no name makes it"):
        mine.problem
    assert bool(MARKS) is trust


def test_what_unpickles_is_trusted_and_says_so(hostile):
    """Problem, method, dense output and going on do, with trust alone."""
    path, run = hostile
    users = {
        "problem": lambda s: s.problem,
        "method": lambda s: s.method,
        "sol": lambda s: s.sol(1.0),
        "going on": lambda s: gi.solve(s, t_end=3.0),
        "an inspector": inspect.getmembers,
    }
    for use in users.values():
        with pytest.raises(gi.MissingCodeError, match="trust=True for a file that you made"):
            use(gi.load(path))
        assert MARKS == []
        with pytest.raises(gi.MissingCodeError, match="marked"):
            use(gi.load(path, trust=True))
        assert MARKS.pop() == 1
        MARKS.clear()
    given = gi.load(path, run.problem, method=run.method)
    assert given == run
    assert given.sol(1.03).tobytes() == run.sol(1.03).tobytes()
    on = {"t_end": 3.0, "compiled": False, "progress": False}
    assert gi.solve(given, **on).y.tobytes() == gi.solve(run, **on).y.tobytes()
    assert MARKS == []
    run.save(path)
    mine = gi.load(path, trust=True)
    with pytest.raises(gi.MissingCodeError, match=r"read \.problem"):
        mine.plot_phase("q", "energy")
    assert (mine.problem, mine.method) == (run.problem, run.method)
    assert mine.plot_phase("q", "energy").axes
    for other in ("rk-4", gi.Gauss(2), "no such"):
        with pytest.raises(ValueError, match=r"rk-4|no such"):
            gi.load(path, run.problem, method=other)
    with pytest.raises(gi.DomainError, match="trust"):
        gi.load(path, trust="yes")


@pytest.mark.parametrize(
    "method",
    [
        gi.Gauss(4),
        gi.Gauss(4, max_iterations=77),
        gi.Compose(gi.Gauss(1, iteration_tolerance=1e-15), "suzuki-4"),
        gi.Adaptive(gi.RungeKutta("dop853"), rtol=1e-5, max_step=0.3),
    ],
    ids=repr,
)
def test_methods_are_names_and_options(method, tmp_path):
    """The file has no code of a method that is found by its name; it is the same one, options too."""
    scene = gi.load_scene("sphere-n3")
    step, plain = None if method.adaptive else 0.1, {"compiled": False}
    run = gi.solve(scene.problem, scene.state, t_end=0.2, step=step, method=method, **plain)
    run.save(tmp_path / "run.nc")
    with netcdf_file(tmp_path / "run.nc", mmap=False) as file:
        assert "_method_code" not in file.variables
        assert "_problem_code" in file.variables
    found = gi.load(tmp_path / "run.nc", scene.problem)
    assert (found.method, found.by.name) == (method, method.name)
    rest, other = gi.solve(found, t_end=0.4, **plain), gi.solve(run, t_end=0.4, **plain)
    assert rest.y.tobytes() == other.y.tobytes()
    for value in (method, method.name):
        fits = value == method or gi.find_method(value) == method
        with contextlib.nullcontext() if fits else pytest.raises(gi.DomainError, match="method"):
            assert gi.load(tmp_path / "run.nc", method=value).method == method


def test_a_run_of_a_scene_needs_no_code(tmp_path):
    """Its problem is made by the system of the scene; pictures and going on have it."""
    scene = gi.load_scene("sphere-n3").changed(time={"t_end": 2.0}, save={"every": 1})
    run = gi.run_scene(scene, progress=False)
    run.save(tmp_path / "run.nc")
    found = gi.load(tmp_path / "run.nc")
    assert found.problem == run.problem
    assert found.plot("energy").axes
    assert gi.cite(gi.load(tmp_path / "run.nc")).text == gi.cite(run).text
    assert gi.solve(found, t_end=3.0).y.tobytes() == gi.solve(run, t_end=3.0).y.tobytes()


def test_variables_that_share_their_bytes(tmp_path):
    """A small file whose variables are all the same bytes, many times, takes no memory."""
    path = tmp_path / "run.nc"
    with netcdf_file(path, "w", version=2) as file:
        file.checksum, file.format = "0" * 64, "geomint-run-3"
        file.createDimension("many", 1 << 20)
        for k in range(40):
            file.createVariable(f"v{k}", "b", ("many",))[...] = 1
    content = bytearray(path.read_bytes())
    first = content.index(b"\x01" * 64)
    header = bytes(content[:first])
    for k in range(40):  # every variable begins where the first one does
        at = header.index(b"\0\x10\0\0", header.index(f"v{k}".encode().ljust(4, b"\0")) + 4) + 4
        content[at : at + 8] = first.to_bytes(8, "big")
    at = content.index(b"many") + 4
    for length in (b"\0\x10\0\0", b"\xff\xff\xff\xff"):
        content[at : at + 4] = length
        path.write_bytes(sealed(content[: first + (1 << 20)]))
        with pytest.raises(gi.GeomintError, match="larger than the file"):
            gi.load(path)


@pytest.mark.parametrize(
    "number",
    [np.longdouble("0.1"), np.clongdouble(1j), np.float32(0.1), pytest.param(10**5000, id="huge")],
)
def test_any_number_is_a_parameter(number, tmp_path):
    @gi.field
    def fall(params, t, y, out, work):
        out[0] = -y[0]

    told = {"one": number, "many": np.array([number, number])}
    problem = gi.Problem("fall", (("y", 1),), field=fall, parameters=told)
    gi.solve(problem, [1.0], t_end=1.0, step=0.5, compiled=False).save(tmp_path / "run.nc")
    known = gi.load(tmp_path / "run.nc").about.parameters
    if isinstance(number, np.floating):
        assert known["one"] == known["many"][0] == np.float64(number)


@pytest.mark.parametrize("status", ["interrupted", "failed", "not finite"])
def test_every_reader_sees_how_the_run_ended(solution, tmp_path, status):
    path, message = tmp_path / "run.nc", "at τ = 3: ∞"
    dataclasses.replace(solution, status=status, message=message).save(path)
    saved = gi.load(path)
    assert (saved.status, saved.success, saved.message) == (status, False, message)
    assert status in repr(saved)
    assert saved.plot_drift().get_suptitle() == f"run {status}"
    assert len(saved.plot_drift().axes) == len(solution.plot_drift().axes)
    with netcdf_file(path, mmap=False) as file:
        assert (file.status.decode(), file.message.decode()) == (status, message)
    with pytest.raises(gi.DomainError, match="gamma"):
        saved.piece("gama")


def test_the_ending_of_a_name_tells_the_format(solution, content, tmp_path):
    """States as CSV, exactly; another ending than those of what can be written is refused before."""
    solution.save(tmp_path / "run.csv")
    head, *lines = (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()
    assert head.split(",") == ["t", *(f"{v}[{i}]" for v in ("gamma", "p") for i in range(3))]
    table = np.array([[float(x) for x in line.split(",")] for line in lines])
    np.testing.assert_array_equal(table, np.column_stack((solution.t, solution.y)))
    for name in ("run", "run-0.5", "run.nc"):
        solution.save(tmp_path / name)
        assert gi.load(tmp_path / name) == solution
    at = solution.problem, solution.y[0], "gamma[0]"
    section = gi.poincare_section(*at, 2, step=0.1, progress=False)
    section.save(tmp_path / "section.csv")
    for saving, wrong, right in ((solution.save, "h5", ".nc, .csv"), (section.save, "nc", ".csv")):
        with pytest.raises(gi.DomainError, match=f"path = .*a.{wrong}': .* ends in {right}"):
            saving(tmp_path / f"a.{wrong}")
        assert not (tmp_path / f"a.{wrong}").exists()
    told = CliRunner().invoke(main, ["run", "sphere-n3", "--t-end", "1", "--out", "a.xlsx"])
    assert told.exit_code == 2
    assert "--out = 'a.xlsx': expected a name that ends in .nc, .csv" in told.stderr


def test_names_that_a_result_lacks(solution):
    """A KeyError, typed, that says which there are and what asks for more."""
    alone = gi.solve(solution.problem, solution.y[0], t_end=1.0, step=0.1, progress=False)
    many = gi.solve_ensemble(solution.problem, solution.y[:2], t_end=1.0, step=0.1, workers=1)
    for mapping, what, asked in (
        *((one.drift, "drift", "observe=…") for one in (alone, many)),
        *((one.events, "events", "events=…") for one in (alone, many)),
        (many.readings, "readings", "readings=…"),
    ):
        no_such = rf"{what}\['energy'\]: no such name. There are none.*Ask for more by {asked}"
        with pytest.raises(KeyError, match=no_such) as e:
            mapping["energy"]
        assert (type(e.value), mapping.get("energy")) == (gi.UnknownNameError, None)
        assert pickle.loads(pickle.dumps(mapping)) == dict(mapping) == {}
    with pytest.raises(gi.UnknownNameError, match="Did you mean 'energy'"):
        solution.drift["enrgy"]
