"""Sphinx extension: formulas as MathML, which browsers draw without scripts, fonts or a network."""

from __future__ import annotations

import html
import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

logger = logging.getLogger(__name__)

_FUNCTIONS = "arc(?:sin|cos|tan)|sin|cos|tan|cot|exp|ln|log|max|min"
"""Names of functions that the converter writes as identifiers, without space."""


def convert_formula(latex: str, *, is_block: bool) -> str:
    """Return a formula as MathML.

    Parameters
    ----------
    latex
        Formula in LaTeX, without dollar signs.
    is_block
        Whether it is on a line of its own.

    Returns
    -------
    str
        The element `math`.

    Raises
    ------
    ValueError
        If the formula has a mistake, or a command that is not known.
    """
    from latex2mathml.converter import convert

    # The converter knows no exponent after a prime.
    latex = re.sub(
        r"('+)\^(\{[^{}]*\}|\w)", lambda match: "^{" + r"\prime " * len(match.group(1)) + match.group(2).strip("{}") + "}", latex
    )
    try:
        # In an alignment that is not the outermost environment the converter shows "&".
        element = convert(re.sub(r"\{aligned\}", "{align*}", latex), display="block" if is_block else "inline")
    except Exception as error:  # the converter raises many types, and only the formula can be at fault
        raise ValueError(f"{type(error).__name__}: {error}") from error
    unknown = re.search(r"\\[A-Za-z]+", element)
    if unknown or "<mi>&</mi>" in element:
        raise ValueError(f"the command {unknown.group()} is not known" if unknown else "the character & is outside an alignment")
    # A named function is an operator with space around it; before a bracket it needs none.
    element = re.sub(
        rf"<mi>({_FUNCTIONS})</mi>(?=<mo[^>]*>(&#x00028;|\()|<mrow><mo[^>]*>&#x00028;)", r"<mo lspace='0.167em' rspace='0'>\1</mo>", element
    )
    element = re.sub(rf"<mi>({_FUNCTIONS})</mi>", r"<mo lspace='0.167em' rspace='0.167em'>\1</mo>", element)
    # Where a font for mathematics is missing, a prime as an exponent is drawn too high; the character is raised already.
    return re.sub(r"<msup>(<m[io]>[^<]*</m[io]>)<m[io]>(&#x0203[234];)</m[io]></msup>", r"\1<mo lspace='0' rspace='0'>\2</mo>", element)


def _visit_inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(_element_of(node, is_block=False))
    raise nodes.SkipNode


def _visit_block(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="formula">{_element_of(node, is_block=True)}</div>')
    raise nodes.SkipNode


def _element_of(node: nodes.Element, *, is_block: bool) -> str:
    """Return the element of a formula; a formula with a mistake is a warning, and is shown as it is written."""
    latex = node.astext()
    try:
        return convert_formula(latex, is_block=is_block)
    except ValueError as error:
        logger.warning("formula %r cannot be converted (%s)", latex, error, location=node, type="mathml")
        return f"<code>{html.escape(latex)}</code>"


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the renderer `mathml`."""
    app.add_html_math_renderer("mathml", (_visit_inline, None), (_visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
