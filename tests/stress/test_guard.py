"""Processes that hang, die or raise: told as such, and the rest is done all the same."""

import multiprocessing
import time

from geomint.stress.guard import guarded


def test_every_ending_costs_its_own_item_only():
    """Items are done in processes of their own: here words of Python."""
    hang, die = "__import__('time').sleep(1000)", "__import__('os')._exit({})"
    large = "bytearray(1 << 36)"
    items = ["2.0", hang, "3.0", die.format(4), "1 / 0", large, "9.0"]
    given = {"seconds": 1.0, "workers": 2, "memory": 8 << 30}
    found = {o.item: o for o in guarded(eval, items, **given)}
    endings = {item: outcome.ending for item, outcome in found.items()}
    done = dict.fromkeys(("2.0", "3.0", "9.0"), "done")
    raised = dict.fromkeys(("1 / 0", large), "raised")
    assert endings == done | raised | {hang: "hung", die.format(4): "died"}
    assert [found[item].told for item in done] == [2.0, 3.0, 9.0]
    assert "after" in found[hang].told
    assert found[die.format(4)].told == "the process ended with code 4"
    assert found["1 / 0"].told.startswith("ZeroDivisionError")
    assert found[large].told.startswith("MemoryError")


def test_stopping_early_leaves_no_process():
    work = guarded(time.sleep, [0.0, 1000.0], seconds=1000.0, workers=1)
    assert next(work).ending == "done"
    work.close()
    assert not multiprocessing.active_children()
