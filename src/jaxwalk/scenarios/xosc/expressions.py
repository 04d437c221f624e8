"""Parameters of an OpenSCENARIO document: ``$name``, and sums such as ``${$speed / 3.6}``."""

from __future__ import annotations

import ast
import math
import operator
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping

from jaxwalk.scenarios.xosc.elements import XoscRefusal

PARAMETER = re.compile(r"\$([A-Za-z_]\w*)")
LONGEST_SUM = 1000
"""Most characters of an expression."""
SIGNS: dict[type, Callable] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Mod: math.fmod, ast.UAdd: operator.pos, ast.USub: operator.neg,
}  # fmt: skip
FUNCTIONS: dict[str, Callable] = {
    "pow": math.pow, "sqrt": math.sqrt, "round": lambda x: math.floor(x + 0.5), "floor": math.floor,
    "ceil": math.ceil, "min": min, "max": max, "sign": lambda x: math.copysign(1, x) if x else 0,
    "abs": abs, "sin": math.sin, "cos": math.cos, "tan": math.tan, "asin": math.asin, "acos": math.acos,
    "atan": math.atan,
}  # fmt: skip


class Scope:
    """The parameters that are known inside an element. They may refer to each other, in any order."""

    def __init__(self, declared: Mapping[str, str], outer: Scope | None = None) -> None:
        """Keep parameters and their texts; ``outer`` has those of the elements around."""
        self.declared, self.outer, self.pending = declared, outer, set()
        self.known: dict[str, str] = {}

    def value(self, name: str) -> str:
        """Return a parameter's value. Raise XoscRefusal if it isn't declared, or refers to itself."""
        if name not in self.declared:
            if self.outer is None:
                raise XoscRefusal(f"parameter ${name} isn't declared; add a ParameterDeclaration")
            return self.outer.value(name)
        if name in self.known:
            return self.known[name]
        if name in self.pending:
            raise XoscRefusal(f"ParameterDeclaration {name!r}: refers to itself; correct it")
        self.pending.add(name)
        found = self.resolved(self.declared[name])
        self.pending.discard(name)
        self.known[name] = found
        return found

    def resolved(self, text: str) -> str:
        """Return a text without parameters and expressions. Raise XoscRefusal if one can't be evaluated."""
        if text.startswith("${") and text.endswith("}"):
            return repr(self._sum(text[2:-1]))
        found = PARAMETER.fullmatch(text)
        return text if found is None else self.value(found[1])

    def _sum(self, text: str) -> float:
        if len(text) > LONGEST_SUM:
            raise XoscRefusal(f"expression {text[:60]}...: longer than {LONGEST_SUM} characters; simplify it")
        filled = PARAMETER.sub(lambda found: f"({self.value(found[1])})", text)
        try:
            value = float(_evaluated(ast.parse(filled.strip(), mode="eval").body))
        except (SyntaxError, ValueError, ArithmeticError, TypeError, RecursionError, MemoryError) as error:
            raise XoscRefusal(f"expression ${{{text[:100]}}}: can't be evaluated ({error}); write a number") from None
        return value


def _evaluated(node: ast.expr) -> float:
    """Return the value of numbers, signs and the functions of the standard; all else is a ValueError."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return float(node.value)  # pyright: ignore[reportArgumentType]
    if isinstance(node, ast.Name) and node.id == "pi":
        return math.pi
    if isinstance(node, ast.BinOp) and type(node.op) in SIGNS:
        return SIGNS[type(node.op)](_evaluated(node.left), _evaluated(node.right))
    if isinstance(node, ast.UnaryOp) and type(node.op) in SIGNS:
        return SIGNS[type(node.op)](_evaluated(node.operand))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS:
        return FUNCTIONS[node.func.id](*map(_evaluated, node.args))
    raise ValueError("only numbers, + - * / % and " + ", ".join(FUNCTIONS))


def without_parameters(element: ET.Element, outer: Scope | None = None) -> ET.Element:
    """Return a copy of an element in which every parameter has its value. Raise XoscRefusal if one has none."""
    declared = {
        one.get("name", ""): one.get("value", "")
        for one in element.findall("ParameterDeclarations/ParameterDeclaration")
    }
    scope = Scope(declared, outer)
    copy = ET.Element(element.tag, {name: scope.resolved(text) for name, text in element.attrib.items()})
    copy.extend([without_parameters(one, scope) for one in element if one.tag != "ParameterDeclarations"])
    return copy
