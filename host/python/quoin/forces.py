"""Resultants of joints, and the line of thrust through them."""
import numpy as np

BED = 0.7     # least |y| of the normal of a bed joint
ROUNDED = 1e-6  # largest displacement of blocks that are held, over that of all blocks
LEVEL = 0.3   # gap between two levels of bed joints, over the height of a block
APART = 0.3   # gap between supports of one group, over the size of a block


def pressed(moment, least=0.01):
    """Joints in compression with a force above a share of the largest: rows of moment.forces, as a dict of arrays."""
    forces = moment.forces
    size = np.linalg.norm(forces["force_N"].astype(float), axis=1)
    chosen = (forces["normal_force_N"] < 0) & (size > least * max(size.max(initial=0.0), 1e-300))
    return {name: forces[name][chosen] for name in ("position", "force_N", "normal", "block_a", "block_b")}


def boxes(moment):
    """By block: lower and upper corner at the start, and whether it has moved."""
    blocks, found = moment.blocks, {}
    start, far = blocks["position"].astype(float), np.abs(blocks["displacement_m"]).max(axis=1)
    moved = far > ROUNDED * far.max(initial=0.0)
    block = np.repeat(blocks["block"], np.diff(blocks["offsets"], prepend=0))
    corner = blocks["connectivity"]
    for b in np.unique(block):
        of = corner[block == b]
        found[int(b)] = start[of].min(axis=0), start[of].max(axis=0), bool(moved[of].any())
    return found


def thrust_lines(moment):
    """Pieces of the line of thrust, (from, to) each, m. In arches and columns they connect the two joints of each block.
    Between two abutments, as in vaults, they pass through the resultants of joints at an equal number of blocks from one
    abutment. Otherwise, as in walls, piers and buttresses, they pass through those of bed joints at one level. Joints
    that share blocks have one resultant."""
    joints, box = pressed(moment), boxes(moment)
    pairs, places = np.stack([joints["block_a"], joints["block_b"]], axis=1).tolist(), joints["position"].astype(float)
    of = {}
    for j, pair in enumerate(pairs):
        for b in pair:
            if box[b][2]:
                of.setdefault(b, []).append(j)
    if not of:
        return []
    if np.quantile([len(list_of) for list_of in of.values()], 0.9) <= 2:
        return [(places[l[0]], places[l[1]]) for l in of.values() if len(l) == 2]
    abutments = _supports({b for pair in pairs for b in pair}, box)
    if len(abutments) == 2:
        return _through_rings(pairs, places, np.linalg.norm(joints["force_N"].astype(float), axis=1), abutments[0])
    middle = {b: (low + high) / 2 for b, (low, high, _) in box.items()}
    level = np.array([(middle[a][1] + middle[b][1]) / 2 for a, b in pairs])
    heights = [high[1] - low[1] for low, high, moves in box.values() if moves]
    beds = sorted((j for j in range(len(pairs)) if abs(joints["normal"][j, 1]) > BED), key=lambda j: level[j])
    levels = []
    for j in beds:
        if levels and level[j] - level[levels[-1][-1]] < LEVEL * np.median(heights):
            levels[-1].append(j)
        else:
            levels.append([j])
    push = abs(joints["force_N"][:, 1].astype(float))
    return _joined([_resultants(some, pairs, places, push, lambda b: middle[b][1]) for some in levels])


def _supports(pressed_blocks, box):
    """Blocks that hold others and do not move: groups of adjacent ones."""
    size = np.median([max(high - low) for low, high, _ in box.values()])
    groups = []
    for b in sorted(b for b in pressed_blocks if not box[b][2]):
        low, high, _ = box[b]
        touching = [g for g in groups if any(np.all(np.minimum(high, box[o][1]) - np.maximum(low, box[o][0]) > -APART * size) for o in g)]
        groups = [g for g in groups if g not in touching] + [[b] + [o for g in touching for o in g]]
    return groups


def _through_rings(pairs, places, push, abutment):
    beside, away, row = {}, dict.fromkeys(abutment, 0), list(abutment)
    for a, b in pairs:
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    for b in row:  # grows during the loop
        for other in beside.get(b, []):
            if other not in away:
                away[other] = away[b] + 1
                row.append(other)
    far = len(away)
    steps = [(away.get(a, far), away.get(b, far)) for a, b in pairs]
    cuts = [[j for j, (a, b) in enumerate(steps) if a != b and min(a, b) == k] for k in range(far)]
    return _joined([_resultants(cut, pairs, places, push, lambda b: away.get(b, far)) for cut in cuts])


def _joined(cuts):
    return [(below[0], above[0]) for lower, upper in zip(cuts, cuts[1:]) for below in lower for above in upper if below[1] & above[2]]


def _resultants(joints, pairs, places, push, height):
    """Resultants of groups of joints that share blocks: (place, blocks above, blocks below)."""
    groups = []
    for j in joints:
        touching = [g for g in groups if g[0] & set(pairs[j])]
        groups = [g for g in groups if g not in touching]
        groups.append((set(pairs[j]).union(*(g[0] for g in touching)), [j] + [k for g in touching for k in g[1]]))
    result = []
    for _, of in groups:
        upper = {max(pairs[j], key=height) for j in of}
        lower = {min(pairs[j], key=height) for j in of}
        result.append((np.average(places[of], axis=0, weights=push[of] + 1e-300), upper, lower))
    return result
