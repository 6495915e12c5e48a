"""Where the bodies of a plan file are at every time stamp, from the pieces in which they move."""

from __future__ import annotations

from .plan import Plan


def body_rows(plan: Plan) -> dict[str, list[list[float]]]:
    """By body that ever moves, a pose per time stamp: those of its pieces, and the last one in between."""
    rests = {body.name: body.pose for body in plan.bodies}
    found: dict[str, list[list[float]]] = {}
    for piece in sorted(plan.body_tracks, key=lambda p: p.first):
        if piece.poses and piece.name in rests:
            rows = found.setdefault(piece.name, [])
            rows += [rows[-1] if rows else rests[piece.name]] * (piece.first - len(rows))
            rows += piece.poses
    for rows in found.values():
        rows += [rows[-1]] * (len(plan.times) - len(rows))
    return found
