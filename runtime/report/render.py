"""Plan to HTML page. The templates, style and scripts lie beside it; meshcat's comes from its wheel."""

from __future__ import annotations

import base64
import gzip
import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from ...langs.writer import write_atomically
from ..plan import Plan
from .clearance import build_clearance
from .ending import Ending
from .loads import build_loads
from .map import picture
from .postures import posture_data
from .rates import build_rates
from .replay import replay_data
from .support import build_support
from .view import asked, build_view, figure, measure_name

FOLDER = Path(__file__).parent / "templates"
SCRIPTS = ("scene.js", "player.js", "pictures.js", "page.js")


def script_json(data: Any) -> Markup:
    """JSON that may stand in a script element: no `<`, `>`, `&`, and no line separators of JavaScript."""
    text = msgspec.json.encode(data).decode()
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


def script_text(text: str) -> Markup:
    """A script of our own or of a library, safe inside a script element, with the line ends that a browser reads."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n")
    return Markup(lines.replace("</script", "<\\/script").replace("<!--", "<\\!--"))


def script_hash(script: str) -> Markup:
    """By what a page allows exactly this script (https://www.w3.org/TR/CSP3/)."""
    return Markup(f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'")


@cache
def meshcat_script() -> tuple[Markup, str]:
    """meshcat's viewer with three.js in one script, and its licences."""
    import meshcat

    viewer = Path(meshcat.__file__).parent / "viewer"
    bundle = viewer / "dist" / "main.min.js"
    licences = (viewer / "LICENSE", viewer / "dist" / "main.min.js.LICENSE.txt")
    text = "\n\n".join(p.read_text(encoding="utf-8") for p in licences if p.is_file())
    return script_text(bundle.read_text(encoding="utf-8")), text


@cache
def packed_viewer() -> str:
    """meshcat's script, compressed, in base64: a third of its size. The page unpacks it and runs what has its hash."""
    return base64.b64encode(gzip.compress(meshcat_script()[0].encode(), mtime=0)).decode("ascii")


@cache
def environment() -> Environment:
    result = Environment(
        loader=FileSystemLoader(FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    result.filters["figure"] = figure
    result.filters["measure_name"] = measure_name
    result.filters["asked"] = asked
    result.filters["picture"] = picture
    return result


def render_report(plan: Plan, checked: bool = True, ending: Ending | None = None) -> str:
    """The whole page as text: HTML with style, scripts, scene and motion inside. Same plan, same text. Unless it was
    `checked`, the page says that its verdict is only what the file holds. `ending` tells how a solve ended that found
    no plan; then `plan` is the scene at the start."""
    return _page(
        "report.html.j2", plan, view=build_view(plan, checked), ending=ending, rates=build_rates(plan),
        clearances=build_clearance(plan), loads=build_loads(plan), pictures=build_support(plan),
    )  # fmt: skip


def render_replay(plan: Plan, ending: Ending | None = None) -> str:
    """A page with nothing but the replay of `plan`, for a frame in a notebook, or the postures of an `ending`; it works
    offline too."""
    return _page("alone.html.j2", plan, ending, view=build_view(plan, checked=True))


def _page(template: str, plan: Plan, ending: Ending | None = None, **content: Any) -> str:
    viewer, licences = meshcat_script()
    scripts = [script_text((FOLDER / name).read_text(encoding="utf-8")) for name in SCRIPTS]
    return environment().get_template(template).render(
        style=Markup((FOLDER / "report.css").read_text(encoding="utf-8")),
        scripts=scripts,
        hashes=[script_hash(s) for s in (viewer, *scripts)],
        viewer=Markup(packed_viewer()),
        replay=script_json(replay_data(plan) if ending is None else posture_data(ending.postures, ending.misses)),
        ending=ending,
        licences=licences,
        **content,
    )


def write_report(plan: Plan, path: str | Path, checked: bool = True, ending: Ending | None = None) -> None:
    """Write the page for `plan`, whose verdict was just made or is not `checked`, atomically. Raises OSError."""
    write_atomically(path, render_report(plan, checked, ending).encode())
