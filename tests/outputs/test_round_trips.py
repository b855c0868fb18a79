"""What is written comes back bit by bit: problems of all scenes, names and numbers of any kind."""

import dataclasses
import functools
import importlib
import json
import sys

import numpy as np
import pytest
from hypothesis import HealthCheck, given, strategies as st
from scipy.io import netcdf_file

import geomint as gi
from tests.outputs.test_saved_runs import MODULE
from tests.rows import examples
from tests.series import drift_of_series

MODELS = {name: gi.load_scene(name).model for name in gi.scene_names()}
PROBLEMS = {
    f"{scene}:{name}": problem
    for scene, model in MODELS.items()
    for name, problem in model.problems.items()
}
METHODS = [gi.find_method(name) for name in gi.method_names()]
NOTHING = {
    "steps": 3, "rejected": 0, "iterations": 4, "evaluations": 5, "run_seconds": 0.1,
    "watching_seconds": 0.2, "compile_seconds": 0.3, "status": "success", "message": "",
}  # fmt: skip
SHORT = MODELS["sphere-n3"].problems["reduced"], MODELS["sphere-n3"].states["reduced"]
RUN = {"t_end": 0.1, "step": 0.1, "method": "rk-4", "compiled": False}


@pytest.fixture(autouse=True)
def unsynced(monkeypatch):
    """To wait for the disk is tested elsewhere; here are hundreds of files."""
    monkeypatch.setattr("os.fsync", lambda handle: None)


@functools.cache
def short():
    return gi.solve(*SHORT, **RUN)


