"""Every bad input is one message that names the key, the value and what was expected."""

import contextlib
import dataclasses
import re
import tomllib
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from tests.cli.calls import offer
from tests.scene import bad_scenes as scenes

COMMANDS = ["check", "run", "drift", "compare", "scan", "section", "chaos", "warm", "exact"]


def write(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_unchanged_scenes_are_good(tmp_path):
    for text in (scenes.REDUCED, scenes.BALL):
        assert gi.load_scene(write(tmp_path, text)).notes == ()


@pytest.mark.parametrize("name", scenes.BAD)
def test_one_message_from_a_file_from_python_and_from_commands(tmp_path, name):
    text, words = scenes.BAD[name]
    path = write(tmp_path, text)
    with pytest.raises(gi.SceneError) as caught:
        gi.load_scene(path)
    told = [str(caught.value)]
    with contextlib.suppress(ValueError, RecursionError):  # no TOML, or more than Python reads
        content = tomllib.loads(text)
        with pytest.raises(gi.SceneError) as caught:
            gi.Scene(**content)
        told.append(str(caught.value))
    command = COMMANDS[list(scenes.BAD).index(name) % len(COMMANDS)]
    result = CliRunner().invoke(main, [command, str(path)])
    assert (result.exit_code, result.stdout, "Traceback" in result.stderr) == (2, "", False)
    told.append(result.stderr)
    assert [(said, word) for said in told for word in words if word not in said] == []
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize(
    "error", [MemoryError("6 GiB"), OverflowError("34"), np.linalg.LinAlgError()]
)
def test_what_cannot_be_computed_is_a_flaw(monkeypatch, error):
    def build(parameters, initial):
        raise error

    (point,) = entry_points(group="geomint.systems", name="chaplygin-sphere-reduced")
    system = dataclasses.replace(point.load(), name="large", build=build)
    offer(monkeypatch, "geomint.systems", "large", system)
    content = tomllib.loads(scenes.REDUCED.replace("chaplygin-sphere-reduced", "large"))
    with pytest.raises(gi.SceneError, match=r"\[system\] or \[initial\]: .* products are finite"):
        gi.Scene(**content)


def test_flaws_of_all_sections_are_told_together(tmp_path):
    """Unknown keys, those that are missing, wrong values and options of the method."""
    text = scenes.REDUCED.replace("gamma =", "gama =").replace('["energy"]', '["enery"]\nevery = 0')
    text = text.replace("D = 4.0", "D = 4.0\ncolour = 3").replace("t_end", "tend")
    text = text.replace("step = 0.1", "step = -0.1\nmax_iterations = 2.5\nwat = 3")
    text += '[drift]\nquantities = ["areaa"]\nstepp = 3\n[section]\nevnt = "gamma[7]"\n'
    with pytest.raises(gi.SceneError, match="10 problems") as caught:
        gi.load_scene(write(tmp_path, text))
    for words in (
        "[time] tend = 1.0: no such key. Did you mean 't_end'?",
        "[system] colour = 3: no such key.",
        "[initial] gamma is missing: expected a list of numbers",
        "[initial] gama = [0.6, 0.0, 0.8]: no such key. Did you mean 'gamma'?",
        "[integrate] step = -0.1: expected a number > 0",
        "[integrate] max_iterations = 2.5: expected a whole number",
        "[integrate] wat = 3: no such key, nor an option of 'gauss-8'.",
        "[observe] every = 0: expected a number ≥ 1",
        "[drift] stepp = 3: no such key. Did you mean 'step'?",
        "[section] evnt = 'gamma[7]': no such key. Did you mean 'event'?",
    ):
        assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) == 11


