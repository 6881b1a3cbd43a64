"""Damaged model texts: mutants of shipped examples, and what reading and checking them may answer."""

from __future__ import annotations

import json
import random
import re
import resource
import sys
import time

import rattle as rt

TOKEN = re.compile(r'"[^"\n]*"|[A-Za-z_][\w.]*|[-+]?\d[\d.eE+-]*|[^\sA-Za-z0-9]')
NUMBERS = (
    "0", "-1", "1e-9", "1e9", "1e300", "1e-300", "5e-324", "-1e155", "1e400", "nan", "-inf", "true", "1e16", "0.5", "3",
)  # fmt: skip
TEXTS = (
    '""', '"nosuch"', '"1 mi"', '"15 parsec"', '"nan mm"', '"-inf"', '"1e400"', '"2*a"', '"t"', '"0/0"', '"1e200 m"',
    '"5 mm"', '"60 deg"', '"sqrt(-1)"', '"ground.O"', '"impact"', '"massless-link"', "[]", "{}", "[0, 0]", "[1e300, 0]",
    '["a", "b"]', "{ value = 1 }", '{ value = "2*a", min = "1 mi" }', "1979-05-27", '"__proto__"', '"\\u0000"',
)  # fmt: skip


LONGEST = 30.0  # CPU time of one text [s], a hundred times the usual


def mutant(text: str, draw: random.Random) -> str:
    """The text with one to three damages: to bytes, tokens, lines, or tables."""
    for _ in range(draw.choice((1, 1, 1, 2, 3))):
        text = draw.choice((_byte, _token, _token, _token, _value, _value, _line, _structure))(text, draw)
    return text


def _byte(text: str, draw: random.Random) -> str:
    k = draw.randrange(len(text) + 1)
    return text[:k] + draw.choice(("", chr(draw.randrange(1, 256)), "\u202e", '"', "0", "e", ".")) + text[k + 1 :]


def _token(text: str, draw: random.Random) -> str:
    tokens = list(TOKEN.finditer(text))
    if not tokens:
        return text
    old = draw.choice(tokens)
    new = draw.choice((draw.choice(NUMBERS), draw.choice(TEXTS), draw.choice(tokens)[0], "", old[0] * 2))
    return text[: old.start()] + new + text[old.end() :]


def _value(text: str, draw: random.Random) -> str:
    """The value behind one key is another."""
    keys = list(re.finditer(r"=[ \t]*([^\n,{}\[\]]+)", text))
    if not keys:
        return text
    old = draw.choice(keys)
    return text[: old.start(1)] + draw.choice((*NUMBERS, *TEXTS)) + text[old.end(1) :]


def _line(text: str, draw: random.Random) -> str:
    lines = text.split("\n")
    k, other = draw.randrange(len(lines)), draw.randrange(len(lines))
    match draw.randrange(4):
        case 0:
            del lines[k]
        case 1:
            lines.insert(other, lines[k])
        case 2:
            lines[k], lines[other] = lines[other], lines[k]
        case _:
            lines[k] = lines[k][: draw.randrange(len(lines[k]) + 1)]
    return "\n".join(lines)


def _structure(text: str, draw: random.Random) -> str:
    """A whole table is dropped, doubled under another name, or takes the place of another."""
    tables = re.split(r"(?m)^(?=\[)", text)
    if len(tables) < 3:
        return text
    k, other = draw.randrange(1, len(tables)), draw.randrange(1, len(tables))
    match draw.randrange(3):
        case 0:
            del tables[k]
        case 1:
            tables.insert(other, tables[k].replace("]", "2]", 1))
        case _:
            header = tables[k].split("\n", 1)[0]
            tables[k] = header + "\n" + tables[other].partition("\n")[2]
    return "".join(tables)


def answer(text: str) -> str:
    """What reading and checking a text answers: "" if it is a sound mechanism; raises what is no answer of ours."""
    try:
        str(rt.loads(text).check())
    except rt.InputError as error:
        return str(error) or "a refusal without a word"
    return ""


def main(count: int, seed: int, memory: int) -> dict[str, object]:
    """Answers to `count` mutants, in a process whose address space is limited to so many bytes."""
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    texts = {name: rt.example(name).to_toml() for name in sorted(rt.examples())}
    sound, escapes = 0, []
    for number in range(count):
        draw = random.Random(f"{seed} {number}")
        name = draw.choice(list(texts))
        text = mutant(texts[name], draw)
        began = time.process_time()
        try:
            found = answer(text)
            sound += not found
            if found.startswith("a refusal without"):
                escapes.append({"example": name, "number": str(number), "error": found[:200]})
        except Exception as error:
            escapes.append({"example": name, "number": str(number), "error": f"{type(error).__name__}: {error}"[:200]})
        if (took := time.process_time() - began) > LONGEST:
            escapes.append({"example": name, "number": str(number), "error": f"took {took:.0f} s"})
    return {"sound": sound, "refused": count - sound - len(escapes), "escapes": escapes}


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main(*map(int, sys.argv[1:4]))) + "\n")
