"""An ensemble as an `xarray.Dataset`."""

from __future__ import annotations

from collections.abc import Set
from typing import TYPE_CHECKING, Any

import numpy as np

from ..variables import optional

if TYPE_CHECKING:
    from .result import Ensemble


def as_dataset(many: Ensemble) -> Any:
    """Return times, pieces and drifts with the dimension ``member``; see `Ensemble.to_xarray`."""
    xarray = optional("xarray", "Ensemble.to_xarray")
    tau, physical, first = many.tau, many.found.physical, many.problems[0]
    data: dict[str, Any] = {"tau": (("member", "sample"), tau)}
    data["steps"], data["status"] = ("member", many.steps), ("member", many.status)
    if np.isfinite(physical).any():
        data["t"] = ("member", "sample"), physical
    shapes, y = first.shapes, many.y
    axes_of = {name: [f"{name}_{i}" for i in range(len(s))] for name, s in shapes.items()}
    taken = {"member", "sample", *(axis for axes in axes_of.values() for axis in axes)}
    for name, shape in shapes.items():
        values = y[:, :, first.slices[name]].reshape(*tau.shape, *shape)
        data[free_name(name, taken | data.keys())] = ("member", "sample", *axes_of[name]), values
    for name, drift in many.drift.items():
        for key, values in drift.items():
            data[free_name(f"{name}_{key}", taken | data.keys())] = ("member",), values
    for name, numbers in many.given.differing().items():
        data[free_name(name, taken | data.keys())] = ("member",), numbers
    for name, values in many.readings.items():
        merged = many.asked.readings[name].merges
        rest = [f"{name}_{i}" for i in range(values.ndim - (0 if merged else 1))]
        axes = tuple(rest) if merged else ("member", *rest)
        data[free_name(name, taken | {*rest} | data.keys())] = axes, values
    about = {"problem": first.name, "method": many.asked.method.name}
    return xarray.Dataset(data, attrs=about).set_coords([n for n in ("tau", "t") if n in data])


def free_name(name: str, taken: Set[str]) -> str:
    """Return a name that neither a dimension has nor another variable."""
    while name in taken:
        name += "_"
    return name
