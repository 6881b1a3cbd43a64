"""Loops of a mechanism: the joints that close them, and their names."""

from __future__ import annotations

from collections import deque

from rattle.description.model import GROUND, Joint, Model, frame_of


def tree_path(model: Model, start: str, end: str, without: str) -> list[str] | None:
    """Joints on the shortest path from one body to another that does not use the joint `without`; None if none."""
    near: dict[str, list[tuple[str, str]]] = {}
    for name, joint in model.joints.items():
        if name != without and not joint.held_by_stops:
            a, b = frame_of(joint.a.body), frame_of(joint.b.body)
            near.setdefault(a, []).append((name, b))
            near.setdefault(b, []).append((name, a))
    came: dict[str, tuple[str, str] | None] = {start: None}
    queue = deque([start])
    while queue:
        body = queue.popleft()
        if body == end:
            path = []
            step = came[body]
            while step is not None:
                path.append(step[0])
                step = came[step[1]]
            return path[::-1]
        for name, other in near.get(body, ()):
            if other not in came:
                came[other] = (name, body)
                queue.append(other)
    return None


def describe_loop(model: Model, joint: Joint, path: list[str]) -> str:
    """ "ground -O1- crank -O2- coupler -O3- ground" for the loop that `joint` closes over `path`."""
    body = frame_of(joint.a.body)
    text = body
    for name in path:
        a, b = (frame_of(end.body) for end in (model.joints[name].a, model.joints[name].b))
        body = b if a == body else a
        text += f" -{name}- {body}"
    return f"{text} -{joint.name}- {frame_of(joint.a.body)}"


def loops(model: Model) -> list[tuple[Joint, list[str]]]:
    """Independent loops, one per joint that closes a loop of the spanning tree: the joint, and the path it closes."""
    group = {name: frame_of(name) for name in (GROUND, *model.bodies)}

    def find(body: str) -> str:
        while group[body] != body:
            group[body] = group[group[body]]
            body = group[body]
        return body

    closing = []
    kept: dict[str, Joint] = {}
    for joint in model.joints.values():
        if joint.leaf.bodies or joint.held_by_stops or joint.leaf.touches:
            continue
        a, b = find(joint.a.body), find(joint.b.body)
        if a == b:
            closing.append(joint)
        else:
            group[a] = b
            kept[joint.name] = joint
    from dataclasses import replace

    tree = replace(model, joints=kept)
    closed = []
    for joint in closing:
        path = tree_path(tree, frame_of(joint.a.body), frame_of(joint.b.body), without="")
        if path is not None:
            closed.append((joint, path))
    return closed
