"""What the README's examples print."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi

README = Path(__file__).parent.parent / "README.md"


def example(word: str) -> str:
    """Return the one Python example that contains a word."""
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.S)
    (found,) = (block for block in blocks if word in block)
    return found


def test_the_pendulum(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """From rest, by the default method and step: what is printed, and what SciPy says."""
    source = example("pendulum")
    path = tmp_path / "pendulum.py"
    path.write_text(source, encoding="utf-8")
    exec(compile(source, str(path), "exec"), {"__name__": "example"})
    printed = capsys.readouterr().out.strip()
    assert printed == source.rsplit("# ", 1)[1].strip()
    exact = solve_ivp(
        lambda t, y: [y[1], -np.sin(y[0])], (0, 100), [2, 0], "DOP853", rtol=1e-12, atol=1e-12
    ).y[:, -1]
    np.testing.assert_allclose(np.array(printed.strip("[]").split(), float), exact, atol=2e-8)


def test_the_sphere() -> None:
    """Runs, and prints the two warnings that the README shows."""
    source = example("chaplygin as ch")
    said = re.search(r"prints two warnings.*?```\n(.*?)```", README.read_text("utf-8"), re.S)
    assert said is not None
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        lines = [line for line in source.splitlines() if "plot_drift" not in line]
        scope: dict[str, object] = {}
        exec("\n".join(lines), scope)
    told = [f"{w.category.__name__}: {w.message}" for w in caught]
    assert told == said.group(1).strip().splitlines()
    sol = scope["sol"]
    assert isinstance(sol, gi.Solution)
    assert sol.drift["energy"].max_abs_error < 1e-13
