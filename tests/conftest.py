"""Settings of the test run.

Compiled code is kept in the user's cache folder, or where ``NUMBA_CACHE_DIR`` says, under a stamp of
the sources: a second run compiles nothing. ``SHARE=2/3`` in the environment runs the second third of
the files, of those that a command asks for.
"""

from __future__ import annotations

import os
import zlib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import is_hypothesis_test, settings

from tests.rows import FEW, MANY, Ledger

# The same examples in every run; HYPOTHESIS_PROFILE=explore looks for new ones.
SAME = {"derandomize": True, "deadline": None, "database": None}
settings.register_profile("fast", max_examples=FEW, **SAME)
settings.register_profile("nightly", max_examples=MANY, **SAME)
settings.register_profile("explore", deadline=None, max_examples=1000)


def at_night(config: pytest.Config) -> bool:
    """Tell whether `pytest -m nightly` was called, or ``-m ""``, which is all."""
    return config.option.markexpr in ("nightly", "")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let the ledger be written."""
    parser.addoption("--ledger", action="store_true", help="write tests/ledger.toml anew")


def pytest_configure(config: pytest.Config) -> None:
    """Take few examples of a property, at night many; keep the ledger of compilations.

    Each worker keeps to a core: it starts no second process that compiles for it.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if worker and hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {cores[int(worker[2:]) % len(cores)]})
    config.pluginmanager.register(Ledger(config), "ledger")
    row = "nightly" if at_night(config) else "fast"
    settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", row))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the share of the files that is asked for: whole files, as they share compiled code.

    Properties belong to both rows.
    """
    for item in items if at_night(config) else ():
        if is_hypothesis_test(getattr(item, "function", None)):
            item.add_marker(pytest.mark.nightly)
    one, of = (int(number) for number in os.environ.get("SHARE", "1/1").split("/"))
    if of > 1:
        kept = {x for x in items if zlib.crc32(x.location[0].encode()) % of == one % of}
        config.hook.pytest_deselected(items=[x for x in items if x not in kept])
        items[:] = [x for x in items if x in kept]


@pytest.fixture
def short_chains(monkeypatch: pytest.MonkeyPatch) -> None:
    """End the chains of draws after a few moves: where nothing is asked of their distribution."""
    from geomint.run import chains

    for name, value in (("PILOT", 5), ("PILOTS", 1), ("FORGET", 0.0)):
        monkeypatch.setattr(chains, name, value)


@pytest.fixture
def blank_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write files of pictures without drawing them: where nobody looks at what they show."""
    from matplotlib.figure import Figure

    from geomint.plots import style
    from geomint.reports import latex

    def blank(figure: Figure, to: Any, **_: Any) -> None:
        if not hasattr(to, "write"):
            Path(to).touch()

    monkeypatch.setattr(Figure, "savefig", blank)
    monkeypatch.setattr(style.Picture, "_lay_out", lambda picture: None)
    monkeypatch.setattr(latex, "_fit_legends", lambda figure: None)
