"""An SVG document reduced to what it draws: groups and shapes, each where it is drawn.

svgelements (1.9) reads transforms, lengths, colors, style sheets and outlines, but it draws what stands in symbols,
masks, markers and patterns outside of ``defs``, forgets the ``viewBox`` of a used symbol, and scales the offset of a
nested ``svg`` twice. So these structures are resolved here before it reads the document.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import svgelements

_SVG = "{http://www.w3.org/2000/svg}"
_HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
_SHAPES = ("path", "rect", "circle", "ellipse", "polygon", "polyline", "line")
_GROUPS = ("g", "a", "switch")
_FRAMES = ("svg", "symbol")
"""What shows its content through a viewport."""
_FRAME_ATTRIBUTES = ("x", "y", "width", "height", "viewBox", "preserveAspectRatio")
_ACROSS, _DOWN, _ALONG = ("x", "width", "cx", "rx", "x1", "x2"), ("y", "height", "cy", "ry", "y1", "y2"), ("r",)
_SIZE_WITHOUT_ANY = (1000.0, 1000.0)  # user units, as svgelements takes it
ELEMENTS_MAX = 50_000
"""Uses of groups of uses multiply; more than this is no drawing but a trap."""


@dataclass(frozen=True, slots=True)
class _Surroundings:
    """Where an element stands: the size of its viewport [user units] and the ids of the uses that it is in."""

    size: tuple[float, float]
    uses: tuple[str, ...] = ()


def drawn_document(text: str) -> str:
    """Return an SVG document that draws the same with groups and shapes only.

    Definitions are gone, what is used is in its place, nested viewports are groups with a transform, and shares of a
    viewport are lengths. Clips and masks do not cut.

    Parameters
    ----------
    text : str
        The SVG document.

    Raises
    ------
    xml.etree.ElementTree.ParseError
        If it is no XML.
    ValueError
        If its root is no ``svg``, a use holds itself, or there are more than `ELEMENTS_MAX` elements.
    """
    root = ElementTree.fromstring(text)
    if _tag(root) != "svg":
        raise ValueError("the root is no svg element")
    styles = [element for element in root.iter() if _tag(element) == "style"]
    plain = Element("svg")
    for style in styles:  # a style sheet holds for the whole document, wherever it stands
        ElementTree.SubElement(plain, "style").text = style.text
    content = _Resolver(root).frame(root, _Surroundings(_own_size(root)), {"x": "0", "y": "0"})
    if content is not None:
        plain.append(content)
    return ElementTree.tostring(plain, encoding="unicode")


class _Resolver:
    """Copies the elements of one document that draw something."""

    def __init__(self, root: Element) -> None:
        self._targets = {element.attrib["id"]: element for element in root.iter() if "id" in element.attrib}
        self._count = 0

    def frame(self, element: Element, around: _Surroundings, given: Mapping[str, str]) -> Element | None:
        """Return a ``svg`` or ``symbol`` as a group; None if its viewport has no size.

        Parameters
        ----------
        element : Element
        around : _Surroundings
        given : mapping
            Geometry that replaces its own: a use gives width and height.
        """
        attributes = {**element.attrib, **given}
        x, y = (_length(attributes.get(key, "0"), whole) for key, whole in zip("xy", around.size, strict=True))
        width, height = (
            _length(attributes.get(key, "100%"), whole)
            for key, whole in zip(("width", "height"), around.size, strict=True)
        )
        if width <= 0.0 or height <= 0.0:
            return None
        place, inner = f"translate({x!r},{y!r})", (width, height)
        box = attributes.get("viewBox")
        if box is not None:
            view = svgelements.Viewbox(box, attributes.get("preserveAspectRatio"))
            place = svgelements.Viewbox.viewbox_transform(
                x, y, width, height, view.x, view.y, view.width, view.height, view.preserve_aspect_ratio
            )
            inner = (float(view.width), float(view.height))
        group = self._group(element, place)
        self._fill(group, element, replace(around, size=inner))
        return group

    def _drawn(self, element: Element, around: _Surroundings) -> Element | None:
        """Return a copy of an element that draws something; None of any other."""
        self._count += 1
        if self._count > ELEMENTS_MAX:
            raise ValueError("too many elements")
        tag = _tag(element)
        if tag == "svg":
            return self.frame(element, around, {})
        if tag == "use":
            return self._used(element, around)
        if tag in _GROUPS:
            group = self._group(element, "")
            self._fill(group, element, around)
            return group
        if tag in _SHAPES:
            return Element(tag, {key: _absolute(key, value, around.size) for key, value in _plain(element).items()})
        return None

    def _used(self, element: Element, around: _Surroundings) -> Element | None:
        reference = next((element.attrib[key] for key in _HREFS if key in element.attrib), "")
        name = reference.removeprefix("#")
        target = self._targets.get(name)
        if target is None:
            return None
        if name in around.uses:
            raise ValueError("a use holds itself")
        inside = replace(around, uses=(*around.uses, name))
        x, y = (_length(element.get(key, "0"), whole) for key, whole in zip("xy", around.size, strict=True))
        group = self._group(element, f"translate({x!r},{y!r})")
        if _tag(target) in _FRAMES:
            own = {key: value for key, value in element.attrib.items() if key in {"width", "height"}}
            content = self.frame(target, inside, own)
        else:
            content = self._drawn(target, inside)
        if content is not None:
            group.append(content)
        return group

    def _fill(self, group: Element, element: Element, around: _Surroundings) -> None:
        for child in element:
            drawn = self._drawn(child, around)
            if drawn is not None:
                group.append(drawn)

    @staticmethod
    def _group(element: Element, place: str) -> Element:
        """Return an empty group with an element's style and transform, and `place` inside of that transform."""
        attributes = {key: value for key, value in _plain(element).items() if key not in _FRAME_ATTRIBUTES}
        transform = f"{attributes.pop('transform', '')} {place}".strip()
        return Element("g", {**attributes, **({"transform": transform} if transform else {})})


def _tag(element: Element) -> str:
    return element.tag.removeprefix(_SVG) if isinstance(element.tag, str) else ""


def _plain(element: Element) -> dict[str, str]:
    """Return the attributes of SVG itself; editors add others in name spaces of their own."""
    return {key: value for key, value in element.attrib.items() if not key.startswith("{") and key != "href"}


def _own_size(root: Element) -> tuple[float, float]:
    """Return what shares of the outermost viewport are taken of [user units]: the picture has no size around it."""
    box = svgelements.Viewbox(root.attrib["viewBox"]) if "viewBox" in root.attrib else None
    return _SIZE_WITHOUT_ANY if box is None else (float(box.width), float(box.height))


def _length(text: str, whole: float) -> float:
    return float(svgelements.Length(text).value(ppi=svgelements.DEFAULT_PPI, relative_length=whole))


def _absolute(key: str, value: str, size: tuple[float, float]) -> str:
    """Return a share of the viewport as a length; anything else as it is."""
    if not value.strip().endswith("%"):
        return value
    whole = {
        **dict.fromkeys(_ACROSS, size[0]),
        **dict.fromkeys(_DOWN, size[1]),
        **dict.fromkeys(_ALONG, float(np.hypot(*size)) / np.sqrt(2.0)),
    }.get(key)
    return value if whole is None else repr(_length(value, float(whole)))
