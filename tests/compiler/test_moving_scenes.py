"""Bodies that move on their own and modules that fail: where the text puts them, and what the seed changes."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamplang.compiler import ir
from tamplang.compiler.courses import centre_at
from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.poses import position
from tamplang.compiler.printing import format_ir
from tamplang.compiler.scenes.happenings import unseen

HEAD = "import std.crawler\nimport std.rules\nimport std.scenes\n"


def problem(items: str, seed: int = 0) -> ir.Problem:
    text = f"""{HEAD}
    task t(pace: speed = 1 cm/s) {{
        scene stairs(3)
        object b: box(6 cm, 6 cm, 6 cm) at (1 m, 2 m, 3 m) heading 30 deg
        crawler c: A on ground
        {items}
        goal (on ground c.B)
    }}"""
    return compile_text(text, seed=seed)[0]


def test_points_count_from_where_the_body_is_when_it_starts() -> None:
    made = problem(
        """moves b along (0, 0, 2 m) at 2 * pace from 100 s
        moves b along (10 cm, 0, 0), (10 cm, 20 cm, 0) at pace from 5 s
        disturb b by (0, 0, 1 m) at 20 s"""
    ).world.courses
    assert [(c.start, c.speed, c.returns) for c in made] == [(5, 0.01, False), (20, 0, False), (100, 0.02, False)]
    assert made[0].points == (pytest.approx((1.1, 2, 3)), pytest.approx((1.1, 2.2, 3)))
    assert made[1].points == (pytest.approx((1.1, 2.05, 4)),)
    assert made[2].points == (pytest.approx((1.1, 2.05, 6)),)


def test_a_later_course_ends_an_earlier_one() -> None:
    begin = (0.0, 0.0, 0.0)
    away = ir.Course("b", 1.0, ((3.0, 0.0, 0.0), (3.0, 4.0, 0.0)), 1.0, False)
    jump = ir.Course("b", 5.0, ((0.0, 0.0, 9.0),), 0.0, False)
    home = ir.Course("b", 6.0, ((0.0, 0.0, 8.0),), 0.5, True)
    places = {0: begin, 2: (1, 0, 0), 4.5: (3, 0.5, 0), 5: (0, 0, 9), 6: (0, 0, 9), 7: (0, 0, 8.5), 9: (0, 0, 8.5)}
    for time, place in places.items():
        assert centre_at(begin, (home, jump, away), time) == pytest.approx(place)
    assert centre_at(begin, (away,), 100) == (3, 4, 0)
    assert centre_at(begin, (), 3) == begin


@given(st.floats(0, 1e4), st.floats(0.01, 2), st.lists(st.tuples(*[st.floats(-3, 3)] * 3), min_size=1, max_size=4))
def test_no_body_on_its_way_and_back_is_faster_than_its_speed(
    time: float, speed: float, points: list[tuple[float, float, float]]
) -> None:
    course = ir.Course("b", 0.0, tuple(points), speed, True)
    one, other = centre_at((0, 0, 0), (course,), time), centre_at((0, 0, 0), (course,), time + 0.5)
    assert math.dist(one, other) <= 0.5 * speed + 1e-6


def test_what_happens_comes_out_by_time_and_by_seed() -> None:
    items = """for i in 1 .. 3 {
        moves stair[i] along (0, jitter(5 cm), 1 cm) at random(pace, 2 * pace) from 9 s - i * 1 s
    }
    fail c at 20 s: gone
    fail c at 10 s: locked"""
    still, one, same, other = problem(""), problem(items), problem(items), problem(items, seed=1)
    assert one == same
    assert one.world.bodies == still.world.bodies
    assert [(b.kind, b.time) for b in one.world.breakdowns] == [("locked", 10), ("gone", 20)]
    ways = {tuple(c.points) for p in (one, other) for c in p.world.courses}
    assert len(ways) == 6
    for course in one.world.courses:
        assert 0.01 <= course.speed <= 0.02
        assert abs(course.points[0][1] - position(one.world.bodies[course.body].pose)[1]) <= 0.05
    text = format_ir(one)
    assert "\ncourses\n  stair[3]: along (" in text and "from 6\n" in text
    assert "\nbreakdowns\n  c: locked at 10\n  c: gone at 20\n" in text
    assert "courses" not in format_ir(still)


def test_a_plan_for_the_start_does_not_see_what_happens_later() -> None:
    found = unseen(problem("disturb b by (1 m, 0, 0) at 9 s fail c at 2 s: gone").world)
    assert found is not None and found.code == "W0008" and found.span is not None
    assert found.help is not None and "tamplang run" in found.help
    assert unseen(problem("").world) is None


def test_what_stands_on_a_body_that_moves_goes_along() -> None:
    text = f"""{HEAD}
    task t() {{
        base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
        base shelf: box(20 cm, 20 cm, 5 cm) at (0, 0, LOW)
        moves ground along (5 cm, 5 cm, 10 cm) at 1 cm/s and back
        crawler c: A on ground at (0.5 m, 0)
        goal (on ground c.B)
    }}"""
    clear, warned = (compile_text(text.replace("LOW", low))[1] for low in ("90 cm", "11 cm"))
    assert not clear and [d.code for d in warned] == ["W0007"]
