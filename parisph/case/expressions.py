"""Expressions of position and time in a case, such as '0.1*cos(pi*x)'.

Only arithmetic is allowed: the text is parsed, and every node is checked against a short list before the expression is
compiled. So a stored case from anybody is safe to read.
"""

import ast
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Protocol, cast

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.text import shown

FUNCTIONS = {
    name: getattr(np, name)
    for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "abs", "minimum",
                 "maximum", "where")
}
ARGUMENTS = {name: {"minimum": 2, "maximum": 2, "where": 3}.get(name, 1) for name in FUNCTIONS}
CONSTANTS = {"pi": np.float64(np.pi)}
OPERATORS = (
    ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.USub, ast.UAdd,
    ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq,
)
LONGEST = 2000  # characters, and
DEEPEST = 200   # levels of nesting: keep a hostile text from exhausting the parser


class VectorField(Protocol):
    """A compiled vector field: its values (n, dim) at positions x (n, dim) [m] and t [s]."""

    def __call__(self, x: Floats, t: float = 0.0) -> Floats: ...


@lru_cache(maxsize=256)
def compile_expression(text: str | float, names: tuple[str, ...]) -> Callable[..., Floats]:
    """Compile an expression once to a numpy function.

    text : str or float
    names : allowed variables, for example ("x", "y", "t")

    Returns: function(**variables) -> float64 array of the broadcast shape of all variables given

    Raises ValueError: the text contains something that is not allowed
    """
    tree = _parse(str(text), names)
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    numbers = _NamedNumbers()
    code = compile(ast.fix_missing_locations(numbers.visit(tree)), "<expression>", "eval")
    scope = {"__builtins__": {}, **FUNCTIONS, **CONSTANTS, **numbers.values}

    def evaluate(**variables: float | Floats) -> Floats:
        shape = np.broadcast_shapes(*(np.shape(value) for value in variables.values()))
        local = {name: np.asarray(value, dtype=np.float64) for name, value in variables.items() if name in used}
        with np.errstate(all="ignore"):  # callers report values that are not finite
            return np.array(np.broadcast_to(eval(code, scope, local), shape), dtype=np.float64)  # noqa: S307

    return evaluate


def uniform_field(components: Sequence[str | float]) -> Floats | None:
    """Return the values (dim,) of a vector field if it is uniform and constant, else None.

    components : numbers or expressions; those without variables count as numbers
    """
    try:
        return np.array([number(str(component)) for component in components])
    except ValueError:
        return None


@lru_cache(maxsize=64)
def vector_field(components: tuple[str | float, ...], with_time: bool) -> VectorField:
    """Compile the components of a vector field of position (and time), once.

    components : tuple of float or str, one for each dimension
    with_time : bool, whether t may occur

    Returns: function(x, t=0.0) -> a new float64 array (n, dim), for positions x (n, dim) [m] and t [s]

    Raises ValueError: see compile_expression
    """
    dim = len(components)
    names = variable_names(dim, with_time)
    functions = [compile_expression(component, names) for component in components]
    uniform = uniform_field(components)

    def evaluate(x: Floats, t: float = 0.0) -> Floats:
        x = np.asarray(x, dtype=np.float64)
        out = np.empty((len(x), dim))
        if uniform is not None:    # as gravity usually is
            for axis, value in enumerate(uniform):    # numpy is slow along a short last axis
                out[:, axis] = value
            return out
        variables: dict[str, float | Floats] = {name: x[:, axis] for axis, name in enumerate("xyz"[:dim])}
        if with_time:
            variables["t"] = t
        for axis, function in enumerate(functions):
            out[:, axis] = function(**variables)
        return out

    return evaluate


def variable_names(dim: int, with_time: bool) -> tuple[str, ...]:
    """Return the names that an expression may use: x, y (z in 3D), and t if `with_time`."""
    return tuple("xyz"[:dim]) + (("t",) if with_time else ())


