"""Values in NC programs: from their text to the steps of expressions.py.

    value      = sign* (number | parameter | "[" expression "]" | function "[" expression "]"
               | "ATAN" "[" expression "]" "/" "[" expression "]" | "EXISTS" "[" parameter "]")
    parameter  = "#" value | "#<" name ">"
    expression = value (operation value)*

Operations, the tightest first, each from the left: **;  * / MOD;  + -;  EQ NE GT GE LT LE;  AND OR XOR.  A sign binds
tighter than any of them: -2**2 is 4.  Precedence by a stack, without recursion.
"""

from __future__ import annotations

import re

from ...errors import ProgramError, nearest
from .expressions import (
    ARCTANGENT,
    CONSTANT,
    DIRECT,
    EXISTS,
    EXISTS_NAMED,
    FUNCTION,
    NAMED,
    NEGATE,
    NUMBERED,
    OPERATION,
    PLAIN,
    Program,
    show,
)  # fmt: skip
from .functions import BINARY, UNARY

NO_NUMBER = "a number is missing"  # the rule of the error where nothing that is a value begins
_FUNCTIONS = (*UNARY, "ATAN", "EXISTS")

_NUMBER = re.compile(r"[0-9.]+")
_NAME = re.compile(r"<([^<>()]*)>")
_WORD = re.compile(r"[A-Z]+")
_OPERATION = re.compile(r"\*\*|[*/+-]|AND|EQ|GE|GT|LE|LT|MOD|NE|OR|XOR")
_FUNCTION = re.compile("(?:" + "|".join(_FUNCTIONS) + ")(?![A-Z])")


def compile_value(text: str, at: int = 0) -> tuple[float | Program, int]:
    """The value that begins at text[at], a float where it is a plain number, and where it ends.

    `text` is upper case and has no blanks.

    Raises
    ------
    ProgramError
        without file and line: it is no value.
    """
    return _Compiler(text, at).value()


def read_name(text: str, at: int) -> tuple[str, int]:
    """The name in "<name>" at text[at], in lower case, and where it ends.

    Raises
    ------
    ProgramError
        without file and line.
    """
    found = _NAME.match(text, at)
    if found is None:
        if ">" in text[at:]:
            rule, cure = 'a name has no brackets "(", ")", "<"', "use letters, digits and _"
        else:
            rule, cure = "a name is not closed", 'write ">" at its end'
        raise ProgramError(rule, value=show(text[at:]), cure=cure)
    if not found[1]:
        raise ProgramError("a name is empty", value=show(text[at:]), cure="write e.g. <depth>")
    return found[1].lower(), found.end()


