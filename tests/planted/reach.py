"""Keeps which files of tests run which lines of the code, and for how long each of them runs.

    pytest -p tests.planted.reach --reach FILE.json

Lines that run in other processes, or compiled alone, are not seen.
"""

from __future__ import annotations

import json
import os
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from coverage import Coverage

from tests.planted.faults import ROOT

SOURCES = ROOT / "src"


class Reach:
    """Which lines of a file of the code each file of tests runs; seconds of a file of tests."""

    def __init__(self, config: pytest.Config) -> None:
        self.lines: dict[str, dict[str, set[int]]] = defaultdict(lambda: defaultdict(set))
        self.seconds = Counter[str]()
        alone = not config.known_args_namespace.numprocesses
        self._traced = alone or "PYTEST_XDIST_WORKER" in os.environ
        self._coverage = Coverage(data_file=None, source=[str(SOURCES)], config_file=False)
        if self._traced:
            self._coverage.start()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self._coverage.switch_context(item.location[0])
        return (yield)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.location[0]] += report.duration

    def pytest_testnodedown(self, node: Any) -> None:
        self._add(json.loads(node.workeroutput["reach"]))

    def _add(self, found: Iterable[tuple[str, str, list[int]]]) -> None:
        for file, tests, lines in found:
            self.lines[file][tests] |= {*lines}

    def _traces(self) -> Iterator[tuple[str, str, list[int]]]:
        data = self._coverage.get_data()
        for file in data.measured_files():
            for context in data.measured_contexts():
                data.set_query_context(context)
                yield str(Path(file).relative_to(ROOT)), context, data.lines(file) or []

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self._traced:
            self._coverage.stop()
            self._add(self._traces())
        told = [
            (f, t, [*lines]) for f, by in self.lines.items() for t, lines in by.items() if lines
        ]
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput["reach"] = json.dumps(told)
        else:
            found = {"lines": told, "seconds": self.seconds}
            Path(session.config.option.reach).write_text(json.dumps(found), "utf-8")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--reach", metavar="FILE")


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> None:
    """Begin before any test or `conftest.py` imports the code."""
    early_config.pluginmanager.register(Reach(early_config), "reach")
