"""A few of the cases that `benchmarks/fuzz.py` does by the hundred thousand: none is a traceback."""

from __future__ import annotations

from random import Random

import pytest
from hypothesis import given, strategies as st

import geomint as gi
from tests.fuzz import hostile, judge, scenes
from tests.fuzz.calls import call_verdict, calls
from tests.fuzz.commands import line_verdict
from tests.fuzz.judge import Judged, check_scene, command_verdict, judged, only_finite
from tests.fuzz.saved import file_verdict
from tests.rows import examples

SECONDS = 10.0
RANDOM = st.randoms(use_true_random=False)


@examples(20)
@given(RANDOM)
def test_scenes_are_checked(rng: Random) -> None:
    found = check_scene(scenes.mutated_text(rng), [])
    assert not found.bad, found


@examples(50)
@given(RANDOM)
def test_calls_are_answered(rng: Random) -> None:
    found = call_verdict(rng, SECONDS)
    assert not found.bad, found


@examples(40)
@given(RANDOM)
def test_saved_runs_are_refused_or_read(rng: Random) -> None:
    found = file_verdict(rng)
    assert not found.bad, found


@examples(8)
@given(RANDOM)
def test_commands_lose_and_run_nothing(rng: Random) -> None:
    found = line_verdict(rng, SECONDS)
    assert not found.bad, found


@pytest.mark.nightly
@examples(30)
@given(RANDOM)
def test_scenes_are_run(rng: Random) -> None:
    found = judge.run_scene(scenes.mutated_text(rng, run=True), SECONDS)
    assert not found.bad, found


def test_calls_are_good_before_they_are_changed() -> None:
    for name, call in calls().items():
        found = judged(lambda call=call: call.function(**call.given), only_finite)
        assert found.verdict == "ok" or name == "load", (name, found)


@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_scenes_are_good_before_they_are_changed() -> None:
    for name, content in scenes.originals().items():
        text = scenes.toml_text(scenes.short(content))
        assert gi.load_scene(scenes.tomllib.loads(text)).problem.rows > 0, name


def test_every_section_has_keys_to_mutate() -> None:
    lacking = [name for name, keys in scenes.known_keys().items() if not keys]
    assert lacking == ["title", "description"]


def test_verdicts(tmp_path) -> None:
    def raising(error: BaseException):
        def call() -> None:
            raise error

        return judged(call)

    assert judged(lambda: 1) == Judged("ok")
    assert raising(gi.DomainError("x", 1, "2")).verdict == "typed"
    assert raising(gi.GeomintError("x" * 10**5)).verdict == "typed"
    assert raising(KeyboardInterrupt()).verdict == "interrupted"
    for error in (ValueError("x"), OSError("x"), RecursionError(), MemoryError()):
        assert raising(error).verdict == "traceback"
    assert judged(lambda: float("nan"), lambda x: x == x).verdict == "not finite"
    (tmp_path / "in").mkdir()
    arguments = ["inertia", "--help"]
    assert command_verdict(arguments, tmp_path / "in")[0].verdict == "ok"
    with judge.files_written() as paths:
        (tmp_path / "out").write_text("x")
    assert judge.stray(paths, tmp_path / "in") == [str(tmp_path / "out")]
    assert judge.stray(paths, tmp_path) == []


def test_mutations_are_those_of_their_seed() -> None:
    for make in (scenes.mutated_text, hostile.plain):
        assert repr(make(Random("a"))) == repr(make(Random("a")))
    assert len({scenes.mutated_text(Random(i)) for i in range(50)}) > 40
