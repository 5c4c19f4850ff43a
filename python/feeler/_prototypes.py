"""A small reader of the kernels' source: its struct types and the prototypes of its functions.

It knows the kernels' habits, not OpenCL C: a function's definition begins with its type at column 0, a struct is a
`typedef struct { … } name;`, and neither is made by a macro. A plain `#if NAME` may leave out members of a struct; else
what `#if` leaves out is read too, and of two definitions of a name the first counts.
"""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass, field

from ._library import Error

_COMMENT = re.compile(r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)
_DEFINE = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)[ \t]+(\d+)[uU]?[ \t]*$", re.MULTILINE)
_OPTION = re.compile(r"-D[ ]*(\w+)=(\d+)\b")
_DIRECTIVE = re.compile(r"^[ \t]*#(?:[^\n\\]|\\.|\\\n)*$", re.MULTILINE)
_MEMBERS = re.compile(r"^[ \t]*#[ \t]*if[ \t]+(\w+)[ \t]*\n([^#]*)#[ \t]*endif", re.MULTILINE)
_ATTRIBUTE = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)[ \t]+__attribute__\b", re.MULTILINE)
_STRUCT = re.compile(r"typedef\s+struct\s*\w*\s*\{([^{}]*)\}\s*(\w+)\s*;")
_FUNCTION = re.compile(
    r"^(?!typedef|struct|else|return)([A-Za-z_][\w \t]*?[\w*])[ \t\n]+(\w+)\(([^(){};]*)\)\s*\{", re.MULTILINE
)
_DECLARATOR = re.compile(r"(\*?)\s*(?:(?:const|restrict)\s+)*(\w+)\s*((?:\[\s*\w+\s*\]\s*)*)$")
_SPACES = {"global": "global", "constant": "constant", "local": "local", "private": "private"}
_QUALIFIERS = {"const", "restrict", "static", "inline", "volatile"}


@dataclass(frozen=True)
class Variable:
    """A parameter or a struct's member: `space` is "" for a value, else the space of what it points to."""

    name: str
    type: str
    space: str = ""
    constant: bool = False
    shape: tuple[int, ...] = ()  # of an array


@dataclass(frozen=True)
class Function:
    """A device function."""

    name: str
    returns: str
    parameters: tuple[Variable, ...]


@dataclass
class Prototypes:
    """What a source declares."""

    structs: dict[str, tuple[Variable, ...]] = field(default_factory=dict)
    functions: dict[str, tuple[str, str]] = field(default_factory=dict)  # name: type, parameters, as written
    macros: dict[str, int] = field(default_factory=dict)

    def function(self, name: str) -> Function:
        """The prototype of a function, or an error that names the nearest one."""
        if name not in self.functions:
            near = difflib.get_close_matches(name, self.functions, n=1)
            hint = f" (did you mean {near[0]!r}?)" if near else ""
            raise Error(f"the kernels have no function {name!r}{hint}")
        returns, parameters = self.functions[name]
        declared = [] if parameters.strip() in ("", "void") else parameters.split(",")
        return Function(name, _words(returns)[0], tuple(self.variables(text)[0] for text in declared))

    def variables(self, declaration: str) -> list[Variable]:
        """The variables of one declaration, such as `const real4 a, b[4]`."""
        first, *others = declaration.strip().split(",")
        match = _DECLARATOR.search(first)
        if not match:
            raise Error(f"probe cannot read the declaration {declaration.strip()!r}")
        type_, space, constant = _words(first[: match.start()])
        found = [match, *filter(None, (_DECLARATOR.search(other) for other in others))]
        return [self._variable(declarator, type_, space, constant) for declarator in found]

    def _variable(self, declarator: re.Match[str], type_: str, space: str, constant: bool) -> Variable:
        star, name, lengths = declarator.groups()
        shape = tuple(self._length(text) for text in re.findall(r"\w+", lengths))
        return Variable(name, type_, (space or "private") if star else "", constant, shape)

    def _length(self, text: str) -> int:
        value = int(text) if text.isdigit() else self.macros.get(text)
        if value is None:
            raise Error(f"probe does not know the array length {text}")
        return value


def _words(text: str) -> tuple[str, str, bool]:
    """Type, address space and constness of a declaration's words."""
    words = text.replace("*", " ").split()
    space = next((_SPACES[word.strip("_")] for word in words if word.strip("_") in _SPACES), "")
    names = [word for word in words if word.strip("_") not in _SPACES and word not in _QUALIFIERS]
    if not names:
        raise Error(f"probe cannot read the type {text.strip()!r}")
    return names[-1], space, "const" in words


def read_prototypes(source: str, options: str) -> Prototypes:
    """Everything that a source declares, under the -D options."""
    code = _COMMENT.sub(lambda match: match[0] if match[0].startswith('"') else " ", source)
    found = Prototypes(
        macros={name: int(value) for text in (_DEFINE.findall(code), _OPTION.findall(options)) for name, value in text}
    )
    attributes = "|".join(_ATTRIBUTE.findall(code))
    code = _STRUCT.sub(
        lambda struct: _MEMBERS.sub(lambda m: m[2] if found.macros.get(m[1], 1) else "", struct[0]), code
    )
    code = _DIRECTIVE.sub("", code)
    if attributes:
        code = re.sub(rf"\b(?:{attributes})\b[ \t]*", "", code)
    for body, name in _STRUCT.findall(code):
        declarations = [part for part in body.split(";") if part.strip()]
        found.structs.setdefault(name, tuple(variable for part in declarations for variable in found.variables(part)))
    for returns, name, parameters in _FUNCTION.findall(code):
        if "kernel" not in returns.replace("_", "").split():
            found.functions.setdefault(name, (returns, parameters))
    return found
