"""Classic planning domains, written anew in PDDL, with instances of any size: `INSTANCES` are those that are tried."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from itertools import pairwise

BLOCKS = """(define (domain blocks)
  (:requirements :strips)
  (:predicates (on ?x ?y) (on-table ?x) (clear ?x) (hand-empty) (holding ?x))
  (:action pick-up :parameters (?x)
    :precondition (and (clear ?x) (on-table ?x) (hand-empty))
    :effect (and (not (on-table ?x)) (not (clear ?x)) (not (hand-empty)) (holding ?x)))
  (:action put-down :parameters (?x)
    :precondition (holding ?x)
    :effect (and (not (holding ?x)) (clear ?x) (hand-empty) (on-table ?x)))
  (:action stack :parameters (?x ?y)
    :precondition (and (holding ?x) (clear ?y))
    :effect (and (not (holding ?x)) (not (clear ?y)) (clear ?x) (hand-empty) (on ?x ?y)))
  (:action unstack :parameters (?x ?y)
    :precondition (and (on ?x ?y) (clear ?x) (hand-empty))
    :effect (and (holding ?x) (clear ?y) (not (clear ?x)) (not (hand-empty)) (not (on ?x ?y)))))
"""
GRIPPER = """(define (domain gripper)
  (:requirements :strips :typing)
  (:types room ball hand)
  (:constants left right - hand)
  (:predicates (robot-in ?r - room) (in ?b - ball ?r - room) (free ?h - hand) (carries ?h - hand ?b - ball))
  (:action move :parameters (?from ?to - room)
    :precondition (robot-in ?from)
    :effect (and (robot-in ?to) (not (robot-in ?from))))
  (:action pick :parameters (?b - ball ?r - room ?h - hand)
    :precondition (and (in ?b ?r) (robot-in ?r) (free ?h))
    :effect (and (carries ?h ?b) (not (in ?b ?r)) (not (free ?h))))
  (:action drop :parameters (?b - ball ?r - room ?h - hand)
    :precondition (and (carries ?h ?b) (robot-in ?r))
    :effect (and (in ?b ?r) (free ?h) (not (carries ?h ?b)))))
"""
HANOI = """(define (domain hanoi)
  (:requirements :strips :equality)
  (:predicates (clear ?x) (on ?x ?y) (smaller ?x ?y))
  (:action move :parameters (?disc ?from ?to)
    :precondition (and (smaller ?disc ?to) (on ?disc ?from) (clear ?disc) (clear ?to) (not (= ?from ?to)))
    :effect (and (clear ?from) (on ?disc ?to) (not (on ?disc ?from)) (not (clear ?to)))))
"""
LOGISTICS = """(define (domain logistics)
  (:requirements :strips :typing)
  (:types truck airplane - vehicle
          package vehicle - movable
          airport - location
          location city movable - object)
  (:predicates (at ?x - movable ?l - location) (in ?p - package ?v - vehicle) (in-city ?l - location ?c - city))
  (:action load :parameters (?p - package ?v - vehicle ?l - location)
    :precondition (and (at ?v ?l) (at ?p ?l))
    :effect (and (in ?p ?v) (not (at ?p ?l))))
  (:action unload :parameters (?p - package ?v - vehicle ?l - location)
    :precondition (and (at ?v ?l) (in ?p ?v))
    :effect (and (at ?p ?l) (not (in ?p ?v))))
  (:action drive :parameters (?t - truck ?from ?to - location ?c - city)
    :precondition (and (at ?t ?from) (in-city ?from ?c) (in-city ?to ?c))
    :effect (and (at ?t ?to) (not (at ?t ?from))))
  (:action fly :parameters (?a - airplane ?from ?to - airport)
    :precondition (at ?a ?from)
    :effect (and (at ?a ?to) (not (at ?a ?from)))))
