"""Ensembles on disk: as in memory, going on where they were broken off, never mixed with others."""

from __future__ import annotations

import functools
import itertools
import json
import math
import shutil
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run.ensemble import spread
from geomint.run.ensemble.store import store

HENON = henon_heiles.problem()
STATES = np.random.default_rng(1).uniform(-0.2, 0.2, (40, 4))
STATES[7] = [0.0, 40.0, 0.0, 60.0]  # escapes
RUN: dict[str, Any] = {"t_end": 6.0, "method": "rk-4", "step": 0.05, "save_every": 10}
KINDS: dict[str, dict[str, Any]] = {
    "states": {},
    "readings": {
        "readings": ["drift:energy", gi.Windows("energy", 8), gi.Histogram("q[0]", [-1, 0, 1])]
    },
    "ends": {"save_every": None},
    "events": {"observe": ["energy"], "events": "q[1]"},
    "times": {"t_eval": np.linspace(0.0, 6.0, 7)},
    "adaptive": {"method": "dop853-adaptive", "step": None, "save_every": 1},
    "errors": {"estimate_error": True},
}


@functools.cache
def in_memory(kind: str) -> gi.Ensemble:
    return gi.solve_ensemble(HENON, STATES, **{**RUN, **KINDS[kind]})


def on_disk(kind: str, out: Any, **more: Any) -> gi.Ensemble:
    return gi.solve_ensemble(HENON, STATES, **{**RUN, **KINDS[kind], **more}, out=out)


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spread, "EACH_STREAMED", 4)
    monkeypatch.setattr(spread, "LEAST", 16)


@pytest.fixture
def kept(tmp_path_factory: Any, tmp_path: Path) -> Callable[[str], Path]:
    """Return copies of stores, each of which is written once."""

    def copied(kind: str) -> Path:
        whole = tmp_path_factory.getbasetemp() / f"{kind}.zarr"
        if not whole.exists():
            on_disk(kind, whole)
        return shutil.copytree(whole, tmp_path / "a.zarr")

    return copied


def told(many: gi.Ensemble) -> dict[int, tuple[Any, ...]]:
    return {k: (type(e), str(e), e.step, e.t) for k, e in many.errors.items()}


