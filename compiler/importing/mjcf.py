"""MuJoCo's models (MJCF) as modules and bodies, through the package's own parser and compiler.

What reaches the parser is a text made of the elements that bear on joints, shapes and weights, each on a line of its
own; files that a model includes or names are read here, and handed over. MuJoCo opens nothing itself.
"""

from __future__ import annotations

import posixpath
import re
from importlib import import_module
from types import ModuleType as PythonModule
from typing import Any
from xml.sax.saxutils import quoteattr

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.reader import read_bytes
from ...langs.source import Source, Span
from ..apart import apart
from ..foreign import Files, Missing, beside
from .mjcf_bodies import Compiled, models_of
from .models import Models
from .xml_trees import Element, XmlFaults

SILENT = frozenset((
    "visual", "statistic", "sensor", "keyframe", "custom", "size", "option", "light", "camera", "texture", "material",
    "contact",
))  # fmt: skip
"""Elements that say nothing of shapes, joints or weights."""
LEFT = frozenset((
    "extension", "plugin", "deformable", "skin", "tendon", "composite", "flexcomp", "flex", "attach", "hfield",
))  # fmt: skip
"""Elements without counterpart."""
ACTUATORS = frozenset(("general", "motor", "position", "velocity", "dcmotor"))
NAMED = frozenset(("body", "joint", "geom", "freejoint", "site"))
LOST = frozenset(("material", "texture", "hfield", "plugin"))
NUMBERS = frozenset((
    "pos", "quat", "euler", "axisangle", "xyaxes", "zaxis", "size", "fromto", "axis", "range", "ref", "mass",
    "diaginertia", "fullinertia", "vertex", "scale", "refpos", "refquat", "polycoef", "gear", "forcerange",
))  # fmt: skip
"""Attributes that hold numbers, which must be finite."""
MESHES = (".stl", ".obj", ".msh")
MOST_INCLUDES = 100
MOST_COPIES = 1000
"""Of one element: for each more, MuJoCo takes longer than for the last."""
_LINE = re.compile(r"line (\d+)")


class Reader:
    """Makes one tree of a model and what it includes, and the text for MuJoCo."""

    def __init__(self, source: Source) -> None:
        self.faults = XmlFaults(source)
        self.files = Files()
        self.spans: dict[Element, Span] = {}
        self.lines: list[Element] = []
        self.text: list[str] = []
        self.assets: dict[str, bytes] = {}
        self.named: dict[tuple[str, str], Element] = {}
        self.count = 0
        self.folders: dict[str, str] = {}

    def whole(self) -> Element:
        """The tree, with what is included in place. Raises SourceError."""
        root = self.faults.root()
        if root.tag != "mujoco":
            self.faults.fault(root, f"a MuJoCo model is one `mujoco`, not `{root.tag}`", code="E0019")
            self.faults.end()
        self._include(root, self.faults, [self.faults.source.path])
        for compiler in root.iter("compiler"):
            for name in ("meshdir", "texturedir", "assetdir"):
                if name in compiler.attrib:
                    self.folders[name] = compiler.attrib.pop(name)
            compiler.attrib["discardvisual"] = "false"
            compiler.attrib["fusestatic"] = "false"
        self._clean(root, "", 1)
        self.faults.end()
        return root

    def _include(self, element: Element, faults: XmlFaults, way: list[str]) -> None:
        for child in list(element):
            self.spans[child] = faults.span(child)
        for index, child in reversed(list(enumerate(list(element)))):
            if child.tag != "include":
                self._include(child, faults, way)
                continue
            element[index : index + 1] = self._included(child, faults, way)

    def _included(self, child: Element, faults: XmlFaults, way: list[str]) -> list[Element]:
        name = child.get("file", "")
        path = beside(self.faults.source.path, name)
        if path in way:
            self._refuse(child, f"`{name}` includes itself")
        self.count += 1
        if self.count > MOST_INCLUDES:
            self._refuse(child, f"more than {MOST_INCLUDES} files are included")
        if not path.endswith(".xml"):
            self._refuse(child, f"`{name}` is not included: only files that end with .xml are")
        try:
            content = read_bytes(path)
            text = content.decode("utf-8", errors="replace").replace("\r\n", "\n")
        except SourceError as error:
            self._refuse(child, f"`{name}` is not included: {error.diagnostics[0].message}")
        inner = XmlFaults(Source(path, text))
        root = inner.root()
        if root.tag not in ("mujoco", "mujocoinclude"):
            self._refuse(child, f"`{name}` holds a `{root.tag}`, and is not included")
        self._include(root, inner, [*way, path])
        return list(root)

    def _refuse(self, element: Element, message: str) -> None:
        raise SourceError([Diagnostic("E0022", message, self.place(element))])

    def place(self, element: Element) -> Span:
        """Where an element stands, in whichever file."""
        return self.spans.get(element) or self.faults.span(element)

    def leave(self, element: Element, message: str) -> None:
        self.faults.told.append(Diagnostic("W0019", message, self.place(element)))

    def fault(self, element: Element, message: str, code: str = "E0022") -> None:
        self.faults.found.append(Diagnostic(code, message, self.place(element)))

    def _clean(self, element: Element, within: str, copies: int) -> None:
        """Take out what has no counterpart, and give names to what has none. There will be `copies` of the element."""
        for child in list(element):
            if self._passed_over(child, within):
                element.remove(child)
                continue
            for name in LOST:
                child.attrib.pop(name, None)
            self._check_finite(child)
            number = self._copies(child, copies)
            if child.tag == "mesh" and within == "asset":
                self._mesh(child)
            if child.tag in NAMED and within in ("worldbody", "body"):
                self.named[child.tag.replace("freejoint", "joint"), self._name(child)] = child
            inner = within if child.tag in ("frame", "replicate") else child.tag
            self._clean(child, "default" if within == "default" else inner, number)

    def _copies(self, element: Element, copies: int) -> int:
        """How many there will be of an element, and that it is not too many."""
        if element.tag != "replicate":
            return copies
        text = element.get("count", "1").strip()
        number = copies * (int(text) if re.fullmatch(r"[0-9]{1,9}", text) else 1)
        if number > MOST_COPIES:
            self._refuse(element, f"this makes {number} copies; a model may have {MOST_COPIES}")
        return number

    def _check_finite(self, element: Element) -> None:
        for name in NUMBERS & element.attrib.keys():
            if re.search(r"\b(nan|inf|infinity)\b", element.attrib[name], re.IGNORECASE):
                self.fault(element, f"`{name}` holds what is no finite number", "E0019")

    def _passed_over(self, child: Element, within: str) -> bool:
        tag, name = child.tag, child.get("name")
        shown = f"`{tag}`" + (f" `{name}`" if name else "")
        if tag in SILENT or (within == "default" and tag in (*LEFT, *ACTUATORS, "equality", "pair")):
            return True
        if within == "asset" and tag in ("model", "hfield", "skin"):
            self.leave(child, f"{shown} is left out: it names another file whose contents have no counterpart")
            return True
        if within == "actuator":
            if tag in ACTUATORS and child.get("joint"):
                return False
            self.leave(child, f"actuator {shown} drives no single joint, and is left out")
            return True
        if within == "equality" and tag != "joint":
            self.leave(child, f"{shown} closes a loop or welds bodies, and is left out")
            return True
        if tag in LEFT and within != "asset":
            self.leave(child, f"{shown} has no counterpart, and is left out")
            return True
        if tag == "geom" and child.get("type") == "hfield":
            self.leave(child, f"{shown} is a height field, and is left out")
            return True
        return False

    def _name(self, element: Element) -> str:
        name = element.get("name")
        if name and '"' in name:
            self.fault(element, "a name has quotes in it")
        if not name:
            number = len(self.named)
            name = f"{element.tag}_{number}"
            while (element.tag, name) in self.named:
                number += 1
                name = f"{element.tag}_{number}"
            element.set("name", name)
        return name

    def _mesh(self, element: Element) -> None:
        file = element.get("file")
        if file is None:
            return
        folder = self.folders.get("meshdir", self.folders.get("assetdir", ""))
        if not element.get("name"):
            element.set("name", posixpath.splitext(posixpath.basename(file.replace("\\", "/")))[0])
        ending = posixpath.splitext(file)[1].lower()
        if ending not in MESHES:
            self.fault(element, f"the mesh `{file}` is no {' or '.join(MESHES)} file")
            return
        path = beside(self.faults.source.path, posixpath.join(folder, file))
        try:
            key = f"mesh{len(self.assets)}{ending}"
            self.assets[key] = self.files.read(path)
            element.set("file", key)
        except Missing as reason:
            self.fault(element, str(reason))

    def write(self, element: Element) -> None:
        """One line for each element, so that MuJoCo's lines tell which."""
        given = "".join(f" {k}={quoteattr(v)}" for k, v in element.attrib.items())
        self.lines.append(element)
        self.text.append(f"<{element.tag}{given}>")
        for child in element:
            self.write(child)
        self.text[-1] += f"</{element.tag}>"