"""
FERRY = """(define (domain ferry)
  (:requirements :strips :typing :negative-preconditions)
  (:types car port)
  (:predicates (ferry-at ?p - port) (car-at ?c - car ?p - port) (aboard ?c - car) (loaded))
  (:action sail :parameters (?from ?to - port)
    :precondition (ferry-at ?from)
    :effect (and (ferry-at ?to) (not (ferry-at ?from))))
  (:action board :parameters (?c - car ?p - port)
    :precondition (and (car-at ?c ?p) (ferry-at ?p) (not (loaded)))
    :effect (and (aboard ?c) (loaded) (not (car-at ?c ?p))))
  (:action debark :parameters (?c - car ?p - port)
    :precondition (and (aboard ?c) (ferry-at ?p))
    :effect (and (car-at ?c ?p) (not (aboard ?c)) (not (loaded)))))
"""
LIFT = """(define (domain lift)
  (:requirements :adl)
  (:types passenger floor)
  (:predicates (origin ?p - passenger ?f - floor) (target ?p - passenger ?f - floor) (above ?low ?high - floor)
    (boarded ?p - passenger) (served ?p - passenger) (lift-at ?f - floor))
  (:action stop :parameters (?f - floor)
    :precondition (lift-at ?f)
    :effect (and
      (forall (?p - passenger) (when (and (boarded ?p) (target ?p ?f)) (and (not (boarded ?p)) (served ?p))))
      (forall (?p - passenger) (when (and (origin ?p ?f) (not (served ?p))) (boarded ?p)))))
  (:action up :parameters (?from ?to - floor)
    :precondition (and (lift-at ?from) (above ?from ?to))
    :effect (and (lift-at ?to) (not (lift-at ?from))))
  (:action down :parameters (?from ?to - floor)
    :precondition (and (lift-at ?from) (above ?to ?from))
    :effect (and (lift-at ?to) (not (lift-at ?from)))))
"""
SATELLITE = """(define (domain satellite)
  (:requirements :strips :typing :equality)
  (:types satellite instrument direction mode)
  (:predicates (on-board ?i - instrument ?s - satellite) (supports ?i - instrument ?m - mode)
    (pointing ?s - satellite ?d - direction) (power-avail ?s - satellite) (power-on ?i - instrument)
    (calibrated ?i - instrument) (have-image ?d - direction ?m - mode) (target-of ?i - instrument ?d - direction))
  (:action turn-to :parameters (?s - satellite ?to ?from - direction)
    :precondition (and (pointing ?s ?from) (not (= ?to ?from)))
    :effect (and (pointing ?s ?to) (not (pointing ?s ?from))))
  (:action switch-on :parameters (?i - instrument ?s - satellite)
    :precondition (and (on-board ?i ?s) (power-avail ?s))
    :effect (and (power-on ?i) (not (calibrated ?i)) (not (power-avail ?s))))
  (:action switch-off :parameters (?i - instrument ?s - satellite)
    :precondition (and (on-board ?i ?s) (power-on ?i))
    :effect (and (power-avail ?s) (not (power-on ?i))))
  (:action calibrate :parameters (?s - satellite ?i - instrument ?d - direction)
    :precondition (and (on-board ?i ?s) (target-of ?i ?d) (pointing ?s ?d) (power-on ?i))
    :effect (calibrated ?i))
  (:action take-image :parameters (?s - satellite ?d - direction ?i - instrument ?m - mode)
    :precondition (and (calibrated ?i) (on-board ?i ?s) (supports ?i ?m) (power-on ?i) (pointing ?s ?d))
    :effect (have-image ?d ?m)))
"""
TRANSPORT = """(define (domain transport)
  (:requirements :typing :action-costs)
  (:types van parcel - thing town)
  (:predicates (road ?a ?b - town) (at ?x - thing ?t - town) (in ?p - parcel ?v - van) (empty ?v - van))
  (:functions (total-cost) - number (road-length ?a ?b - town) - number)
  (:action drive :parameters (?v - van ?a ?b - town)
    :precondition (and (at ?v ?a) (road ?a ?b))
    :effect (and (not (at ?v ?a)) (at ?v ?b) (increase (total-cost) (road-length ?a ?b))))
  (:action pick-up :parameters (?v - van ?t - town ?p - parcel)
    :precondition (and (at ?v ?t) (at ?p ?t) (empty ?v))
    :effect (and (not (at ?p ?t)) (in ?p ?v) (not (empty ?v)) (increase (total-cost) 1)))
  (:action drop :parameters (?v - van ?t - town ?p - parcel)
    :precondition (and (at ?v ?t) (in ?p ?v))
    :effect (and (at ?p ?t) (empty ?v) (not (in ?p ?v)) (increase (total-cost) 1))))
