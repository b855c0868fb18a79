"""Processes that hang, die or raise: told as such, and the rest is done all the same."""

import math
import os
import time

import pytest

from geomint.stress.guard import guarded


def outcomes(function, groups, seconds=30.0):
    return list(guarded(function, groups, seconds=seconds, workers=2))


def test_a_hang_costs_its_own_item_only():
    begun = time.monotonic()
    found = outcomes(time.sleep, [[0.0, 1000.0, 0.001]], seconds=2.0)
    assert [(o.item, o.ending) for o in found] == [(0.0, "done"), (1000.0, "hung"), (0.001, "done")]
    assert time.monotonic() - begun < 900.0
    assert "after" in found[1].message


def test_a_process_that_dies():
    found = outcomes(os._exit, [[3], [4]])
    assert sorted((o.item, o.ending) for o in found) == [(3, "died"), (4, "died")]
    assert {o.message for o in found} == {
        "the process ended with code 3",
        "the process ended with code 4",
    }


def test_values_and_exceptions():
    found = outcomes(math.sqrt, [[4.0, -1.0], [9.0], []])
    by_item = {o.item: o for o in found}
    assert by_item[4.0].value == 2.0
    assert by_item[9.0].value == 3.0
    assert by_item[-1.0].ending == "raised"
    assert by_item[-1.0].message.startswith("ValueError")


def test_memory_is_limited():
    pytest.importorskip("resource")
    found = list(guarded(bytearray, [[1 << 36]], seconds=30.0, workers=1, memory=8 << 30))
    assert found[0].ending == "raised"
    assert found[0].message.startswith("MemoryError")


def test_stopping_early_leaves_no_process():
    import multiprocessing

    work = guarded(time.sleep, [[0.0, 1000.0]], seconds=1000.0, workers=1)
    assert next(work).ending == "done"
    work.close()
    assert not multiprocessing.active_children()
