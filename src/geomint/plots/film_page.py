"""A film as a page that needs nothing but itself: all frames in it, with a button and a slider."""

import base64
import json
from collections.abc import Iterable
from html import escape
from pathlib import Path

PAGE = Path(__file__).with_name("film_page.html")


def film_page(title: str, pictures: Iterable[bytes], fps: float) -> str:
    """Return a page that shows pictures, PNG each, so many a second."""
    frames = [base64.b64encode(picture).decode("ascii") for picture in pictures]
    return PAGE.read_text(encoding="utf-8").format(
        title=escape(title),
        last=len(frames) - 1,
        frames=json.dumps(frames),
        every=f"{1e3 / fps:.6g}",
    )
