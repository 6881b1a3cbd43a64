"""Sources of random kernels: all constructs that kernels are written with, nested at random."""

from __future__ import annotations

import random

HEAD = """
import math

import numpy as np

from rattle.jit.functions import compiled

LIMITS = np.linspace(-1.0, 1.0, 5)


@compiled
def helper(x, i):
    if x > 0.25:
        return x * LIMITS[i % 5], i - 1
    return min(x, float(i)), max(i, 2)


@compiled
def change(line, part, x):
    for k in range(part.shape[0]):
        part[k] += line[k % 4] * x
        line[k % 4] -= 0.25 * part[k]


@compiled
def kernel(x, y, i, j, row, tab, cnt):
"""


class Source:
    """The source of one kernel f(x, y, i, j, row (5,), tab (3, 4), cnt (3,)) -> (float, int, float)."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.whole = ["i", "j"]  # variables that are integers
        self.loops = 0
        self.text = HEAD + "\n".join([*self.block(4, 1), *self.block(3, 1), "    return x, i + j, y", ""])

    def any(self, *choices: str) -> str:
        return self.random.choice(choices)

    # ---------------------------------------------------------------- expressions
    def number(self, deep: int) -> str:
        simple = (
            "x", "y", f"{self.random.uniform(-3, 3):.3f}", f"row[{self.place(5)}]",
            f"tab[{self.place(3)}, {self.place(4)}]",
        )  # fmt: skip
        if deep <= 0 or self.random.random() < 0.25:
            return self.any(*simple)
        a, b, k = self.number(deep - 1), self.number(deep - 1), self.integer(deep - 1)
        return self.any(
            f"({a} + {b})", f"({a} - {b})", f"({a} * {b})", f"({a} * {k})", f"max({a}, {b})", f"min({a}, {b})",
            f"abs({a})", f"({a} if {self.truth(deep - 1)} else {b})", f"math.sqrt(abs({a}))",
            f"({a} / (1.0 + abs({b})))",
            f"math.sin(1e-3 * {a})", f"helper({a}, {k})[{self.any('0', '1')}]", f"math.copysign({a}, {b})", f"-{a}",
            f"float({k})", f"float({self.truth(deep - 1)})",
        )  # fmt: skip

    def integer(self, deep: int) -> str:
        if deep <= 0 or self.random.random() < 0.3:
            return self.any(*self.whole, str(self.random.randint(-4, 7)), "cnt[i % 3]", "row.shape[0]", "tab.shape[1]")
        a, b = self.integer(deep - 1), self.integer(deep - 1)
        return self.any(
            f"({a} + {b}) % 97", f"({a} - {b}) % -7", f"({a} * {b}) % 97", f"({a} // 3)", f"({a} // -2)",
            f"max({a}, {b})",
            f"({a} // (abs(i) + 1))", f"({a} if {self.truth(deep - 1)} else {b})", f"({a} & {b})", f"({a} | {b})",
            f"int({self.truth(deep - 1)})",
        )  # fmt: skip

    def truth(self, deep: int) -> str:
        sign = self.any("<", "<=", ">", ">=", "==", "!=")
        if deep <= 0 or self.random.random() < 0.4:
            return self.any(f"{self.number(0)} {sign} {self.number(0)}", f"{self.integer(0)} {sign} {self.integer(0)}")
        a, b = self.truth(deep - 1), self.truth(deep - 1)
        between = f"({self.number(deep - 1)} < {self.number(deep - 1)} <= {self.number(deep - 1)})"
        among = f"{self.integer(deep - 1)} {self.any('in', 'not in')} ({self.random.randint(0, 5)}, 3, i)"
        return self.any(f"({a} and {b})", f"({a} or {b})", f"(not {a})", between, among)

    def place(self, size: int) -> str:
        return self.any("0", str(size - 1), f"i % {size}", f"(i + j) % {size}", f"cnt[j % 3] % {size}")

    # ---------------------------------------------------------------- statements
    def block(self, deep: int, indent: int, inside: bool = False) -> list[str]:
        return [line for _ in range(self.random.randint(1, 4)) for line in self.statement(deep, indent, inside)]

    def statement(self, deep: int, indent: int, inside: bool) -> list[str]:
        space, choice = "    " * indent, self.random.random()
        if deep <= 0 or choice < 0.4:
            return [space + one for one in self.simple()]
        if choice < 0.6:
            return self.branches(deep, indent, inside)
        if choice < 0.8:
            return self.loop(deep, indent)
        if choice < 0.9:
            name = f"n{self.count()}"
            head = [f"{space}{name} = 0", f"{space}while {name} < 4 and {self.truth(1)}:", f"{space}    {name} += 1"]
            return [*head, *self.block(deep - 1, indent + 1, inside=True)]
        if choice < 0.94 and inside:
            return [f"{space}if {self.truth(1)}:", f"{space}    {self.any('break', 'continue')}"]
        if choice < 0.97:
            return [f"{space}for s in (0.5, x, -2.0):", f"{space}    y += s * {self.number(1)}"]
        return [f"{space}if {self.truth(1)}:", f"{space}    return {self.number(1)}, {self.integer(1)}, y"]

    def simple(self) -> list[str]:
        a, b, k = self.number(2), self.number(2), self.integer(2)
        line, part = f"tab[{self.place(3)}]", f"row[{self.any('', '1')}:{self.any('3', '4', '9')}]"
        return self.random.choice(
            [
                [f"{self.any('x', 'y')} = {a}"], [f"{self.any('x', 'y')} {self.any('+=', '-=', '*=')} 0.5 * {a}"],
                [f"{self.any('i', 'j')} = {k} % 11"], [f"row[{self.place(5)}] {self.any('=', '+=')} {a}"],
                [f"tab[{self.place(3)}, {self.place(4)}] = {a}"], [f"cnt[{self.place(3)}] = {k} % 13"],
                [f"x, y = {a}, {b}"], [f"y, i = helper({a}, {k})", "i = i % 11"], [f"change({line}, {part}, {a})"],
                [f"w = {self.any(a, k, self.truth(2))}", "x += w"],
            ]
        )  # fmt: skip

    def branches(self, deep: int, indent: int, inside: bool) -> list[str]:
        space = "    " * indent
        found = [f"{space}if {self.truth(2)}:", *self.block(deep - 1, indent + 1, inside)]
        if self.random.random() < 0.4:
            found += [f"{space}elif {self.truth(1)}:", *self.block(deep - 1, indent + 1, inside)]
        if self.random.random() < 0.5:
            found += [f"{space}else:", *self.block(deep - 1, indent + 1, inside)]
        return found

    def loop(self, deep: int, indent: int) -> list[str]:
        over = self.any(f"{self.integer(1)} % 5", "3", f"1, {self.integer(1)} % 6", "5, 0, -2", "-1, 4")
        name = f"k{self.count()}"
        self.whole.append(name)
        found = [f"{'    ' * indent}for {name} in range({over}):", *self.block(deep - 1, indent + 1, inside=True)]
        self.whole.remove(name)
        return found

    def count(self) -> int:
        self.loops += 1
        return self.loops
