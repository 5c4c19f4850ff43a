"""The tables by which rays find primitives, as host/tree.c makes them: blocks of up to WIDTH of a kind, corners of polygons,
and trees, here of any shape.
"""

from __future__ import annotations

from typing import Any

import numpy as np

WIDTH = 8
NODE = 0xFFFFFFFF
Tables = dict[str, Any]


def block_tables(fields: Any, tag: int, size: int) -> Tables:
    """Blocks of `size` neighbours, the last repeated where there are fewer; `fields` has a primitive to a row."""
    count, rows = fields.shape
    blocks = np.arange(-(-count // size))
    places = np.minimum(blocks[:, None] * size + np.minimum(np.arange(WIDTH), size - 1), count - 1)
    return {
        "blocks": fields[places].transpose(0, 2, 1).ravel(),
        "block_numbers": places.ravel(),
        "links": np.stack([blocks * rows, tag + blocks], 1),
        "count": [0, len(blocks), 0, 0],
    }


def corner_tables(polygons: Any) -> Tables:
    """Rows of x, y and z, the last corner in front and in what is left over."""
    rows, ranges, units = [], [], 0
    for corners in polygons:
        count = len(corners)
        length = -(-count // WIDTH) * WIDTH + 1
        whole = np.concatenate([corners[-1:], corners, np.repeat(corners[-1:], length - 1 - count, 0)]).T.ravel()
        rows.append(np.concatenate([whole, np.zeros(-len(whole) % WIDTH)]))
        ranges.append([units, count, 0, 0])
        units += len(rows[-1]) // WIDTH
    return {"corners": np.concatenate(rows), "polygon_ranges": np.array(ranges)}


def mix(parts: list[Tables]) -> Tables:
    """One scene of several, each of another kind; primitives are numbered part by part."""
    mixed: Tables = {}
    for part in parts:
        have = {name: len(mixed.get(name, ())) for name in part}
        count, blocks = mixed.get("count", [0, 0, 0, 0]), have["block_numbers"] // WIDTH
        moved = {**part, "count": [a + b for a, b in zip(count, part["count"], strict=True)],
                 "links": part["links"] + [have["blocks"] // WIDTH, blocks],
                 "block_numbers": part["block_numbers"] + have["primitives"]}  # fmt: skip
        for name, table in moved.items():
            mixed[name] = np.concatenate([mixed[name], table]) if name in mixed and name != "count" else table
    return mixed


def renumber(tables: Tables, numbers: Any) -> Tables:
    """The same with other numbers: the primitive that was i is numbers[i]."""
    primitives = np.empty_like(tables["primitives"])
    primitives[numbers] = tables["primitives"]
    return {**tables, "primitives": primitives, "block_numbers": numbers[tables["block_numbers"]]}


def tree_tables(tables: Tables, low: Any, high: Any, rng: np.random.Generator) -> Tables:
    """The same with a tree, of random arities and not a good one, over the blocks; `low` and `high` are of primitives."""
    blocks = tables["block_numbers"].reshape(-1, WIDTH)
    boxes = np.concatenate([low[blocks].min(1), high[blocks].max(1)], 1)
    nodes: list[Any] = []
    links: list[Any] = []

    def add_node(members: Any) -> int:
        index = len(nodes)
        nodes.append(np.full((6, WIDTH), np.inf))
        links.append(np.zeros((WIDTH, 2), int))
        axis = rng.integers(0, 6)
        members = members[np.argsort(boxes[members, axis])]
        for child, some in enumerate(np.array_split(members, min(len(members), rng.integers(2, WIDTH + 1)))):
            nodes[index][:, child] = np.concatenate([boxes[some, :3].min(0), boxes[some, 3:].max(0)])
            links[index][child] = [add_node(some), NODE] if len(some) > 1 else tables["links"][some[0]]
        return index

    add_node(np.arange(len(blocks)))
    count = [tables["count"][0], len(blocks), len(nodes), tables["count"][3]]
    return {**tables, "nodes": np.reshape(nodes, (-1, 48)), "links": np.concatenate(links), "count": count}