def made(problem, method=METHODS[0], states=3, seed=0, **changes):
    """Return a solution of numbers that nobody integrated."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.random(states))
    series = np.arange(1.0, 1502.0), 1.0 + rng.normal(size=1501)  # and one of a pair
    restart = dataclasses.replace(
        short().restart, memory=rng.normal(size=7), h=1.0 / 3.0, done=12, clock=True, seen=4.1,
        told={"x": [[4.1, -1.0]], "y": []}, times=rng.normal(size=2),
        states=rng.normal(size=(2, problem.rows)),
    )  # fmt: skip
    sizes = type(short().step_sizes)(0.1, 0.1 + 2.0**-50, np.inf)
    given = {
        "about": problem, "by": method, "step": 0.1, "step_sizes": sizes, "tau": times,
        "physical": times if problem.time == "t" else rng.random(states),
        "y": rng.normal(size=(states, problem.rows)), "restart": restart, "drift_time": "t",
        "drift": {name: drift_of_series(name, *series, 1.5, initial=1.0) for name in ("energy", "k")},
    }  # fmt: skip
    return gi.Solution(**{**NOTHING, **given, **changes})


def through(solution, path, provenance=None):
    if provenance is not None:
        solution.origin = provenance
    solution.save(path)
    return gi.load(path)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.nightly] * (number % 3 > 0))
        for number, name in enumerate(PROBLEMS)
    ],
)
def test_every_problem_of_every_scene_by_every_method(name, tmp_path):
    problem = PROBLEMS[name]
    number = list(PROBLEMS).index(name)
    method = METHODS[number % len(METHODS)]
    solution = made(problem, method, seed=number)
    found = through(solution, tmp_path / "run.nc")
    assert found == solution
    told = (found.method, found.by.name, found.by.adaptive)
    assert told == (method, method.name, method.adaptive)
    assert gi.load(tmp_path / "run.nc", trust=True).problem == problem
    for piece, shape in problem.shapes.items():
        values = found.to_xarray()[piece]
        assert values.shape == (3, *shape)
        np.testing.assert_array_equal(values.values.reshape(3, -1), solution.piece(piece))


@pytest.mark.parametrize(
    ("time", "changes"),
    [
        *(("t", {"save_every": 1, "observe": ["energy"]}), ("t", {}), ("tau", {"clock": False})),
        ("t", {"events": {"never": gi.Event("gamma[0]", level=0.999)}}),
    ],
)
def test_short_runs(time, changes, tmp_path):
    """Of one step, with nothing watched, or less than a window of it; and without physical time."""
    scene = gi.load_scene("hamiltonized-n3" if time == "tau" else "sphere-n3")
    run = {**RUN, "t_end": None, f"{time}_end": 0.1, **changes}
    solution = gi.solve(scene.problem, scene.state, **run)
    saved = through(solution, tmp_path / "run.nc")
    assert saved == solution
    assert (saved.physical is None) == (time == "tau")
    for name, drift in solution.drift.items():
        assert saved.drift[name].as_json() == drift.as_json()
        assert saved.drift[name].windows.samples == drift.windows.samples == 1
    with netcdf_file(tmp_path / "run.nc", mmap=False) as file:
        assert file.version_byte == 2
        assert json.loads(file.provenance)["versions"]["geomint"] == gi.__version__
        assert file.variables["gamma"].dimensions == (time, "k")


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "run.nc"
    made(SHORT[0]).save(path)
    before = path.read_bytes()
    with pytest.raises(TypeError):
        through(made(SHORT[0]), path, {"cannot": object()})
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_matrices_have_rows_and_columns(tmp_path):
    problem = PROBLEMS["ball-on-group-n4:group"]
    solution = made(problem)
    data = solution.to_xarray()
    assert data["g"].dims == ("t", "i", "j")
    np.testing.assert_array_equal(data["g"].values[1], solution.piece("g")[1].reshape(4, 4))
    assert "g[3,2]" in solution.to_dataframe().columns


@gi.field
def still(params, t, y, out, work):
    for i in range(len(y)):
        out[i] = 0.0 * y[i]


NAMES = st.sampled_from(
    ["t", "tau", "k", "k2", "i", "j", "energy", "energy_time", "energy_mean", "k_",
     "energy.time", "γ²", "a b", "x.y",
     "_problem_code", "data", "dimensions", "📈", "params", "E=mc^2"]
)  # fmt: skip
BITS = st.integers(0, 2**64 - 1)


@examples(6, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_names_and_numbers(data, tmp_path):
    names = data.draw(st.lists(NAMES, min_size=1, max_size=3, unique=True))
    pieces = [(name, data.draw(st.integers(1, 3))) for name in names]
    watched = data.draw(st.lists(NAMES, max_size=3, unique=True))
    parameters = data.draw(st.dictionaries(NAMES, st.lists(st.floats(), min_size=1, max_size=3)))
    own, states = data.draw(st.sampled_from(["t", "tau"])), data.draw(st.integers(0, 2))
    problem = gi.Problem("still", pieces, field=still, time=own, parameters=parameters)
    size = states * problem.rows
    bits = data.draw(st.lists(BITS, min_size=size, max_size=size))
    y = np.array(bits, np.uint64).view(np.float64).reshape(states, problem.rows)
    first = data.draw(st.floats(allow_nan=False, allow_infinity=False))
    count = data.draw(st.sampled_from([0, 3]))
    times, values = np.arange(1.0, 4.0)[:count], np.array([1.0, 2.0, np.nan])[:count]
    changes = {"y": y, "drift": {}, "message": data.draw(st.text().filter(_writable))}
    if own == "tau" and data.draw(st.booleans()):
        changes["physical"] = None
    for name in watched:
        changes["drift"][name] = drift_of_series(name, times, values, 1.5, initial=first)
    solution = made(problem, states=states, **changes)
    found = through(solution, tmp_path / "run.nc")
    assert found == solution
    assert found.y.tobytes() == y.tobytes()
    again = through(found, tmp_path / "again.nc")
    assert again == solution
    assert again.about.shapes == problem.shapes
    data = solution.to_xarray()
    assert sum(values.size for values in data.data_vars.values()) >= y.size
    assert len(solution.to_dataframe()) == states


def _writable(text):
    return "\0" not in text and not any("\ud800" <= c <= "\udfff" for c in text)


def test_xarray_opens_files_as_they_are_here(tmp_path):
    import xarray

    problem = PROBLEMS["hamiltonized-n3:hamiltonized"]
    for solution in (made(problem), made(problem, states=0), made(problem, physical=None)):
        solution.save(tmp_path / "run.nc")
        here = solution.to_xarray()
        with xarray.open_dataset(tmp_path / "run.nc") as there:
            for name in here.variables:
                assert there[name].identical(here[name]), name
            assert set(here.coords) <= set(there.coords)
            assert there.attrs["status"] == "success"
            # By these xarray labels its plots: "physical time [1]".
            if solution.physical is not None:
                assert there["t"].attrs == {"long_name": "physical time", "units": "1"}


def test_rows_of_a_dataframe():
    solution = made(PROBLEMS["hamiltonized-n3:hamiltonized"])
    frame = solution.to_dataframe()
    assert list(frame.columns[:4]) == ["tau", "gamma[0]", "gamma[1]", "gamma[2]"]
    assert frame.index.name == "t"
    np.testing.assert_array_equal(frame["gamma[1]"], solution.piece("gamma")[:, 1])


@pytest.mark.parametrize(("library", "name"), [("xarray", "to_xarray"), ("pandas", "to_dataframe")])
def test_without_an_optional_library(monkeypatch, library, name):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(gi.MissingCodeError, match=f"pip install {library}") as error:
        getattr(made(SHORT[0]), name)()
    assert error.value.what == f"Solution.{name}"


@pytest.fixture
def module(tmp_path, monkeypatch):
    (tmp_path / "turning_module.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield importlib.import_module("turning_module")
    sys.modules.pop("turning_module", None)


def test_where_the_code_is_lost(module, tmp_path):
    """All that is numbers can be read; what needs the functions says so, or takes them."""
    problem = module.problem()
    path = tmp_path / "run.nc"
    made(problem).save(path)
    (tmp_path / "turning_module.py").unlink()
    del sys.modules["turning_module"]
    importlib.invalidate_caches()
    found = gi.load(path)
    assert "turn" in repr(found)
    assert found.piece("q").shape == (3, 1)
    assert set(found.to_xarray()) >= {"q", "p", "energy"}
    assert found.plot_drift().axes
    again = through(found, tmp_path / "again.nc")
    assert gi.load(path) == found == again
    again.y[0, 0] += 1.0
    assert found != again
    trusting = gi.load(path, trust=True)
    for one, reason in ((found, "trust=True for a file that"), (trusting, "turning_module")):
        with pytest.raises(gi.MissingCodeError, match=reason) as error:
            one.problem
        assert error.value.what == "problem 'turn'"
        assert "geomint.load(path, problem=…)" in str(error.value)
    with pytest.raises(gi.MissingCodeError):
        gi.solve(found, t_end=1.0)
    assert gi.load(path, problem).problem is problem
    for other in (module.problem(2.0), SHORT[0], "turn"):
        with pytest.raises(gi.DomainError, match="'turn'"):
            gi.load(path, other)


def test_functions_that_have_no_place(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "cloudpickle", None)
    space = {"gi": gi, "__name__": "nowhere"}
    exec(MODULE, space)
    found = through(made(space["problem"]()), tmp_path / "run.nc")
    with pytest.raises(gi.MissingCodeError, match="cloudpickle"):
        found.problem


def test_the_problem_of_a_scene_is_found_by_its_system(tmp_path):
    """Also by a version whose functions are at other places."""
    scene = gi.load_scene("hamiltonized-n3")
    solution = made(scene.problem)
    provenance = {"scene": scene.sections}
    found = through(solution, tmp_path / "run.nc", provenance)
    assert found.problem == scene.problem
    lost = dataclasses.replace(gi.load(tmp_path / "run.nc").about, content=b"nothing", trusted=True)
    assert lost.found(unpickle=True) == scene.problem
    no_such = {"name": "no such"}
    for changes in ({"params": np.zeros(3)}, {"system": no_such}, {"initial": {"x": 1}}):
        with pytest.raises(gi.MissingCodeError):
            dataclasses.replace(lost, **changes).found(unpickle=True)
    assert json.loads(json.dumps(found.provenance)) == json.loads(json.dumps(provenance))


def test_a_loaded_run_goes_on_bit_by_bit(module, tmp_path):
    problem = module.problem()
    run = {"method": gi.RungeKutta("rk-4"), "step": 0.1, "save_every": 1, "compiled": False}
    whole = gi.solve(problem, [1.0, 0.0], t_end=2.0, **run)
    half = through(gi.solve(problem, [1.0, 0.0], t_end=1.0, **run), tmp_path / "half.nc")
    with pytest.raises(gi.MissingCodeError, match=r"geomint\.load"):
        gi.solve(half, t_end=2.0)
    for known in ({"problem": problem}, {"trust": True}):
        half = gi.load(tmp_path / "half.nc", **known)
        rest = gi.solve(half, t_end=2.0, save_every=1, compiled=False)
        assert np.vstack([half.y, rest.y[1:]]).tobytes() == whole.y.tobytes()
        assert rest.method == run["method"]


def test_what_is_too_large_for_the_format(tmp_path):
    """Of states that take no memory: all are the same one."""
    many = made(SHORT[0], states=1)
    y = np.broadcast_to(many.y, (2**29, 6))
    times = np.broadcast_to(many.tau, 2**29)
    with pytest.raises(gi.OutputError, match="save fewer"):
        dataclasses.replace(many, y=y, tau=times, physical=times).save(tmp_path / "run.nc")
    assert list(tmp_path.iterdir()) == []