"""
BRIEFCASE = """(define (domain briefcase)
  (:requirements :strips :typing :conditional-effects :quantified-preconditions :negative-preconditions :equality)
  (:types paper place)
  (:constants office - place)
  (:predicates (at ?p - paper ?l - place) (inside ?p - paper) (case-at ?l - place) (locked))
  (:action carry :parameters (?from ?to - place)
    :precondition (and (case-at ?from) (not (= ?from ?to)) (imply (= ?to office) (locked)))
    :effect (and (case-at ?to) (not (case-at ?from))
      (forall (?p - paper) (when (inside ?p) (and (at ?p ?to) (not (at ?p ?from)))))))
  (:action lock :parameters () :precondition (exists (?p - paper) (inside ?p)) :effect (locked))
  (:action put-in :parameters (?p - paper ?l - place)
    :precondition (and (case-at ?l) (at ?p ?l) (not (inside ?p)) (not (locked))) :effect (inside ?p))
  (:action take-out :parameters (?p - paper)
    :precondition (inside ?p) :effect (and (not (inside ?p)) (not (locked)))))
"""
VISIT = """(define (domain visit-all)
  (:requirements :typing)
  (:types cell)
  (:predicates (next ?a ?b - cell) (robot ?c - cell) (visited ?c - cell))
  (:action move :parameters (?from ?to - cell)
    :precondition (and (robot ?from) (next ?from ?to))
    :effect (and (robot ?to) (visited ?to) (not (robot ?from)))))
"""
LIGHTS = """(define (domain lights)
  (:requirements :adl)
  (:types lamp)
  (:predicates (lit ?l - lamp) (near ?a ?b - lamp))
  (:action press :parameters (?l - lamp)
    :effect (forall (?x - lamp) (and
      (when (and (lit ?x) (or (= ?x ?l) (near ?x ?l))) (not (lit ?x)))
      (when (and (not (lit ?x)) (or (= ?x ?l) (near ?x ?l))) (lit ?x))))))
"""
PUZZLE = """(define (domain puzzle)
  (:requirements :strips :typing)
  (:types tile position)
  (:predicates (at ?t - tile ?p - position) (empty ?p - position) (neighbours ?a ?b - position))
  (:action slide :parameters (?t - tile ?from ?to - position)
    :precondition (and (at ?t ?from) (empty ?to) (neighbours ?from ?to))
    :effect (and (at ?t ?to) (empty ?from) (not (at ?t ?from)) (not (empty ?to)))))
"""
WORKSHOP = """(define (domain workshop)
  (:requirements :adl :derived-predicates :action-costs)
  (:types part - object wheel frame - part station)
  (:predicates (at ?p - part ?s - station) (mounted ?w - wheel ?f - frame) (painted ?p - part) (ready ?f - frame)
    (here ?s - station) (busy ?s - station) (paint-shop ?s - station))
  (:functions (total-cost) (paint-cost ?p - part))
  (:derived (ready ?f - frame) (and (painted ?f) (forall (?w - wheel) (imply (mounted ?w ?f) (painted ?w)))
    (exists (?w - wheel) (mounted ?w ?f))))
  (:derived (busy ?s - station) (exists (?p - part) (at ?p ?s)))
  (:action go :parameters (?a ?b - station)
    :precondition (here ?a) :effect (and (here ?b) (not (here ?a)) (increase (total-cost) 2)))
  (:action bring :parameters (?p - part ?a ?b - station)
    :precondition (and (here ?a) (at ?p ?a) (not (busy ?b)))
    :effect (and (at ?p ?b) (here ?b) (not (at ?p ?a)) (not (here ?a)) (increase (total-cost) 3)))
  (:action paint :parameters (?p - part ?s - station)
    :precondition (and (here ?s) (at ?p ?s) (paint-shop ?s) (not (painted ?p)))
    :effect (and (painted ?p) (increase (total-cost) (paint-cost ?p))))
  (:action mount :parameters (?w - wheel ?f - frame ?a ?b - station)
    :precondition (and (here ?a) (at ?w ?a) (at ?f ?b) (not (exists (?o - frame) (mounted ?w ?o))))
    :effect (and (mounted ?w ?f) (not (at ?w ?a)) (increase (total-cost) 1))))