def assert_same(one: gi.Ensemble, other: gi.Ensemble) -> None:
    """Assert that all is the same: states, drifts and readings are in the dataset."""
    for name in ("final", "counts", "steps", "status", "error_estimate"):
        known, found = np.array(getattr(one, name)), np.array(getattr(other, name))
        assert known.dtype.kind == found.dtype.kind
        np.testing.assert_array_equal(known, found)
    assert told(one) == told(other)
    assert one.events == other.events
    assert one.to_xarray().equals(other.to_xarray())


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sizes of the blocks that are computed, smaller ones than else."""
    sizes: list[int] = []
    run = spread.run_block
    seen = lambda *given: sizes.append(len(given[1])) or run(*given)  # noqa: E731
    monkeypatch.setattr(spread, "run_block", seen)
    monkeypatch.setattr(spread, "LEAST", 8)
    return sizes


@pytest.mark.parametrize("kind", KINDS)
def test_as_in_memory_and_without_its_code(kind: str, tmp_path: Path) -> None:
    known, found = in_memory(kind), on_disk(kind, tmp_path / "a.zarr")
    assert_same(known, found)
    seen = gi.open_ensemble(tmp_path / "a.zarr")
    assert_same(known, seen)
    assert np.array_equal(seen.states, STATES)
    assert "henon-heiles" in repr(seen)
    assert np.array_equal(found.single(3).y[-1], known.final[3])
    with pytest.raises(gi.MissingCodeError, match="a store has no code"):
        seen.single(3)


@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=[pytest.mark.nightly] * (i > 1)) for i, k in enumerate(KINDS)]
)
@pytest.mark.parametrize("end", [KeyboardInterrupt, RuntimeError, OSError])
def test_going_on(
    kind: str, end: type[BaseException], tmp_path: Path, counted: list[int], monkeypatch: Any
) -> None:
    """Where the writer was interrupted or failed, or the disk was full."""
    out, blocks = tmp_path / "a.zarr", itertools.count()
    of, name = (store.Arrays, "sync") if end is OSError else (store.Store, "take")
    whole = getattr(of, name)

    def ending(*given: Any) -> None:
        if next(blocks) == 1:
            raise end(28, "No space left on device")
        whole(*given)

    with monkeypatch.context() as patched:
        patched.setattr(of, name, ending)
        if end is KeyboardInterrupt:
            part = on_disk(kind, out)
            some = part.status != "not run"
            np.testing.assert_array_equal(part.final[some], in_memory(kind).final[some])
        else:
            with pytest.raises(gi.OutputError if end is OSError else end, match="No space left"):
                on_disk(kind, out)
    done = int((gi.open_ensemble(out).status != "not run").sum())
    assert 0 < done < len(STATES)
    known = in_memory(kind)
    counted.clear()
    assert_same(known, on_disk(kind, out, workers=1))
    assert sum(counted) == len(STATES) - done
    counted.clear()
    assert_same(known, on_disk(kind, out, workers=3))
    assert not counted, "failed members neither"


@pytest.mark.parametrize("readings", [(), ["final:energy", gi.Histogram("q[0]", [-1, 0, 1])]])
def test_ctrl_c_within_blocks(
    readings: Any, tmp_path: Path, counted: list[int], monkeypatch: Any, ctrl_c: Any
) -> None:
    """Members of a block that are done stay; where something was to be read, whole blocks."""
    run: dict[str, Any] = {**RUN, "events": "q[1]", "t_end": 40.0, "readings": readings}
    known = gi.solve_ensemble(HENON, STATES, **run)
    out, run_block, calls = tmp_path / "a.zarr", spread.run_block, itertools.count()

    def stopped(*given: Any) -> Any:
        if next(calls) == 2 * spread.cores() - 1:  # others are under way, one at least is done
            ctrl_c()
        return run_block(*given)

    with monkeypatch.context() as patched:
        patched.setattr(spread, "LOOK", 0.002)
        patched.setattr(spread, "run_block", stopped)
        part = gi.solve_ensemble(HENON, STATES, **run, out=out)
    done = int((part.status != "not run").sum())
    assert 0 < done < len(STATES)
    assert not readings or done % 8 in (0, len(STATES) % 8)
    counted.clear()
    found = gi.solve_ensemble(HENON, STATES, **run, out=out)
    assert_same(known, found)
    assert sum(counted) == len(STATES) - done


# --- other ensembles ------------------------------------------------------------------------------


class Held(gi.Reading):
    """A reading of one's own that holds a value."""

    name = "held"

    def __init__(self, value: Any) -> None:
        self.value = value

    def read(self, ran: Any) -> Any:
        return np.ones(len(ran))


def named(k: int) -> Any:
    function = lambda x: k * x  # noqa: E731
    function.__module__ = "numpy"
    return function


# By k, and for the same k in two ways.
HELD: dict[str, Callable[[int, bool], Any]] = {
    "code": lambda k, again: eval(f"lambda x: {k} * x"),
    "closure": lambda k, again: lambda x: k * x,
    "closure of a library's": lambda k, again: named(k),
    "number": lambda k, again: 1.5 + k if again else np.float64(1.5 + k),
    "set": lambda k, again: set((8 + k, 0)[:: -1 if again else 1]),
    "kind": lambda k, again: ([[0]], ([0],))[k],
    "found by its name": lambda k, again: (np.sin, np.cos)[k],
    "module": lambda k, again: (np, math)[k],
    "property": lambda k, again: type("Own", (), {"f": property(lambda own: k)}),
    "static": lambda k, again: type("Own", (), {"f": staticmethod((abs, max)[k])}),
    "base": lambda k, again: type("Own", ((Path, list)[k],), {}),
    "class": lambda k, again: type(f"Own{k}", (), {}),
}