def test_what_sections_say_of_one_another_is_told_together(tmp_path):
    text = scenes.REDUCED.replace('["energy"]', '["enery"]\n[observe.measure]\nsteps = 3')
    text = text.replace("step = 0.1", 'step = 0.1\nrepresentation = "redced"')
    text += '[drift]\nmethod = "rk4"\ntau_end = 3.0\nquantities = ["areaa"]\n'
    text += (
        '[events.it]\nwhat = "gama[0]"\n[section]\nevent = "iit"\naxes = ["gamma[0]", "gamma[7]"]\n'
    )
    with pytest.raises(gi.SceneError, match="9 problems") as caught:
        gi.load_scene(write(tmp_path, text))
    for words in (
        "[integrate] representation = 'redced': no such representation",
        "[observe] quantities[0] = 'enery': no such quantity. Did you mean 'energy'?",
        "[observe] measure = {'steps': 3}: 'measure' is observed neither",
        "[drift] method = 'rk4': no such method. Did you mean 'rk-4'?",
        "[drift] tau_end = 3.0: expected t_end",
        "[drift] quantities[0] = 'areaa': no such quantity.",
        "[events.it] what = 'gama[0]': no such component or quantity. Did you mean 'gamma[0]'?",
        "[section] event = 'iit': no such component or quantity. Did you mean 'it'?",
        "[section] axes[1] = 'gamma[7]': no such component or quantity. Did you mean 'gamma[",
    ):
        assert words in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new"),
    [("D = 4.0", "d = 4.0"), ("D = 4.0", 'D = "4"'), ("[0.8, 1.1, 1.5]", "1.0")],
    ids=["unknown key", "value of another kind", "no list"],
)
def test_what_follows_from_a_flaw_is_not_told(tmp_path, old, new):
    """A weight that was misspelt is one flaw, and not what was watched of it another one."""
    text = scenes.changed(old, new).replace('["energy"]', '["all"]\n[observe.measure]\nsteps = 3')
    with pytest.raises(gi.SceneError) as caught:
        gi.load_scene(write(tmp_path, text))
    assert "problems" not in str(caught.value)


def test_a_message_is_short_even_if_the_value_is_long(tmp_path):
    text = scenes.REDUCED + f"[save]\nt_eval = {list(range(1000))}\nevery = {list(range(1000))}\n"
    with pytest.raises(gi.SceneError) as caught:
        gi.load_scene(write(tmp_path, text))
    assert len(str(caught.value)) < 500


def test_sources_that_are_no_scene(tmp_path):
    for name in ("ball3d", "hamiltonised-n3"):
        with pytest.raises(gi.SceneError, match="Did you mean"):
            gi.load_scene(name)
    (tmp_path / "ball.toml").touch()
    with pytest.raises(gi.SceneError, match=r"bal\.toml.*does not exist.*'ball\.toml'"):
        gi.load_scene(tmp_path / "bal.toml")
    (tmp_path / "letters.toml").write_bytes(b'title = "\xff"')
    for path in (tmp_path, tmp_path / "letters.toml"):
        with pytest.raises(gi.SceneError, match="cannot be read"):
            gi.load_scene(path)
    if Path("/dev/zero").exists():
        with pytest.raises(gi.SceneError, match=r"'/dev/zero' is too long: expected at most \d+"):
            gi.load_scene("/dev/zero")


def test_a_byte_order_mark_is_none_of_the_text(tmp_path):
    scene = gi.load_scene(write(tmp_path, "\ufeff" + scenes.REDUCED))
    assert scene.toml() == scenes.REDUCED


SECTIONS = sorted(tomllib.loads(scenes.REDUCED))


def test_damaged_sections_are_told_by_all_commands(tmp_path):
    """Left out, of a wrong kind, empty, a list of tables, twice: one message, exit code 2."""
    whole = scenes.REDUCED
    texts = {"": "[system] is missing", "# nothing": "[time] is missing: expected this section"}
    for name in SECTIONS:
        rest = re.sub(rf"\[{name}\]\n(.+\n)*?(?=\[|$)", "", whole)
        texts[rest] = f"[{name}] is missing" if name in ("system", "time") else ""
        texts |= {f"{name} = {bad}\n{rest}": f"[{name}] = " for bad in ("1", "[]", "[{}]")}
        texts[whole.replace(f"[{name}]", f"[[{name}]]")] = "in single brackets"
        texts[f"{whole}\n[{name}]"] = "twice"
        texts[f"[{name}]\n{rest}"] = ""
    for i, (text, words) in enumerate(texts.items()):
        path = str(write(tmp_path, text))
        with contextlib.suppress(gi.SceneError):
            gi.load_scene(path)
            continue  # what may be left out
        for command in (COMMANDS * 2)[i % len(COMMANDS) :][:2]:
            result = CliRunner().invoke(main, [command, path])
            assert (result.exit_code, type(result.exception)) == (2, SystemExit), (command, text)
            assert words in result.stderr