"""


def problem(domain: str, objects: str, init: str, goal: str, metric: str = "") -> str:
    """The text of a problem."""
    head = f"(define (problem {domain}-1) (:domain {domain})\n  (:objects {objects})\n"
    return f"{head}  (:init {init})\n  (:goal (and {goal})){metric})\n"


def blocks(n: int, seed: int) -> str:
    """n blocks in random towers, to be built into others."""
    drawn = random.Random(f"blocks {n} {seed}")
    names = [f"b{k}" for k in range(n)]

    def towers() -> list[list[str]]:
        made: list[list[str]] = []
        for name in drawn.sample(names, n):
            if made and drawn.random() < 0.6:
                drawn.choice(made).append(name)
            else:
                made.append([name])
        return made

    start, end = towers(), towers()
    init = [f"(on-table {t[0]}) (clear {t[-1]})" for t in start]
    init += [f"(on {b} {a})" for t in start for a, b in pairwise(t)]
    goal = [f"(on {b} {a})" for t in end for a, b in pairwise(t)] or [f"(on {names[0]} {names[1]})"]
    return problem("blocks", " ".join(names), " ".join([*init, "(hand-empty)"]), " ".join(goal))


def gripper(n: int, seed: int) -> str:
    """n balls from one room to the other."""
    balls = [f"ball{k}" for k in range(n)]
    init = " ".join(f"(in {b} rooma)" for b in balls) + " (robot-in rooma) (free left) (free right)"
    return problem(
        "gripper", " ".join(balls) + " - ball rooma roomb - room", init, " ".join(f"(in {b} roomb)" for b in balls)
    )


def hanoi(n: int, seed: int) -> str:
    """n discs from the first peg to the last."""
    discs = [f"d{k}" for k in range(1, n + 1)]
    pegs = ["peg1", "peg2", "peg3"]
    smaller = [f"(smaller {d} {p})" for d in discs for p in pegs]
    smaller += [f"(smaller {discs[i]} {discs[j]})" for j in range(n) for i in range(j)]
    tower = [f"(on {a} {b})" for a, b in zip(discs, [*discs[1:], "peg1"], strict=True)]
    goal = [f"(on {a} {b})" for a, b in zip(discs, [*discs[1:], "peg3"], strict=True)]
    init = [*smaller, *tower, "(clear d1)", "(clear peg2)", "(clear peg3)"]
    return problem("hanoi", " ".join([*pegs, *discs]), " ".join(init), " ".join(goal))


def logistics(n: int, seed: int) -> str:
    """n packages among two cities of two places each."""
    drawn = random.Random(f"logistics {n} {seed}")
    places = ["ap1", "pos1", "ap2", "pos2"]
    packages = [f"p{k}" for k in range(n)]
    objects = f"{' '.join(packages)} - package t1 t2 - truck plane - airplane "
    objects += "ap1 ap2 - airport pos1 pos2 - location c1 c2 - city"
    init = (
        "(in-city ap1 c1) (in-city pos1 c1) (in-city ap2 c2) (in-city pos2 c2) (at t1 pos1) (at t2 ap2) (at plane ap2) "
    )
    ways = [drawn.sample(places, 2) for _ in packages]
    init += " ".join(f"(at {p} {a})" for p, (a, _) in zip(packages, ways, strict=True))
    return problem(
        "logistics", objects, init, " ".join(f"(at {p} {b})" for p, (_, b) in zip(packages, ways, strict=True))
    )


def ferry(n: int, seed: int) -> str:
    """n cars between three ports."""
    drawn = random.Random(f"ferry {n} {seed}")
    cars = [f"c{k}" for k in range(n)]
    ways = [drawn.sample(["l1", "l2", "l3"], 2) for _ in cars]
    init = " ".join(f"(car-at {c} {a})" for c, (a, _) in zip(cars, ways, strict=True)) + " (ferry-at l1)"
    goal = " ".join(f"(car-at {c} {b})" for c, (_, b) in zip(cars, ways, strict=True))
    return problem("ferry", f"{' '.join(cars)} - car l1 l2 l3 - port", init, goal)


def lift(n: int, seed: int) -> str:
    """n passengers in a house of n + 2 floors."""
    drawn = random.Random(f"lift {n} {seed}")
    floors, people = [f"f{k}" for k in range(n + 2)], [f"p{k}" for k in range(n)]
    init = [f"(above {floors[i]} {floors[j]})" for j in range(n + 2) for i in range(j)] + ["(lift-at f0)"]
    for person in people:
        a, b = drawn.sample(floors, 2)
        init += [f"(origin {person} {a})", f"(target {person} {b})"]
    goal = "(forall (?p - passenger) (served ?p))"
    return problem("lift", f"{' '.join(people)} - passenger {' '.join(floors)} - floor", " ".join(init), goal)


def satellite(n: int, seed: int) -> str:
    """n images by two satellites."""
    drawn = random.Random(f"satellite {n} {seed}")
    stars = [f"star{k}" for k in range(n + 2)]
    init = "(on-board i1 s1) (on-board i2 s2) (supports i1 colour) (supports i2 colour) (supports i2 heat) "
    init += (
        f"(target-of i1 {drawn.choice(stars)}) (target-of i2 {drawn.choice(stars)}) (power-avail s1) (power-avail s2) "
    )
    init += f"(pointing s1 {drawn.choice(stars)}) (pointing s2 {drawn.choice(stars)})"
    goal = " ".join(f"(have-image {star} {drawn.choice(['colour', 'heat'])})" for star in drawn.sample(stars, n))
    objects = f"s1 s2 - satellite i1 i2 - instrument {' '.join(stars)} - direction colour heat - mode"
    return problem("satellite", objects, init, goal)


def transport(n: int, seed: int) -> str:
    """n parcels by one van on a ring of towns with a short cut; the metric is the way."""
    drawn = random.Random(f"transport {n} {seed}")
    towns = [f"t{k}" for k in range(n + 3)]
    ring = [*zip(towns, [*towns[1:], towns[0]], strict=True), (towns[0], towns[2])]
    init = ["(= (total-cost) 0)", "(at v1 t0)", "(empty v1)", "(at v2 t1)", "(empty v2)"]
    for a, b in ring:
        length = drawn.randint(1, 9)
        init += [f"(road {x} {y}) (= (road-length {x} {y}) {length})" for x, y in ((a, b), (b, a))]
    parcels = [f"p{k}" for k in range(n)]
    ways = [drawn.sample(towns, 2) for _ in parcels]
    init += [f"(at {p} {a})" for p, (a, _) in zip(parcels, ways, strict=True)]
    goal = " ".join(f"(at {p} {b})" for p, (_, b) in zip(parcels, ways, strict=True))
    objects = f"{' '.join(parcels)} - parcel v1 v2 - van {' '.join(towns)} - town"
    return problem("transport", objects, " ".join(init), goal, " (:metric minimize (total-cost))")


def briefcase(n: int, seed: int) -> str:
    """n papers to the office and one away from it."""
    drawn = random.Random(f"briefcase {n} {seed}")
    papers = [f"p{k}" for k in range(n + 1)]
    places = ["home", "library"]
    init = " ".join(f"(at {p} {drawn.choice(places)})" for p in papers[:n]) + f" (at {papers[n]} office) (case-at home)"
    goal = " ".join(f"(at {p} office)" for p in papers[:n]) + f" (not (at {papers[n]} office)) (not (locked))"
    return problem("briefcase", f"{' '.join(papers)} - paper home library - place", init, goal)


def visit(n: int, seed: int) -> str:
    """All cells of a grid of 3 times n."""
    cells = [(i, j) for i in range(3) for j in range(n)]
    near = [(a, b) for a in cells for b in cells if abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1]
    init = " ".join(f"(next c{a[0]}-{a[1]} c{b[0]}-{b[1]})" for a, b in near) + " (robot c0-0) (visited c0-0)"
    names = " ".join(f"c{i}-{j}" for i, j in cells)
    return problem("visit-all", f"{names} - cell", init, " ".join(f"(visited c{i}-{j})" for i, j in cells))


def lights(n: int, seed: int) -> str:
    """A row of n lamps, each of which switches its neighbours, too."""
    drawn = random.Random(f"lights {n} {seed}")
    lamps = [f"l{k}" for k in range(n)]
    init = [f"(near {a} {b}) (near {b} {a})" for a, b in pairwise(lamps)]
    lit = set(lamps)
    for press in drawn.sample(range(n), max(1, n // 2)):
        lit ^= {lamps[k] for k in (press - 1, press, press + 1) if 0 <= k < n}
    init += [f"(lit {lamp})" for lamp in sorted(lit)]
    return problem("lights", f"{' '.join(lamps)} - lamp", " ".join(init), " ".join(f"(lit {lamp})" for lamp in lamps))


def puzzle(n: int, seed: int) -> str:
    """Tiles of 2 times 3 that were slid at random n times."""
    drawn = random.Random(f"puzzle {n} {seed}")
    cells = [(i, j) for i in range(2) for j in range(3)]
    near = {a: [b for b in cells if abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1] for a in cells}
    held: dict[tuple[int, int], str] = {cell: f"tile{k}" for k, cell in enumerate(cells[1:], 1)}
    empty = cells[0]
    for _ in range(n):
        other = drawn.choice(near[empty])
        held[empty] = held.pop(other)
        empty = other
    init = [f"(neighbours c{a[0]}{a[1]} c{b[0]}{b[1]})" for a in cells for b in near[a]]
    init += [f"(at {tile} c{c[0]}{c[1]})" for c, tile in held.items()] + [f"(empty c{empty[0]}{empty[1]})"]
    goal = " ".join(f"(at tile{k} c{c[0]}{c[1]})" for k, c in enumerate(cells[1:], 1))
    objects = f"{' '.join(f'tile{k}' for k in range(1, 6))} - tile {' '.join(f'c{i}{j}' for i, j in cells)} - position"
    return problem("puzzle", objects, " ".join(init), goal)


def workshop(n: int, seed: int) -> str:
    """A frame with n painted wheels; the metric is the cost."""
    wheels = [f"w{k}" for k in range(n)]
    stations = [f"s{k}" for k in range(n + 2)]
    init = ["(= (total-cost) 0)", "(here s0)", f"(at f {stations[n]})", f"(paint-shop {stations[n + 1]})"]
    init += [f"(at {w} s{k}) (= (paint-cost {w}) {2 + k * seed})" for k, w in enumerate(wheels)]
    init.append("(= (paint-cost f) 4)")
    goal = "(ready f) " + " ".join(f"(mounted {w} f)" for w in wheels)
    objects = f"{' '.join(wheels)} - wheel f - frame {' '.join(stations)} - station"
    return problem("workshop", objects, " ".join(init), goal, " (:metric minimize (total-cost))")


DOMAINS: dict[str, tuple[str, Callable[[int, int], str], tuple[int, ...]]] = {
    "blocks": (BLOCKS, blocks, (3, 4, 5, 6, 7)),
    "gripper": (GRIPPER, gripper, (1, 2, 3, 4, 5)),
    "hanoi": (HANOI, hanoi, (1, 2, 3, 4, 5)),
    "logistics": (LOGISTICS, logistics, (1, 2, 3, 4, 5)),
    "ferry": (FERRY, ferry, (1, 2, 3, 4, 5)),
    "lift": (LIFT, lift, (1, 2, 3, 4, 5)),
    "satellite": (SATELLITE, satellite, (1, 2, 3, 4, 5)),
    "transport": (TRANSPORT, transport, (1, 2, 3)),
    "briefcase": (BRIEFCASE, briefcase, (1, 2, 3, 4, 5)),
    "visit-all": (VISIT, visit, (1, 2, 3, 4, 5)),
    "lights": (LIGHTS, lights, (2, 3, 4, 5, 6)),
    "puzzle": (PUZZLE, puzzle, (2, 6, 10, 20, 40)),
    "workshop": (WORKSHOP, workshop, (1, 2, 3)),
}
"""By name: the domain, what makes its problems, and the sizes that are tried."""


def instances() -> Iterator[tuple[str, str, str]]:
    """Name, domain and problem of all that is tried."""
    for name, (domain, make, sizes) in DOMAINS.items():
        for size in sizes:
            yield f"{name}-{size}", domain, make(size, 1)
