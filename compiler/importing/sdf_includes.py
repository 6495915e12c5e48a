"""Models that SDF files include: read from the folders above the file, and put in the place of the `include`."""

from __future__ import annotations

import os
import posixpath
from xml.etree import ElementTree

from ..foreign import Files, Missing, beside
from ..named_meshes import mesh_places
from ..xml_texts import PlacedElement, XmlError, decoded, read_xml
from .xml_trees import Element, XmlFaults

MOST_INCLUDES = 1000
"""Models that one file takes in, also through others."""
MOST_ELEMENTS = 200_000
"""Elements of them all: a few of them, each in the other many times, would fill the memory."""
DEEPEST = 8
"""Files inside each other."""
MODEL_FRAME = "use_parent_model_frame"
OWN = ("pose", "static")
"""What an `include` says in place of what the model does."""


class SdfIncludes:
    """Reads what one file includes, each file once."""

    def __init__(self, faults: XmlFaults) -> None:
        self._faults, self._files, self._home = faults, Files(), posixpath.dirname(faults.source.path)
        self._included = self._elements = 0

    def put_in(self, parent: Element) -> None:
        """Put the models that `parent` and what lies in it include in their places; what cannot be read is left out."""
        _renew(parent, parent)
        self._put_in(parent, self._faults.source.path, ())

    def _put_in(self, parent: Element, path: str, way: tuple[str, ...]) -> None:
        for index, child in reversed(list(enumerate(parent))):
            if child.tag == "include":
                model = self._model(child, path, way)
                parent[index : index + 1] = [] if model is None else [model]
            elif child.tag in ("world", "model"):
                self._put_in(child, path, way)

    def _model(self, include: Element, path: str, way: tuple[str, ...]) -> Element | None:
        """The model that an `include` of the file at `path` names; None, and a note, where it is left out."""
        uri = (include.findtext("uri") or "").strip()
        try:
            if self._included >= MOST_INCLUDES or len(way) >= DEEPEST:
                raise _LeftOut(f"more than {MOST_INCLUDES} models are included, or {DEEPEST} inside each other")
            self._included += 1
            file = self._file(path, uri)
            if file in way or file == self._faults.source.path:
                raise _LeftOut(f"{file} includes itself")
            if include.get("merge") in ("true", "1") or include.find("placement_frame") is not None:
                raise _LeftOut("`merge` and `placement_frame` have no counterpart")
            model = self._read(file, include)
        except (_LeftOut, Missing, XmlError) as reason:
            self._faults.leave(include, f"`include` of `{uri}` is left out: {reason}")
            return None
        if include.findtext("name"):
            model.set("name", (include.findtext("name") or "").strip())
        for tag in OWN:
            given = include.find(tag)
            if given is not None:
                for old in model.findall(tag):
                    model.remove(old)
                model.append(given)
        self._put_in(model, file, (*way, file))
        return model

    def _file(self, path: str, uri: str) -> str:
        """The file of a model, by its name or that of its folder. Raises _LeftOut."""
        places = [place for place, fits in mesh_places(path, uri) if fits] if uri and "\0" not in uri else []
        if uri.endswith((".sdf", ".world")):
            chosen = self._files.first(places)
            if chosen is None:
                raise _LeftOut("there is no such file")
            return places[chosen]
        chosen = self._files.first([f"{place}/model.config" for place in places])
        if chosen is None:
            chosen = self._files.first([f"{place}/model.sdf" for place in places])
            if chosen is None:
                raise _LeftOut("no folder above has a model of this name")
            return f"{places[chosen]}/model.sdf"
        config = read_xml(decoded(self._files.read(f"{places[chosen]}/model.config")).decode())
        names = [(_version(sdf), (sdf.text or "").strip()) for sdf in config.findall("sdf")]
        return beside(f"{places[chosen]}/model.config", max(names, default=((), "model.sdf"))[1])

    def _read(self, file: str, include: Element) -> Element:
        """The model in a file, all of it told at the `include`. Raises what reading does, and _LeftOut."""
        if not file.endswith((".sdf", ".world")):
            raise _LeftOut(f"{file} is no SDF by its name")
        root = read_xml(decoded(self._files.read(file)).decode())
        model = root.find("model")
        if model is None:
            raise _LeftOut(f"{file} holds no model")
        _renew(model, root)
        folder = os.path.relpath(posixpath.dirname(file) or ".", self._home or ".")
        start = include.start if isinstance(include, PlacedElement) else 0
        for element in model.iter():
            self._elements += 1
            if isinstance(element, PlacedElement):
                element.start = start
            text = (element.text or "").strip()
            if element.tag == "uri" and text and "://" not in text:
                element.text = posixpath.join(folder, text)
        if self._elements > MOST_ELEMENTS:
            raise _LeftOut(f"the models hold more than {MOST_ELEMENTS} elements")
        return model


class _LeftOut(Exception):
    """Why a model is not taken in."""


def _renew(within: Element, root: Element) -> None:
    """Say in the words of 1.5 what axes were relative to before, in files of which `root` is the outermost element."""
    if _version(root) >= (1, 5):
        return
    for joint in within.iter("joint"):
        for axis in joint.findall("axis"):
            if axis.find(MODEL_FRAME) is None:
                ElementTree.SubElement(axis, MODEL_FRAME).text = "1"


def _version(sdf: Element) -> tuple[int, ...]:
    return tuple(int(word) for word in sdf.get("version", "").split(".") if word.isdecimal() and word.isascii())
