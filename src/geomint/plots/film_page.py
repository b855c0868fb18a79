"""A film as a page that needs nothing but itself: all frames in it, with a button and a slider."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable
from html import escape

__all__ = ["film_page"]

PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>{title}</title>
<style>
body {{ margin: 1rem auto; max-width: 44rem; padding: 0 .5rem; font-family: sans-serif; }}
img {{ display: block; width: 100%; }}
div {{ display: flex; gap: .6rem; align-items: center; }}
button {{ min-width: 5rem; min-height: 2.6rem; font: inherit; }}
input {{ flex: 1; min-width: 0; }}
</style></head>
<body><img id="frame" alt="{title}">
<div><button id="play" type="button">Pause</button>
<input id="at" type="range" min="0" max="{last}" value="0" aria-label="frame"></div>
<script>
"use strict";
const frames = {frames}, every = {every};
const image = document.getElementById("frame"), at = document.getElementById("at");
const play = document.getElementById("play");
let shown = 0, going = true;
function show(i) {{
  shown = i;
  at.value = i;
  image.src = "data:image/png;base64," + frames[i];
}}
function go(on) {{ going = on; play.textContent = on ? "Pause" : "Play"; }}
setInterval(() => {{ if (going) show((shown + 1) % frames.length); }}, every);
play.onclick = () => go(!going);
at.oninput = () => {{ go(false); show(Number(at.value)); }};
show(0);
if (matchMedia("(prefers-reduced-motion: reduce)").matches) go(false);
</script></body></html>
"""


def film_page(title: str, pictures: Iterable[bytes], fps: float) -> str:
    """Return a page that shows pictures, PNG each, so many a second."""
    frames = [base64.b64encode(picture).decode("ascii") for picture in pictures]
    return PAGE.format(
        title=escape(title),
        last=len(frames) - 1,
        frames=json.dumps(frames),
        every=f"{1e3 / fps:.6g}",
    )