def _mujoco(source: Source) -> PythonModule:
    try:
        return import_module("mujoco")
    except ImportError as error:
        message = f"`{source.path}` is a MuJoCo model (MJCF), which the package mujoco reads: {error}"
        raise SourceError([Diagnostic("E0021", message, help="install it: pip install 'tamplang[sim]'")]) from None


def import_mjcf(source: Source) -> Models:
    """The modules and bodies of a model. Raises SourceError."""
    reader = Reader(source)
    root = reader.whole()
    mujoco = _mujoco(source)
    reader.write(root)
    found = apart(lambda: _compiled(mujoco, "\n".join(reader.text), reader.assets))
    if isinstance(found, str):
        raise SourceError([_refusal(reader, found)])
    models = models_of(reader, found)
    reader.faults.end()
    models.told += sorted(reader.faults.told, key=lambda d: d.span.start if d.span is not None else 0)
    return models


def _compiled(mujoco: Any, text: str, assets: dict[str, bytes]) -> Compiled | str:
    """What MuJoCo makes of the text, or what it says is wrong with it."""
    import warnings

    try:
        with warnings.catch_warnings():  # what MuJoCo warns of is how it would simulate
            warnings.simplefilter("ignore")
            model = mujoco.MjSpec.from_string(text, assets=assets).compile()
    except (ValueError, RuntimeError) as error:
        return str(error)
    return Compiled.of(mujoco, model)


def _refusal(reader: Reader, words: str) -> Diagnostic:
    """MuJoCo's own words, at the element whose line they name."""
    match = _LINE.search(words)
    line = int(match[1]) if match else 0
    element = reader.lines[line - 1] if 0 < line <= len(reader.lines) else None
    named = [e for (_, n), e in reader.named.items() if f"'{n}'" in words]
    place = reader.place(element if element is not None else named[0] if named else reader.lines[0])
    told = re.sub(r"\s+", " ", _LINE.sub("", words)).strip(" ,.")
    told = told.removeprefix("XML Error: ").removeprefix("Error: ")
    return Diagnostic("E0019", f"MuJoCo refuses this: {told}", place)


