"""Runs on disk: what is written comes back, and bad files are refused."""

import json

import numpy as np
import pytest
from scipy.io import netcdf_file

import geomint as gi
from geomint.run.storage import save_solution


@pytest.fixture(scope="module")
def solution():
    scene = gi.load_scene("hamiltonized-n3").changed(time={"tau_end": 100.0}, save={"every": 10})
    return gi.run_scene(scene, progress=False)


@pytest.fixture
def path(solution, tmp_path):
    solution.save(tmp_path / "run.nc")
    return tmp_path / "run.nc"


def test_round_trip(solution, path):
    saved = gi.load(path)
    assert saved == solution
    np.testing.assert_array_equal(saved.piece("p_tilde"), solution.piece("p_tilde"))
    for name, drift in solution.drift.items():
        again = saved.drift[name]
        assert again.as_json() == drift.as_json()
        assert again.windows.length == drift.windows.length
        np.testing.assert_array_equal(again.windows.times, drift.windows.times)
        np.testing.assert_array_equal(again.windows.means, drift.windows.means)
        np.testing.assert_array_equal(again.windows.maxima, drift.windows.maxima)
    assert saved.provenance["method"] == "gauss-8"
    assert saved.provenance["steps"] == solution.steps
    with pytest.raises(gi.DomainError, match="gamma"):
        saved.piece("gama")


def test_a_saved_run_plots_like_the_run(solution, path):
    assert len(gi.load(path).plot_drift().axes) == len(solution.plot_drift().axes)


def test_any_netcdf_reader_can_read_it(path):
    with netcdf_file(path, "r", mmap=False) as file:
        assert file.version_byte == 2
        assert json.loads(file.provenance)["versions"]["geomint"] == gi.__version__
        assert file.variables["energy_mean"].units == b"1"


def test_without_physical_time(tmp_path):
    scene = gi.load_scene("hamiltonized-n3").changed(time={"tau_end": 2.0})
    gi.make_plan(scene, "drift").solve(progress=False).save(tmp_path / "run.nc")
    saved = gi.load(tmp_path / "run.nc")
    assert saved.physical is None
    with netcdf_file(tmp_path / "run.nc", mmap=False) as file:
        assert file.variables["gamma"].dimensions == ("tau", "k")


def test_nothing_watched_and_a_run_of_one_step(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(
        time={"t_end": 0.1}, observe={"quantities": []}, integrate={"step": 0.1}
    )
    gi.run_scene(scene, progress=False).save(tmp_path / "run.nc")
    saved = gi.load(tmp_path / "run.nc")
    assert saved.drift == {}
    assert saved.y.shape == (1, 6)


def test_a_run_that_is_shorter_than_a_window(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(time={"t_end": 0.5})
    gi.run_scene(scene, progress=False).save(tmp_path / "run.nc")
    assert gi.load(tmp_path / "run.nc").drift["energy"].windows.samples == 1


@pytest.mark.parametrize("content", [b"", b"CDF", b"not a netcdf file at all", b"\x89HDF\r\n"])
def test_a_file_of_another_kind(tmp_path, content):
    path = tmp_path / "run.nc"
    path.write_bytes(content)
    with pytest.raises(gi.GeomintError, match=r"run\.nc"):
        gi.load(path)


def test_a_netcdf_file_of_somebody_else(tmp_path):
    path = tmp_path / "run.nc"
    with netcdf_file(path, "w") as file:
        file.title = "weather"
    with pytest.raises(gi.GeomintError, match="no run of geomint"):
        gi.load(path)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_truncated_file(path, share):
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(gi.GeomintError, match=r"run\.nc"):
        gi.load(path)


def test_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        gi.load(tmp_path / "nothing.nc")


def test_a_failed_write_leaves_the_old_file(path, solution):
    before = path.read_bytes()
    with pytest.raises(TypeError):
        save_solution(solution, path, {"cannot": object()})
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]
