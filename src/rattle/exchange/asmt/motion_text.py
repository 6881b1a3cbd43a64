"""Functions of time as Ondsel's solver writes them, turned into expressions of a model.

    2.0d*pi*time                       2.0*pi*t
    0.05d*sin(2*pi*time)^2             0.05*sin(2*pi*t)**2

A number may end in d and an exponent; a sign may stand before a number anywhere; `<n>` is a line break, and text in
quotes is a comment.  A power binds tighter than a sign in front of a term, and not tighter than that of a number.
"""

from __future__ import annotations

import re

from rattle.errors import suggest

FUNCTIONS = {  # of the solver, and of the model
    "abs": "abs", "sin": "sin", "cos": "cos", "tan": "tan", "asin": "asin", "arcsin": "asin", "acos": "acos",
    "arccos": "acos", "arctan": "atan", "atan": "atan", "exp": "exp", "sqrt": "sqrt", "ln": "log",
}  # fmt: skip
TIME = "time"
DEEPEST = 40  # parentheses inside of each other
LONGEST = 4000  # characters
_TOKEN = re.compile(
    r'(?P<skip>(?:\s|<n>|"[^"]*")+)|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eEdD](?:[+-]?\d+)?)?)'
    r"|(?P<word>[A-Za-z]\w*)|(?P<sign>[-+*/^(),])"
)


class MotionTextError(ValueError):
    """What is wrong with the text, in words."""


def model_expression(text: str, begin: float) -> str:
    """The expression over t, the time since the run began; begin: the solver's time at its start [s].

    Raises MotionTextError.
    """
    if len(text) > LONGEST:
        raise MotionTextError(f"it has {len(text)} characters; at most {LONGEST} are read")
    time = "t" if begin == 0.0 else f"(t {'+' if begin > 0.0 else '-'} {abs(begin)!r})"
    reader = _Reader(_tokens(text), time)
    expression = reader.sum()
    if reader.now:
        raise MotionTextError(f"'{reader.now}' is not expected")
    return expression


def _tokens(text: str) -> list[str]:
    tokens, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise MotionTextError(f"'{text[at : at + 20]}' cannot be read")
        at = match.end()
        if match["number"]:
            tokens.append(_number(match["number"]))
        elif not match["skip"]:
            tokens.append(match[0])
    return tokens


def _number(text: str) -> str:
    """A number with an exponent as the model has it."""
    mantissa, letter, exponent = re.split(r"([eEdD])", text) if re.search(r"[eEdD]", text) else (text, "", "")
    plain = f"0{mantissa}" if mantissa.startswith(".") else mantissa
    plain = f"{plain}0" if plain.endswith(".") else plain
    return f"{plain}e{exponent}" if letter and exponent else plain


class _Reader:
    """Recursive descent, as in the solver; every method returns the text of what it has read."""

    def __init__(self, tokens: list[str], time: str) -> None:
        self.tokens = tokens
        self.at = 0
        self.time = time
        self.depth = 0

    @property
    def now(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self, *wanted: str) -> str:
        """The token if it is one of these, else ""."""
        token = self.now if self.now in wanted else ""
        self.at += bool(token)
        return token

    def sum(self) -> str:
        sign = self.take("+", "-")
        text = ("-" if sign == "-" else "") + self.product()
        while sign := self.take("+", "-"):
            text += f" {sign} {self.product()}"
        return text

    def product(self) -> str:
        text = self.power()
        while sign := self.take("*", "/"):
            text += f"{sign}{self.power()}"
        return text

    def power(self) -> str:
        text = self.simple()
        while self.take("^"):  # from right to left, as in the model
            text += f"**{self.simple()}"
        return text

    def simple(self) -> str:
        """A number with its sign, a name, a function, or a sum in parentheses."""
        sign = self.take("+", "-")
        token = self.now
        if not token or token in "+-*/^),":
            raise MotionTextError(f"a number or name is expected {f'before {token!r}' if token else 'at the end'}")
        self.at += 1
        if token == "(":
            text = f"({self.inside()})"
        elif token[0].isdigit():
            text = token
        elif token in FUNCTIONS:
            if not self.take("("):
                raise MotionTextError(f"'(' is expected after {token}")
            text = f"{FUNCTIONS[token]}({self.inside()})"
        elif token in (TIME, "pi"):
            text = self.time if token == TIME else "pi"
        else:
            raise MotionTextError(f"'{token}' is not known here{suggest(token, [*FUNCTIONS, TIME, 'pi'])}")
        return f"(-{text})" if sign == "-" else text

    def inside(self) -> str:
        """A sum up to the parenthesis that ends it."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise MotionTextError(f"more than {DEEPEST} parentheses inside of each other")
        text = self.sum()
        self.depth -= 1
        if not self.take(")"):
            raise MotionTextError("a parenthesis is not closed")
        return text
