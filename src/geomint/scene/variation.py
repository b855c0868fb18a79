"""Variations of a scene: a parameter or an initial number with many values, and the models of all."""

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic.fields import FieldInfo

from ..arguments import Array
from ..errors import Gathered, SceneError, nearest, quoted
from ..kernels.compiling.sameness import Compared
from ..problems.systems import Model
from .model import Raw
from .scene import Scene

SECTIONS = ("system", "initial")
MOST = 10**7  # values
_KEY = re.compile(r"(?:(system|initial)\.)?([^\[\].]+)((?:\[\d+\])*)")
_FORM = "KEY=A:B:N (N values from A to B), A:B:N:log, or numbers with commas between"


@dataclass(frozen=True, eq=False)
class Variation(Compared):
    """A number of a scene, and the values that it takes.

    Attributes
    ----------
    key : str
        As it was given, such as ``"D"``, ``"initial.gamma[2]"``.
    section, name : str
        ``"system"`` or ``"initial"``, and the key there.
    at : tuple of int
        Where in a list the number is; () for a number itself.
    values : array
    counts : bool
        Whether the scene takes whole numbers there: 2.0 is then written as 2.
    """

    key: str
    section: str
    name: str
    at: tuple[int, ...]
    values: Array
    counts: bool

    def put(self, tables: Mapping[str, dict[str, Any]], value: float) -> None:
        """Write a value into tables of the sections, whose lists are copied."""
        table = tables[self.section]
        if not self.at:
            table[self.name] = int(value) if self.counts and value.is_integer() else value
            return
        table[self.name] = _with(table[self.name], self.at, value)


def _with(numbers: Any, at: tuple[int, ...], value: float) -> Any:
    if not at:
        return value
    return [_with(x, at[1:], value) if i == at[0] else x for i, x in enumerate(numbers)]


def chosen_variations(scene: Scene, vary: Raw) -> list[Variation]:
    """Return the variations that are asked for, or raise `SceneError`.

    Parameters
    ----------
    vary : mapping of str to str or list of numbers
        ``{"D": "1:4:31", "initial.gamma[2]": [0.1, 0.2]}``. A key that both sections have needs the
        name of its section before it.
    """
    found = [_variation(scene, key, values) for key, values in vary.items()]
    places = [(v.section, v.name, v.at) for v in found]
    if len(set(places)) < len(places):
        raise SceneError(f"vary: {quoted(list(vary))}: expected each number once")
    return found


def _variation(scene: Scene, key: str, values: Any) -> Variation:
    match = _KEY.fullmatch(key.strip()) if isinstance(key, str) else None
    if match is None:
        raise SceneError(f"vary: {quoted(key)}: expected a key such as D or initial.gamma[2]")
    asked, name, indices = match.groups()
    raw, known = scene.sections, _known(scene)
    having = [s for s in SECTIONS if name in known[s] and asked in (None, s)]
    if len(having) != 1:
        names = dict.fromkeys(n for s in SECTIONS if asked in (None, s) for n in known[s])
        both = f"both have it: {' or '.join(f'{s}.{name}' for s in having)}"
        hint = both if having else f"no such key.{nearest(name, list(names))}"
        raise SceneError(f"vary: {quoted(key)}: {hint}")
    at = tuple(int(i) for i in re.findall(r"\d+", indices))
    here = raw.get(having[0], {}).get(name, _made(scene, name))
    if at or isinstance(here, list):
        _check_place(key, here, at)
    counts = known[having[0]][name].annotation is int
    return Variation(key.strip(), having[0], name, at, _values(key, values), counts)


def _made(scene: Scene, name: str) -> list[float] | None:
    """Return a piece of a state that the scene does not give, as its system makes it."""
    where = scene.problem.slices.get(name)
    return (
        None if where is None or name in scene.sections["system"] else scene.state[where].tolist()
    )


def _known(scene: Scene) -> dict[str, dict[str, FieldInfo]]:
    system = scene.system
    models = {"system": system.parameters, "initial": system.initial}
    return {section: dict(model.model_fields) for section, model in models.items()}


def _check_place(key: str, here: Any, at: tuple[int, ...]) -> None:
    for i in at:
        if not isinstance(here, list):
            raise SceneError(f"vary: {quoted(key)}: the scene has no list there")
        if i >= len(here):
            raise SceneError(f"vary: {quoted(key)}: expected an index from 0 to {len(here) - 1}")
        here = here[i]
    if isinstance(here, list):
        raise SceneError(f"vary: {quoted(key)}: that is a list: give an index, such as {key}[0]")


def _values(key: str, given: Any) -> Array:
    try:
        values = _spelled(given) if isinstance(given, str) else np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        values = np.zeros(0)
    if values.ndim != 1 or not len(values) or not np.isfinite(values).all():
        raise SceneError(f"vary: {quoted(key)} = {quoted(given)}: expected {_FORM}")
    return values


def _spelled(text: str) -> Array:
    """Return ``A:B:N``, ``A:B:N:log`` or ``A,B,C`` as values."""
    if ":" not in text:
        return np.array([float(part) for part in text.split(",")])
    first, last, count, *scale = text.split(":")
    number = int(count)
    if scale not in ([], ["log"]) or not 1 <= number <= MOST:
        raise ValueError(text)
    if not scale:
        return np.linspace(float(first), float(last), number)
    if not float(first) * float(last) > 0.0:
        raise ValueError(text)
    return np.geomspace(float(first), float(last), number)


def told_values(variations: Sequence[Variation], values: Sequence[float]) -> str:
    """Return what varies with its values, for a message."""
    return ", ".join(f"{v.key} = {x:.9g}" for v, x in zip(variations, values, strict=True))


def varied_models(
    scene: Scene, variations: Sequence[Variation]
) -> Iterator[tuple[tuple[float, ...], Model, str]]:
    """Yield every combination of values, the last one changing fastest, its model, and a note.

    The note says what was changed to make the initial state admissible; "" if nothing was.

    Raises
    ------
    SceneError
        For values that the system does not take, with them.
    """
    if not variations:
        yield (), scene.model, ""
        return
    raw, system = scene.sections, scene.system
    tables = {section: dict(raw.get(section, {})) for section in SECTIONS}
    tables["system"].pop("name", None)
    for v in variations:
        if v.section == "initial" and (made := _made(scene, v.name)):
            tables["initial"].setdefault(v.name, made)
    for values in itertools.product(*(v.values.tolist() for v in variations)):
        for variation, value in zip(variations, values, strict=True):
            variation.put(tables, value)
        try:
            with Gathered(quiet=True) as told:
                parameters = system.parameters.model_validate(tables["system"])
                model = system.build(parameters, system.initial.model_validate(tables["initial"]))
        except Exception as error:  # whatever another package raises
            raise _refused(scene, tables, variations, values) from error
        yield values, model, next(map(str, told), "")


def _refused(
    scene: Scene,
    tables: Raw,
    variations: Sequence[Variation],
    values: tuple[float, ...],
) -> SceneError:
    """Return the error of values that have no model, in the words of the scene with them."""
    where = told_values(variations, values)
    try:
        scene.changed(**tables)
    except SceneError as error:
        return SceneError(f"with {where}: {error}")
    return SceneError(f"with {where}: scene {quoted(scene.name)} has no model")