OTHERS: list[tuple[dict[str, Any], str]] = [
    ({"states": STATES + 1e-16}, "states"),
    ({"states": STATES[:9]}, "40 there, 9 asked for"),
    ({"problems": replace(HENON, name="other")}, "henon-heiles there, other asked for"),
    ({"problems": replace(HENON, invariants={})}, "functions of the problem"),
    ({"step": 0.1}, r"step \(0.05 there, 0.1 asked for\)"),
    ({"t_end": 7}, r"t_end \(6.0 th"),
    ({"method": "gauss-2"}, "method"),
    ({"readings": "final:energy"}, r"readings \(none there, final:energy asked for\), keep_states"),
    ({"events": "q[0]"}, "events"),
]


def files(out: Path) -> dict[Path, bytes]:
    return {file: file.read_bytes() for file in out.rglob("*") if file.is_file()}


def test_another_ensemble_is_told_and_left_alone(
    kept: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Members too that begin where those of the store end, read from it.

    And the same one otherwise written is there already; other versions are others.
    """
    out, version = kept("states"), metadata.version
    known, before = gi.open_ensemble(out), files(out)
    ends = {"states": np.nan_to_num(known.final)}
    for given, said in (*OTHERS, (ends, "another ensemble is there")):
        asked = {"problems": HENON, "states": STATES, **RUN, **given}
        with pytest.raises(gi.OutputError, match=said):
            gi.solve_ensemble(asked.pop("problems"), asked.pop("states"), **asked, out=out)
    assert_same(in_memory("states"), gi.solve_ensemble(HENON, known.states, **RUN, out=out))
    on_disk("states", out, t_end=6, step=np.float64(0.05))
    other = {"numba": "0.99"}
    monkeypatch.setattr(metadata, "version", lambda name: other.get(name) or version(name))
    with pytest.raises(gi.OutputError, match=r"versions \(geomint.*numba 0.99.* asked for"):
        on_disk("states", out)
    assert before == files(out)


def test_a_reading_that_has_changed(tmp_path: Path) -> None:
    """In one of the values that it holds; made anew it is the same."""

    def run(again: bool, other: str = "") -> None:
        held = Held({what: make(what == other, again) for what, make in HELD.items()})
        asked = {**RUN, "t_end": 0.5, "readings": held}
        gi.solve_ensemble(HENON, STATES[:1], **asked, out=tmp_path / "a")

    run(False)
    run(True)
    for other in HELD:
        with pytest.raises(gi.OutputError, match="readings"):
            run(True, other)


def test_parameters_of_members(tmp_path: Path) -> None:
    def spheres(*values: float) -> list[gi.Problem]:
        return [ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=d).hamiltonized() for d in values]

    state = spheres(2.0)[0].random_state(1)
    run: dict[str, Any] = {"tau_end": 2.0, "method": "rk-4", "out": tmp_path / "a.zarr"}
    many = gi.solve_ensemble(spheres(2.0, 3.0, 4.0), state, **run)
    for seen in (many, gi.open_ensemble(tmp_path / "a.zarr")):
        assert list(seen.to_xarray()["D"]) == [2.0, 3.0, 4.0]
    again = gi.solve_ensemble(spheres(2.0, 3.0, 4.0), state, **run)
    assert np.array_equal(again.final, many.final)
    with pytest.raises(gi.OutputError, match=r"differ in parameters$"):
        gi.solve_ensemble(spheres(2.0, 3.5, 4.0), state, **run)


def test_exact_motions(tmp_path: Path) -> None:
    """Their functions are made of much more than compiled code: made anew they are the same."""
    for _ in range(2):
        sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
        states = np.array([sphere.random_state(seed) for seed in range(3)])
        run: dict[str, Any] = {"tau_eval": [0.0, 1.0, 2.0], "tau_end": 2.0, "method": "exact"}
        many = gi.solve_ensemble(sphere, states, **run, out=tmp_path / "a.zarr")
        assert np.array_equal(many.y, gi.solve_ensemble(sphere, states, **run).y)


# --- places ---------------------------------------------------------------------------------------


def test_places_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("folder", "here"):
        (tmp_path / folder).mkdir()
    for mine in ("file", "folder/mine"):
        (tmp_path / mine).write_text("mine")
    monkeypatch.chdir(tmp_path / "here")
    for out, said in (
        (tmp_path / "file", "no folder"),
        (tmp_path / "file" / "below", "no folder"),
        (tmp_path / "folder", "something else"),
        ("", "empty name"),
        ("a\0b", "null"),
        (".", "current folder"),
    ):
        with pytest.raises(gi.OutputError, match=said):
            on_disk("states", out)
    for wrong, more in ((7, {}), ("s3://bucket/a.zarr", {}), (tmp_path / "a", {"step": -1.0})):
        with pytest.raises(gi.DomainError):
            on_disk("states", wrong, **more)
    assert not (tmp_path / "a").exists()
    assert (tmp_path / "file").read_text() == (tmp_path / "folder" / "mine").read_text() == "mine"


def test_of_what_is_in_a_store_only_what_zarr_left_is_removed(kept: Any) -> None:
    out = kept("states")
    left = out / "states" / f"c.{'0a' * 16}.partial"
    linked, folder = (out / f"{name}.{'0c' * 16}.partial" for name in ("linked", "folder"))
    (out / "films").mkdir()
    mine = [out / "mine.partial", out / ("0b" * 16), out / "films" / f"film.{'0e' * 16}.partial"]
    for path in (left, *mine):
        path.touch()
    linked.symlink_to(mine[0])
    folder.mkdir()
    assert_same(on_disk("states", out), in_memory("states"))
    assert not left.exists()
    assert all(path.exists() for path in (*mine, linked, folder))


def test_a_writer_is_alone(tmp_path: Path, counted: list[int], monkeypatch: Any) -> None:
    """And workers that are faster than the disk wait for it."""
    out, take = tmp_path / "a.zarr", store.Store.take
    begun: list[int] = []
    written: list[int] = []

    class Pool(ThreadPoolExecutor):
        def submit(self, *given: Any, **named: Any) -> Any:
            if not begun:
                with pytest.raises(gi.OutputError, match="somebody else is writing"):
                    on_disk("states", out)
            begun.append(1)
            return super().submit(*given, **named)

    def slow(*given: Any) -> None:
        take(*given)
        assert len(begun) - len(written) <= spread.AHEAD * 2
        written.append(1)

    monkeypatch.setattr(store.Store, "take", slow)
    monkeypatch.setattr(spread, "AHEAD", 1)
    with Pool(2) as pool:
        assert on_disk("states", out, executor=pool, workers=2).status[0] == "success"
    assert len(written) > 2 * spread.AHEAD * 2


def test_what_is_no_ensemble(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patched:
        patched.setitem(sys.modules, "zarr", None)
        for call in (lambda path: on_disk("states", path), gi.open_ensemble):
            with pytest.raises(gi.MissingCodeError, match=r"geomint\[zarr\]"):
                call(tmp_path / "a.zarr")
    for path in (tmp_path, tmp_path / "nothing", "a\0b"):
        with pytest.raises(gi.GeomintError, match=r"holds no ensemble|null"):
            gi.open_ensemble(path)
    with pytest.raises(gi.DomainError):
        gi.open_ensemble(7)  # type: ignore[arg-type]


def _changed(path: Path, change: Callable[[Any], None]) -> None:
    told = json.loads(path.read_text())
    change(told)
    path.write_text(json.dumps(told))


def _of_format_2(folder: Path) -> None:
    folder.mkdir(exist_ok=True)
    (folder / ".zarray").write_text('{"zarr_format": 2, "filters": [{"id": "pickle"}]}')


def _gathered(told: Any) -> None:
    told["consolidated_metadata"]["metadata"]["status"].update(zarr_format=2)


PICKLE = {"name": "numcodecs.pickle", "configuration": {"id": "pickle"}}
LAYOUTS: dict[str, Callable[[Path], None]] = {
    "root": _of_format_2,
    "member": lambda out: _of_format_2(out / "more"),
    "gathered": lambda out: _changed(out / "zarr.json", _gathered),
    "format": lambda out: _changed(out / "y" / "zarr.json", lambda t: t.update(zarr_format=2)),
    "codec": lambda out: _changed(out / "y" / "zarr.json", lambda t: t["codecs"].append(PICKLE)),
    "bytes": lambda out: _changed(
        out / "status" / "zarr.json", lambda told: told.update(data_type="variable_length_bytes")
    ),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_another_layout_is_refused_before_it_is_read(
    layout: str, kept: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By those who look and by those who go on: Zarr, which may unpickle, does not see it."""
    zarr, out = pytest.importorskip("zarr"), kept("states")
    LAYOUTS[layout](out)
    monkeypatch.setattr(zarr, "open_group", lambda *a, **k: pytest.fail("Zarr reads it"))
    for look in (gi.open_ensemble, lambda path: on_disk("states", path)):
        with pytest.raises(gi.GeomintError, match=r"format 3|damaged"):
            look(out)


@pytest.mark.parametrize("broken", ["y/zarr.json", "y/c.0.0.0", "status/c.0", "states/c.0.0"])
def test_a_damaged_file_is_one_error_that_names_it(broken: str, kept: Any) -> None:
    """A chunk of no bytes is what power has left half written: it is computed again."""
    out = kept("readings")
    if broken.startswith("status"):
        (out / "status" / "c.1").write_bytes(b"")
        assert_same(in_memory("readings"), on_disk("readings", out))
    (out / broken).write_bytes(b"nonsense")
    with pytest.raises(gi.GeomintError, match=r"a\.zarr.*is damaged"):
        assert len(gi.open_ensemble(out).status) == len(gi.open_ensemble(out).final)


@pytest.mark.parametrize("lost", ["block", "members", "identity"])
def test_a_store_that_lacks_what_it_is(lost: str, kept: Any) -> None:
    out = kept("readings")
    _changed(out / "zarr.json", lambda told: told["attributes"].pop(lost))
    with pytest.raises(gi.GeomintError, match=r"damaged|another ensemble"):
        on_disk("readings", out)


def test_parts_of_arrays_and_xarray(kept: Any) -> None:
    xarray, out = pytest.importorskip("xarray"), kept("readings")
    many, known = gi.open_ensemble(out), in_memory("readings")
    assert np.array_equal(many.stored["y"][3:5], known.y[3:5])
    assert known.stored is None
    data = xarray.open_zarr(out)
    assert np.array_equal(data["y"].values, known.y, equal_nan=True)
    assert np.array_equal(data["y"].sel(row="p[1]").values, known.y[:, :, 3], equal_nan=True)
    assert list(data["status"].values) == list(known.status)
    (out / ".geomint-left").mkdir()  # of a killed process: no warning
    assert np.array_equal(gi.open_ensemble(out).steps, known.steps)
    drift = data["drift_energy"].values
    assert np.array_equal(drift, known.readings["drift:energy"], equal_nan=True)
    whole = data["histogram_q[0]"].sum("block").values
    assert np.array_equal(whole, known.readings["histogram:q[0]"])
    assert data.attrs["problem"] == "henon-heiles"
    assert set(data.coords) == {"tau", "t", "row"}


def test_members_with_more_states_than_those_before(tmp_path: Path, counted: list[int]) -> None:
    """Arrays are widened on the way."""
    states = STATES[np.argsort(np.abs(STATES).sum(axis=1))]
    run: dict[str, Any] = {"t_end": 20.0, "method": "dop853-adaptive", "save_every": 1}
    run |= {"events": "q[1]"}
    known = gi.solve_ensemble(HENON, states, **run)
    found = gi.solve_ensemble(HENON, states, **run, out=tmp_path / "a.zarr", workers=1)
    assert_same(known, found)
    assert found.counts[:8].max() < found.counts.max()