class _Compiler:
    """Operands go to `steps` at once; signs, "#", operations and open brackets wait on `stack` for what follows.

    An item of the stack: (kind, step or None, how tightly it binds).
    """

    def __init__(self, text: str, at: int):
        self.text, self.start, self.at = text, at, at
        self.steps: list[tuple[int, object]] = []
        self.stack: list[tuple[str, tuple[int, object] | None, int]] = []

    def value(self):
        operand_next = True
        while True:
            if operand_next:
                operand_next = self._operand()
                continue
            while self.stack and self.stack[-1][0] == "prefix":
                self._prefix(self.stack.pop()[1])
            if not self.stack:
                return self._result(), self.at
            operand_next = self._close() if self.text[self.at : self.at + 1] == "]" else self._operation()

    def _result(self):
        if len(self.steps) == 1 and self.steps[0][0] == CONSTANT:
            return self.steps[0][1]
        return Program(tuple(self.steps), self.text[self.start : self.at])

    def _prefix(self, step):
        """A sign or "#" in front of what was just compiled; constants are taken up at once."""
        what, arg = self.steps[-1]
        if what == CONSTANT and step[0] == NEGATE:
            self.steps[-1] = (CONSTANT, -arg)
        elif what == CONSTANT and step[0] == NUMBERED and arg.is_integer() and 1 <= arg <= PLAIN:
            self.steps[-1] = (DIRECT, int(arg))
        else:
            self.steps.append(step)

    def _operand(self) -> bool:
        """Read one piece of an operand; whether the operand goes on."""
        text, at = self.text, self.at
        c = text[at : at + 1]
        if c in ("+", "-"):
            self.at += 1
            if c == "-":
                self.stack.append(("prefix", (NEGATE, None), 0))
            return True
        if c == "[":
            self.at += 1
            self.stack.append(("bracket", None, 0))
            return True
        if c == "#":
            return self._parameter()
        if c and c in "0123456789.":
            self.steps.append((CONSTANT, self._number()))
            return False
        function = _FUNCTION.match(text, at)
        if function:
            return self._function(function[0], function.end())
        raise self._no_operand()

    def _parameter(self):
        if self.text[self.at + 1 : self.at + 2] == "<":
            name, self.at = read_name(self.text, self.at + 1)
            self.steps.append((NAMED, name))
            return False
        self.at += 1
        self.stack.append(("prefix", (NUMBERED, None), 0))
        return True

    def _function(self, name, at):
        text = self.text
        if text[at : at + 1] != "[":
            raise ProgramError(f'{name} without "["', value=show(text[self.start :]), cure=f"write {name}[...]")
        self.at = at + 1
        if name == "ATAN":
            self.stack.append(("atan", None, 0))
        elif name != "EXISTS":
            self.stack.append(("bracket", (FUNCTION, UNARY[name]), 0))
        elif text[at + 1 : at + 2] != "#":
            cure = "write e.g. EXISTS[#<depth>]"
            raise ProgramError("EXISTS asks for a parameter", value=show(text[self.start :]), cure=cure)
        elif text[at + 2 : at + 3] == "<":
            name, self.at = read_name(text, at + 2)
            self.steps.append((EXISTS_NAMED, name))
            if text[self.at : self.at + 1] != "]":
                raise self._exists_more()
            self.at += 1
            return False
        else:
            self.at = at + 2
            self.stack.append(("exists", (EXISTS, None), 0))
        return True

    def _number(self):
        found = _NUMBER.match(self.text, self.at)
        if found[0].count(".") > 1:
            raise ProgramError("a number has one point at most", value=show(self.text[self.start :]), cure="remove one")
        if found[0] == ".":
            raise ProgramError("a point without digits", value=show(self.text[self.start :]), cure="write the number")
        self.at = found.end()
        return float(found[0])

    def _close(self) -> bool:
        """The bracket "]" behind an operand; whether an operand must follow."""
        while self.stack[-1][0] == "operation":
            self.steps.append(self.stack.pop()[1])
        kind, step, _ = self.stack.pop()
        self.at += 1
        if kind == "atan":
            if self.text[self.at : self.at + 2] != "/[":
                cure = "write ATAN[y]/[x]"
                raise ProgramError("ATAN has two values", value=show(self.text[self.start :]), cure=cure)
            self.at += 2
            self.stack.append(("bracket", (ARCTANGENT, None), 0))
            return True
        if step:
            self.steps.append(step)
        return False

    def _operation(self) -> bool:
        text, at = self.text, self.at
        if self.stack[-1][0] == "exists":
            raise self._exists_more()
        found = _OPERATION.match(text, at)
        if found is None:
            raise self._no_operation()
        tightness, function = BINARY[found[0]]
        while self.stack[-1][0] == "operation" and self.stack[-1][2] >= tightness:
            self.steps.append(self.stack.pop()[1])
        self.stack.append(("operation", (OPERATION, function), tightness))
        self.at = found.end()
        return True

    # -- what is wrong --------------------------------------------------------------------------------------------

    def _exists_more(self):
        cure = "write e.g. EXISTS[#<depth>]"
        return ProgramError("EXISTS asks for one parameter", value=show(self.text[self.start :]), cure=cure)

    def _no_operand(self):
        written = show(self.text[self.start :])
        word = _WORD.match(self.text, self.at)
        if word and self.text.startswith("[", word.end()):
            near = nearest(word[0], _FUNCTIONS)
            cure = f"did you mean {near}?" if near else "functions are " + ", ".join(sorted(_FUNCTIONS))
            return ProgramError("no such function", value=written, cure=cure)
        inside = any(kind != "prefix" for kind, _, _ in self.stack)
        rule = "a number is missing in an expression" if inside else NO_NUMBER
        return ProgramError(rule, value=written, cure="write e.g. 10, #1 or [#1+2]")

    def _no_operation(self):
        text, at = self.text, self.at
        written = show(text[self.start :])
        if at == len(text):
            return ProgramError("an expression is not closed", value=written, cure='write "]" at its end')
        if re.match(r"E[0-9+-]", text[at:]) and text[at - 1] in "0123456789.":
            return ProgramError("a number has no exponent", value=written, cure="write all its digits")
        if text[at] == "(":
            return ProgramError("a comment inside an expression", value=written, cure="write it behind the expression")
        word = _WORD.match(text, at)
        cure = f"operations are {', '.join(BINARY)}"
        return ProgramError("no such operation", value=show(word[0] if word else text[at:]), cure=cure)
