"""Text as LaTeX: what pdfLaTeX and BibTeX of any age read, in plain ASCII."""

import re
import unicodedata

from ..errors import printable

__all__ = ["latex", "latex_cell"]

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{c: f"\\{c}" for c in "{}$&#%_"},
}
# In text mode with " and | any old font encoding shows something else.
_TEXT = {
    "–": "--",
    "—": "---",
    "…": r"\ldots{}",
    "“": "``",
    "”": "''",
    "‘": "`",
    "’": "'",
    "\u00a0": "~",
    "\u202f": r"\,",
    "ø": r"{\o}",
    "Ø": r"{\O}",
    "ß": r"{\ss}",
    "æ": r"{\ae}",
    "ł": r"{\l}",
    "ı": r"{\i}",
    '"': "''",
}
_MATH = {
    "−": "-",
    "±": r"\pm",
    "×": r"\times",
    "·": r"\cdot",
    "÷": r"\div",
    "≤": r"\le",
    "≥": r"\ge",
    "≠": r"\ne",
    "≈": r"\approx",
    "≡": r"\equiv",
    "∈": r"\in",
    "∧": r"\wedge",
    "⟂": r"\perp",
    "⊥": r"\perp",
    "∂": r"\partial",
    "∇": r"\nabla",
    "∞": r"\infty",
    "√": r"\surd",
    "∫": r"\int",
    "Σ": r"\Sigma",
    "→": r"\to",
    "↦": r"\mapsto",
    "⟨": r"\langle",
    "⟩": r"\rangle",
    "½": r"\tfrac12",
    "⁻": "^-",
    "ᵀ": r"^{\mathsf T}",
    "′": "'",
    "|": r"\vert",
    "<": "<",
    ">": ">",
    "°": r"^\circ",
    "∘": r"\circ",
    "⊗": r"\otimes",
    "µ": r"\mu",
}
_ACCENTS = {
    "\u0300": "`",
    "\u0301": "'",
    "\u0302": "^",
    "\u0303": "~",
    "\u0304": "=",
    "\u0306": "u",
    "\u0307": ".",
    "\u0308": '"',
    "\u030a": "r",
    "\u030b": "H",
    "\u030c": "v",
    "\u0327": "c",
    "\u0328": "k",
}
_MATH_ACCENTS = {"\u0307": r"\dot", "\u0303": r"\tilde", "\u0304": r"\bar", "\u0308": r"\ddot",
                 "\u20d7": r"\vec", "\u0302": r"\hat"}  # fmt: skip
_CAPITALS = ("gamma", "delta", "theta", "lamda", "xi", "pi", "sigma", "upsilon", "phi", "psi",
             "omega")  # fmt: skip
_POWER = re.compile(r"(?P<number>\([^()]*\)|[−-]?\d+(?:\.\d+)?)e(?P<power>[+-]?\d+)")


def latex(text: str) -> str:
    """Return text as LaTeX: special characters escaped, accents and symbols as commands.

    Parameters
    ----------
    text : str
        Of any characters. What has no command becomes its nearest in ASCII, or a question mark,
        control characters their escapes, and the end of a line a blank: an empty line ends a cell.
    """
    found = []
    characters = list(unicodedata.normalize("NFD", printable(text).replace("\n", " ")))
    while characters:
        character = characters.pop(0)
        marks = []
        while characters and unicodedata.combining(characters[0]):
            marks.append(characters.pop(0))
        found.append(_character(character, marks))
    return "".join(found).replace("$$", "")  # neighbours in mathematics are one formula


def latex_cell(text: str) -> str:
    """Return a cell of a table as LaTeX: ``1.2e-11`` as a power of ten, the rest as `latex` does."""
    found, end = [], 0
    for match in _POWER.finditer(text):
        found.append(latex(text[end : match.start()]))
        number = latex(match["number"]).replace("$", "")
        times = {"1": "", "-1": "-"}.get(number, rf"{number}\times")
        found.append(f"${times}10^{{{int(match['power'])}}}$")
        end = match.end()
    return "".join([*found, latex(text[end:])])


def _character(character: str, marks: list[str]) -> str:
    mathematics = _mathematics(character)
    if mathematics is not None:
        for mark in marks:
            mathematics = f"{_MATH_ACCENTS.get(mark, '')}{{{mathematics}}}"
        return f"${mathematics}$"
    base = _TEXT.get(character) or _SPECIAL.get(character) or _ascii(character)
    for mark in marks:
        if mark in _ACCENTS:
            base = f"{{\\{_ACCENTS[mark]}{{{base}}}}}"
        elif mark in _MATH_ACCENTS:
            base = f"${_MATH_ACCENTS[mark]}{{{base}}}$"
    return base


def _mathematics(character: str) -> str | None:
    """Return a symbol as a command of mathematics, or None for what is text."""
    if character in _MATH:
        return f"{_MATH[character]} " if _MATH[character][-1:].isalpha() else _MATH[character]
    name = unicodedata.name(character, "")
    plain = unicodedata.normalize("NFKC", character)
    for word, mark in (("SUBSCRIPT", "_"), ("SUPERSCRIPT", "^")):
        if word in name.split() and plain != character:
            inside = plain if plain.isascii() else _mathematics(plain) or ""
            return f"{mark}{{{inside.strip()}}}"
    if "SCRIPT CAPITAL" in name and plain.isascii():
        return rf"\mathcal{{{plain}}}"
    if "DOUBLE-STRUCK" in name and plain.isascii():
        return rf"\mathbb{{{plain}}}"
    if name.startswith(("GREEK SMALL LETTER", "GREEK CAPITAL LETTER")):
        return _greek(name)
    return None


def _greek(name: str) -> str | None:
    """Return the command of a Greek letter; of capitals that look like Latin ones the Latin one."""
    letter = name.rsplit(" ", 1)[1].lower()
    if name.startswith("GREEK SMALL LETTER"):
        return "o" if letter == "omicron" else f"\\{letter.replace('lamda', 'lambda')} "
    if letter in _CAPITALS:
        return f"\\{letter.replace('lamda', 'lambda').capitalize()} "
    return {"eta": "H", "rho": "P", "chi": "X", "nu": "N"}.get(letter, letter[0].upper())


def _ascii(character: str) -> str:
    """Return a character, or what is nearest to it in ASCII."""
    plain = unicodedata.normalize("NFKD", character)
    return character if character.isascii() else plain if plain.isascii() and plain else "?"
