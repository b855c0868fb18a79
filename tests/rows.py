"""What the rows of tests take: examples of a property, and compiled code, of which a ledger is kept.

Most of the time of the tests goes into compilations. `ledger.toml` says of how many functions of each
family the fast row may ask for compiled code, and of how many megabytes, found in the cache or not.
The row fails above that, and says what to use instead. ``pytest --ledger`` writes the ledger anew.
"""

from __future__ import annotations

import math
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from hypothesis import settings

FEW, MANY = 10, 250
LEDGER = Path(__file__).with_name("ledger.toml")
REST = "functions of problems"
SPARE = 1.15  # machine code of other processors is larger


def examples(count: int, **options: Any) -> settings:
    """Take `count` examples in the fast row, and as many times more at night."""
    return settings(max_examples=count * settings.default.max_examples // FEW, **options)


class Ledger:
    """Keeps the names of all files of compiled code that the processes of a row ask for."""

    def __init__(self, config: pytest.Config) -> None:
        self.bytes: dict[str, int] = {}  # by file
        self.known: dict[str, dict[str, Any]] = tomllib.loads(LEDGER.read_text("utf-8"))
        self.over: list[str] = []
        if not config.getoption("numprocesses", None):
            self.listen()

    def listen(self) -> None:
        """Keep the names that are asked for in this process."""
        from geomint.kernels.compiling.cache import KeptCode

        begin = KeptCode.__init__

        def begun(kept: Any, *given: Any) -> None:
            begin(kept, *given)
            self.bytes[kept.name] = 0

        KeptCode.__init__ = begun  # type: ignore[method-assign]

    def weigh(self) -> None:
        from geomint.kernels.compiling.cache import cache_folder

        for path in (cache_folder().path / file for file in self.bytes):
            self.bytes[path.name] = path.stat().st_size if path.exists() else 0

    def pytest_testnodedown(self, node: Any) -> None:
        self.bytes.update(getattr(node, "workeroutput", {}).get("ledger", {}))

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        config = session.config
        if not config.getoption("numprocesses", None):
            self.weigh()
        if hasattr(config, "workeroutput"):
            config.workeroutput["ledger"] = self.bytes
        elif config.option.ledger:
            self.write()
        elif whole(config) and not session.testsfailed:
            self.compare()
            session.exitstatus = pytest.ExitCode.TESTS_FAILED if self.over else session.exitstatus

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        for line in self.over:
            terminalreporter.write_line(line, red=True)

    def found(self) -> dict[str, tuple[int, float]]:
        """Return compilations and megabytes of every family."""
        counts, sizes = Counter[str](), Counter[str]()
        for file, size in self.bytes.items():
            family = file.partition("-")[0]
            family = family if family in self.known else REST
            counts[family] += 1
            sizes[family] += size
        return {family: (counts[family], sizes[family] / 1e6) for family in self.known}

    def compare(self) -> None:
        for family, (count, size) in self.found().items():
            most = self.known[family]
            if count > most["compilations"] or size > SPARE * most["megabytes"]:
                self.over.append(
                    f"ledger: {count} compilations of {family}, {size:.2f} MB: at most "
                    f"{most['compilations']} and {most['megabytes']}; {most['instead']}"
                )

    def write(self) -> None:
        for family, (count, size) in self.found().items():
            most = math.ceil(1.03 * count)  # who asks first may ask for a function more
            self.known[family] |= {"compilations": most, "megabytes": round(1.03 * size, 2)}
        LEDGER.write_text(tomli_w.dumps(self.known), "utf-8")


def whole(config: pytest.Config) -> bool:
    """Tell whether this is the fast row, all of it."""
    option = config.option
    return (
        config.args == config.getini("testpaths")
        and option.markexpr == "not nightly"
        and not (option.keyword or option.deselect or option.ignore or option.lf)
    )
