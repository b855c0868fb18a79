"""What is wrong with a scene, gathered, and what is left to be looked at in spite of it."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel, TypeAdapter, ValidationError

from ..errors import GeomintError, SceneError, closest, quoted, raised
from .explain import explained
from .model import Content, Raw

T = TypeVar("T")
Section = TypeVar("Section", bound=BaseModel)


class Looked(NamedTuple):
    """The sections of a scene as far as they are right, and the names of those that are not."""

    content: Content
    flawed: frozenset[str]


class Flaws(list[str]):
    """What is wrong with a scene, a line each.

    Parameters
    ----------
    places : mapping
        Where keys of sections were written, if not there: ``"[observe] every"`` ↦ ``"[drift] every"``.
    """

    def __init__(self, places: Mapping[str, str] | None = None) -> None:
        super().__init__()
        self.places = places or {}
        self.cause: BaseException | None = None

    def validated(self, model: type[Section], given: Raw, *keys: str) -> Section | None:
        """Return what was given under some keys as a model; None if it is none, which is a flaw."""
        try:
            return model.model_validate(given)
        except ValidationError as error:
            self += explained(error, model, keys, given)
        except Exception as error:  # of another package's own checks
            self.append(f"[{'.'.join(keys)}]: its checks failed, {raised(error)}")
        return None

    def asked(self, where: str, function: Callable[..., T], *given: Any) -> T | None:
        """Return what a function returns; None if it raises an error, which is a flaw."""
        try:
            return function(*given)
        except GeomintError as error:
            self.append(f"{where}{error}")
            return None

    def looked(self, raw: Raw) -> Looked:
        """Return the sections, with defaults in place of what is wrong, which is told.

        The keys of systems and methods, and what sections say of one another, can be looked at then.
        """
        content = self.validated(Content, raw)
        if content is not None:
            return Looked(content, frozenset())
        sound, flawed = {}, set()
        for name, field in Content.model_fields.items():
            kind: Any = field.annotation
            if name not in raw and not field.is_required():
                continue
            try:
                sound[name] = TypeAdapter(kind).validate_python(raw.get(name))
            except ValidationError:
                flawed.add(name)
                if isinstance(kind, type) and issubclass(kind, BaseModel):
                    sound[name] = mended(kind, raw.get(name)) or kind.model_construct()
        return Looked(Content.model_construct(**sound), frozenset(flawed))

    def error(self, name: str) -> SceneError:
        """Return the one error that says them all, each once and where it was written."""
        lines = dict.fromkeys(self._placed(flaw) for flaw in self)
        if len(lines) == 1:
            return SceneError(f"scene {quoted(name)}: {next(iter(lines))}")
        told = "".join(f"\n  {line}" for line in lines)
        return SceneError(f"scene {quoted(name)} has {len(lines)} problems:{told}")

    def _placed(self, flaw: str) -> str:
        for place, written in self.places.items():
            if flaw.startswith(place) and not flaw[len(place) :][:1].isidentifier():
                return written + flaw[len(place) :]
        return flaw


def mended(model: type[Section], given: Any) -> Section | None:
    """Return a section without the keys that are wrong; None if too little is left.

    A key that is unknown counts as the missing one that was probably meant.
    """
    if not isinstance(given, Mapping):
        return None
    try:
        return model.model_validate(given)
    except ValidationError as error:
        wrong = {str(e["loc"][0]): e["type"] for e in error.errors() if e["loc"]}
    except Exception:
        return None
    left = {key: value for key, value in given.items() if key not in wrong}
    free = [key for key in model.model_fields if key not in given]
    for key in (key for key, kind in wrong.items() if kind == "extra_forbidden"):
        meant = closest(key, free)
        if meant is not None:
            left.setdefault(meant, given[key])
    try:
        return model.model_validate(left)
    except Exception:
        return None