def number(text: str) -> float:
    """Return the value of a text without variables, such as '1/24' or '2*pi'. Raises ValueError."""
    value = float(compile_expression(text, ())())
    if not np.isfinite(value):
        raise ValueError(f"{shown(text)} is not a finite number")
    return value


def _parse(text: str, names: tuple[str, ...]) -> ast.Expression:
    if len(text) > LONGEST:
        raise ValueError(f"the expression has {len(text)} characters; at most {LONGEST} are read")
    try:
        tree = ast.parse(text.strip(), mode="eval")
        _check_tree(tree, names, text, DEEPEST)
    except (SyntaxError, RecursionError, MemoryError) as error:
        raise ValueError(f"{shown(text)} is not an expression "
                         f"({getattr(error, 'msg', None) or 'nested too deeply'})") from None
    return tree


def _check_tree(node: ast.AST, names: tuple[str, ...], text: str, depth: int) -> None:
    """Check a node and its descendants, at most `depth` levels."""
    if depth == 0:
        raise ValueError(f"the expression {shown(text)} is nested more than {DEEPEST} levels deep")
    _check(node, names, text)
    for child in ast.iter_child_nodes(node):
        if not (isinstance(node, ast.Call) and child is node.func):  # function names may only stand before "("
            _check_tree(child, names, text, depth - 1)


def _check(node: ast.AST, names: tuple[str, ...], text: str) -> None:
    """Raise ValueError unless the node is in the list of allowed operations."""
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool) or not isinstance(node.value, (int, float)):
            raise ValueError(f"{shown(node.value)} in {shown(text)} is not a number")
    elif isinstance(node, ast.Name):
        if node.id not in names and node.id not in CONSTANTS:
            raise ValueError(_unknown_name(node.id, names, text))
    elif isinstance(node, ast.Call):
        _check_call(node, text)
    elif isinstance(node, ast.Compare):
        if len(node.ops) > 1:
            raise ValueError(f"write {shown(text)} with single comparisons, multiplied: (0 < x)*(x < 1)")
    elif not isinstance(node, (ast.Expression, ast.Load, ast.BinOp, ast.UnaryOp, *OPERATORS)):
        raise ValueError(
            f"{type(node).__name__} is not allowed in {shown(text)}: use numbers, + - * / **, comparisons, "
            f"{', '.join(names)}{', ' if names else ''}pi and {', '.join(FUNCTIONS)}"
        )


def _check_call(node: ast.Call, text: str) -> None:
    name = getattr(node.func, "id", None)
    if name not in FUNCTIONS:
        raise ValueError(f"unknown function in {shown(text)}; known are {', '.join(FUNCTIONS)}")
    if len(node.args) != ARGUMENTS[name] or node.keywords:
        raise ValueError(f"{name} in {shown(text)} takes {ARGUMENTS[name]} arguments")


def _unknown_name(name: str, names: tuple[str, ...], text: str) -> str:
    if not names:
        return f"{shown(name)} is not a number; write one such as 0.02, 1/40 or 2*pi"
    known = ", ".join([*names, *CONSTANTS])
    return f"unknown name {shown(name)} in {shown(text)}; known are {known} and the functions {', '.join(FUNCTIONS)}"


class _NamedNumbers(ast.NodeTransformer):
    """Replace every number by a named float64.

    float64 overflows to infinity. Python's integers would fill the memory (9**9**9), and Python's floats would raise an
    error in the middle of a step (1/0).
    """

    def __init__(self) -> None:
        self.values: dict[str, np.float64] = {}

    def visit_Constant(self, node: ast.Constant) -> ast.Name:
        name = f"_{len(self.values)}"
        try:
            self.values[name] = np.float64(cast(float, node.value))    # checked by _check
        except OverflowError:
            self.values[name] = np.float64("inf")
        return ast.copy_location(ast.Name(id=name, ctx=ast.Load()), node)
