"""Every class of mistake: its line, what is wrong and what is allowed; all mistakes of a file at once."""

import pytest

from sigmafmu.mechanism_file.report import report

from .helpers import BALL, HEAD, complaint, complaints, read

JOINT = HEAD + f"bodies:\n  a: {BALL}\n  b: {BALL}\njoints:\n"
TWO = "".join(
    f"  {name}: {{type: revolute, bodies: [ground, {body}], point: [0, 0, 0], axis: [0, 0, 1]}}\n"
    for name, body in (("j", "a"), ("k", "b"))
)
PIN = "type: revolute, bodies: [ground, a], point: [0, 0, 0], axis: [0, 0, 1]"


def body(text: str) -> str:
    return HEAD + f"bodies:\n  a: {text}\n"


@pytest.mark.parametrize(
    ("text", "line", "where", "what"),
    [
        # the file
        ("name: A\nbodies: {a: " + BALL + "}", 1, "", "sigmafmu is missing"),
        ("- 1", 1, "", "is a list; it must be a mapping"),
        ("sigmafmu: 2\nname: A\nbodies: {a: " + BALL + "}", 1, "sigmafmu", "is 2; this version reads 1"),
        ("sigmafmu: 1\nname: 9x\nbodies: {a: " + BALL + "}", 2, "name", "no digit first"),
        ("sigmafmu: 1\nname: 9\nbodies: {a: " + BALL + "}", 2, "name", "is a number; it must be a text"),
        (HEAD, 1, "", "bodies is missing"),
        (HEAD + "bodies: {}\n", 1, "", "no bodies; it must have at least one"),
        (HEAD + "gravty: [0, 0, 0]\nbodies: {a: " + BALL + "}", 3, "gravty", "did you mean gravity?"),
        (HEAD + "gravity: [0, 0]\nbodies: {a: " + BALL + "}", 3, "gravity", "has 2 entries; it must be a list of 3"),
        (HEAD + "gravity: 9.81\nbodies: {a: " + BALL + "}", 3, "gravity", "is a number; it must be a list of 3"),
        # bodies
        (body("{mas: 1, mass: 1, inertia: [1, 1, 1]}"), 4, "bodies.a.mas", "did you mean mass?"),
        (body("{inertia: [1, 1, 1]}"), 4, "bodies.a", "mass is missing"),
        (body("{mass: 1}"), 4, "bodies.a", "inertia is missing"),
        (body("{mass: 0, inertia: [1, 1, 1]}"), 4, "bodies.a.mass", "is 0 kg; it must be above 0"),
        (body('{mass: "2 m", inertia: [1, 1, 1]}'), 4, "bodies.a.mass", '"2 m" is a length'),
        (body("{mass: heavy, inertia: [1, 1, 1]}"), 4, "bodies.a.mass", "no number with a unit"),
        (body("{mass: true, inertia: [1, 1, 1]}"), 4, "bodies.a.mass", "is a truth value"),
        (body("{mass: .nan, inertia: [1, 1, 1]}"), 4, "bodies.a.mass", "is nan; it must be finite"),
        (body("{mass: 1, inertia: [1, .inf, 1]}"), 4, "bodies.a.inertia[2]", "it must be finite"),
        (body("{mass: 1e999, inertia: [1, 1, 1]}"), 4, "bodies.a.mass", "it must be finite"),
        (body("{mass: 1e60, inertia: [1, 1, 1]}"), 4, "bodies.a.mass", "it must be at most 1e+50 in size"),
        (body("{mass: 1, inertia: [1, -1, 1]}"), 4, "bodies.a.inertia[2]", "is -1 kg m²; it must be at least 0"),
        (body("{mass: 1, inertia: [1, 2, 4]}"), 4, "bodies.a.inertia", "triangle inequality"),
        (body("{mass: 1, inertia: {xx: 1, yy: 1, zz: 1, xy: 2}}"), 4, "bodies.a.inertia", "all must be positive"),
        (body("{mass: 1, inertia: {xx: 1, yy: 1}}"), 4, "bodies.a.inertia", "zz is missing"),
        (
            body("{mass: 1, inertia: [1, 1, 1], orientation: {quaternion: [0, 0, 0, 0]}}"),
            4,
            "bodies.a.orientation.quaternion",
            "its length must be at least 1e-6",
        ),
        (
            body("{mass: 1, inertia: [1, 1, 1], orientation: {rpy: [0, 0, 0], rotation_vector: [0, 0, 0]}}"),
            4,
            "bodies.a.orientation",
            "has rotation_vector and rpy; it must have one of",
        ),
        (body("{mass: 1, flexible: x.json}"), 4, "bodies.a.mass", "comes from the modal data"),
        (body("{flexible: x.json}"), 4, "bodies.a.flexible", '"x.json" cannot be read: No such file'),
        (body("{mass: 1, inertia: [1, 1, 1], shapes: [{}]}"), 4, "bodies.a.shapes[1]", "it must have one of box"),
        (
            body("{mass: 1, inertia: [1, 1, 1], shapes: [{sphere: 1, color: red}]}"),
            4,
            "bodies.a.shapes[1].color",
            'it must be like "#4477aa"',
        ),
        (HEAD + f"bodies:\n  ground: {BALL}\n", 4, "bodies.ground", "ground is the inertial frame"),
        (HEAD + f"bodies:\n  a b: {BALL}\n", 4, "bodies.a b", "allowed are letters, digits and _"),
        (HEAD + f"bodies:\n  energy: {BALL}\n", 4, "bodies.energy", "reserved for what every mechanism has"),
        # joints
        (JOINT + "  j: {bodies: [a, b]}", 7, "joints.j", "type is missing; allowed are spherical"),
        (JOINT + "  j: {type: revolut}", 7, "joints.j.type", "did you mean revolute?"),
        (JOINT + "  j: {type: 3}", 7, "joints.j.type", "is a number; allowed are"),
        (
            JOINT + "  j: {type: spherical, bodies: [a, c], point: [0, 0, 0]}",
            7,
            "joints.j.bodies[2]",
            'body or ground "c"',
        ),
        (JOINT + "  j: {type: spherical, bodies: [a, a], point: [0, 0, 0]}", 7, "joints.j.bodies", "they must differ"),
        (
            JOINT + "  j: {type: spherical, bodies: [a], point: [0, 0, 0]}",
            7,
            "joints.j.bodies",
            "it must be a list of 2",
        ),
        (JOINT + "  j: {type: spherical, bodies: [a, b]}", 7, "joints.j", "point is missing; give point, or frame1"),
        (
            JOINT + "  j:\n    type: revolute\n    bodies: [a, b]\n    point: [0, 0, 0]\n    axis: [0, 0, 0]\n",
            11,
            "joints.j.axis",
            "an axis must have a length above 0",
        ),
        (
            JOINT + "  j: {type: universal, bodies: [a, b], point: [0, 0, 0], axis1: [1, 0, 0], axis2: [1, 1, 0]}",
            7,
            "joints.j.axis2",
            "is at 45 degrees to axis1; it must be perpendicular",
        ),
        (
            JOINT + "  j: {type: spherical, bodies: [a, b], point: [0, 0, 0], frame1: {}}",
            7,
            "joints.j.point",
            "give it or frame1 and frame2, not both",
        ),
        (JOINT + "  j: {" + PIN + ", coordinate: 30 mm}", 7, "joints.j.coordinate", "is a length"),
        (JOINT + "  j: {" + PIN + ", rate: 50 Hz}", 7, "joints.j.rate", "unknown"),
        (JOINT + "  j: {" + PIN + ", stiffness: -1}", 7, "joints.j.stiffness", "it must be at least 0"),
        (JOINT + "  j: {" + PIN + ", displacement: 1}", 7, "joints.j.displacement", "this key is unknown"),
        (JOINT + "  a: {" + PIN + "}", 7, "joints.a", "a is in bodies too, in line 4"),
        (
            JOINT + "  j: {type: spherical, bodies: [ground, a], frame2: {node: 3}}",
            7,
            "joints.j",
            "which is not flexible",
        ),
        # what acts, and settings
        (JOINT + "forces:\n  f: {type: spring}", 8, "forces.f.type", "did you mean line_spring?"),
        (
            JOINT + "forces:\n  f: {type: spring_damper, bodies: [a, b], stiffness: [1, 1]}",
            8,
            "forces.f.stiffness",
            "it must be a list of 3",
        ),
        (JOINT + "loads:\n  l: {body: ground, force: [0, 0, 1]}", 8, "loads.l.body", 'there is no body "ground"'),
        (JOINT + "drives:\n  k: {motion: rate, value: 1}", 8, "drives.k", 'there is no coordinate "k"'),
        (
            JOINT + "  j: {" + PIN + "}\ndrives:\n  j: {motion: rate, value: 1 m/s}",
            9,
            "drives.j.value",
            "is a velocity",
        ),
        (
            JOINT + "  j: {" + PIN + "}\ndrives:\n  j: {motion: speed, value: 1}",
            9,
            "drives.j.motion",
            "allowed are position",
        ),
        (
            JOINT + f"{TWO}couplings:\n  c: {{type: gear, joints: [j], ratio: 2}}",
            10,
            "couplings.c.joints",
            "a list of 2",
        ),
        (JOINT + f"{TWO}couplings:\n  c: {{type: gear, joints: [j, k]}}", 10, "couplings.c", "ratio is missing"),
        (
            JOINT + f"{TWO}couplings:\n  c: {{type: gear, joints: [j, j], ratio: 1}}",
            10,
            "couplings.c.joints",
            "has j twice; coordinates must differ",
        ),
        (
            JOINT + f"{TWO}couplings:\n  c: {{type: sum, joints: [j, k], polynomials: [[0, 1]]}}",
            10,
            "couplings.c.polynomials",
            "it must have one for each of the 2 joints",
        ),
        (
            JOINT + f"{TWO}tendons:\n  t: {{joints: [j, k], coefficients: [1]}}",
            10,
            "tendons.t.coefficients",
            "it must have one for each of the 2 joints",
        ),
        (
            JOINT + f"{TWO}tendons:\n  t: {{joints: [j, j], coefficients: [1, 2]}}",
            10,
            "tendons.t.joints",
            "has j twice; coordinates must differ",
        ),
        (
            JOINT + f"{TWO}tendons:\n  t: {{joints: [j, k], coefficients: [1, 0]}}",
            10,
            "tendons.t.coefficients",
            "coefficients must not be 0",
        ),
        (
            JOINT + f"{TWO}drives:\n  j: {{motion: rate, table: [[0, 1], [1 s, 60 rpm], [0.5, 2]]}}",
            10,
            "drives.j.table[3]",
            "comes at 0.5 after 1; points must ascend",
        ),
        (JOINT + f"{TWO}drives:\n  j: {{motion: rate, table: [[0, 1]]}}", 10, "drives.j.table", "at least two points"),
        (JOINT + f"{TWO}drives:\n  j: {{motion: rate}}", 10, "drives.j", "it must have one of value, table"),
        (
            JOINT + f"{TWO}motions:\n  m: {{input: true, x: [[0, 0], [1, 1]]}}",
            10,
            "motions.m.x",
            "it must be one",
        ),
        (
            JOINT + "  j: {type: spherical, bodies: [ground, a], frame2: {motion: m}}\nmotions:\n  m: {}",
            7,
            "joints.j.frame2.motion",
            "is a moving frame of the ground",
        ),
        (JOINT + "experiment: {stop_time: 0}", 7, "experiment.stop_time", "it must be above 0"),
        (JOINT + "experiment: {stop: 1}", 7, "experiment.stop", "allowed are stop_time, step_size"),
        (JOINT + "integrator: {formulatin: index3}", 7, "integrator.formulatin", "did you mean formulation?"),
        (JOINT + "integrator: {formulation: index4}", 7, "integrator.formulation", "index4"),
        (JOINT + "integrator: {spectralRadius: 2}", 7, "integrator.spectralRadius", "at most 1"),
        (JOINT + "expose: some", 7, "expose", "allowed are auto, all"),
        (JOINT + "stations:\n  s: {body: a, nodes: [0]}", 8, "stations.s", "it must be one of a flexible body"),
        # assembly
        (
            HEAD + f"bodies:\n  a: {BALL}\njoints:\n"
            "  j: {type: spherical, bodies: [ground, a], frame1: {}}\n"
            "  k: {type: spherical, bodies: [ground, a], frame1: {position: [9, 0, 0]}, frame2: {position: [1, 0, 0]}}",
            6,
            "joints.j",
            "cannot be assembled",
        ),
    ],
)
def test_a_mistake_has_its_line_and_what_is_allowed(text, line, where, what):
    message = complaint(text)
    assert message.startswith(f"some.yaml:{line}: {where + ': ' if where else ''}"), message
    assert what in message, message


def test_all_mistakes_of_a_file_come_at_once():
    found = complaints(
        HEAD + "gravity: [0, 0, 9.81 kg]\n"
        "bodies:\n  a: {mas: 1, inertia: [1, 2, 9]}\n  b: {mass: -1, inertia: [1, 2]}\n"
        "joints:\n  a: {type: ball}\n  j: {type: spherical, bodies: [c, d], point: [0, 0]}\n"
        "forces: 3\n"
    )
    assert [int(line.split(":")[1]) for line in found] == [3, 5, 6, 6, 8, 8, 9, 9, 9, 10]


def test_joints_that_cannot_close_are_named_with_their_gap():
    bar = "{mass: 1, inertia: [1, 1, 1], center_of_mass: [0.5, 0, 0]}"
    message = complaint(
        HEAD + f"bodies:\n  a: {bar}\n  b: {bar}\njoints:\n"
        "  first: {type: revolute, bodies: [ground, a], frame1: {}}\n"
        "  second: {type: revolute, bodies: [a, b], frame1: {position: [1, 0, 0]}}\n"
        "  third: {type: revolute, bodies: [b, ground], frame1: {position: [1, 0, 0]}, frame2: {position: [3, 0, 0]}}\n"
    )
    assert all(name in message for name in ("first", "second", "third"))
    assert " m" in message


def test_joints_that_follow_themselves_are_refused_with_the_way_round():
    pins = "".join(
        f"  {name}: {{type: revolute, bodies: [ground, {name}x], point: [0, 0, 0], axis: [0, 0, 1]}}\n"
        for name in "jkl"
    )
    found = complaints(
        HEAD + "bodies:\n" + "".join(f"  {name}x: {BALL}\n" for name in "jkl") + "joints:\n" + pins + "couplings:\n"
        "  one: {type: mimic, joints: [j, k], polynomial: [0, 1]}\n"
        "  two: {type: mimic, joints: [k, l], polynomial: [0, 1]}\n"
        "  three: {type: mimic, joints: [l, j], polynomial: [0, 1]}\n"
    )
    assert [line.split(": ", 1)[0] for line in found] == ["some.yaml:12", "some.yaml:13", "some.yaml:14"]
    assert "couplings.one: j follows k follows l follows j; a joint must not follow itself" in found[0]


def test_equations_of_drives_and_couplings_that_say_the_same_are_named():
    """Both joints are driven, and a gear between them says so once more."""
    text = JOINT + TWO + "drives:\n  j: {motion: rate, value: 1}\n  k: {motion: rate, value: 2}\n"
    lines = list(report(read(text + "couplings:\n  c: {type: gear, joints: [j, k], ratio: 2}\n")))
    assert lines[0] == "Some: 2 bodies, 2 joints, 1 coupling, 2 drives"
    redundant = next(line for line in lines if line.startswith("redundant"))
    assert all(name in redundant for name in ("the drive of j", "the drive of k", " c "))


def test_equations_of_drives_that_say_the_same_are_named():
    """Two hinges about one axis between the same bodies, both driven."""
    pin = "{type: revolute, bodies: [ground, a], point: [0, 0, %s], axis: [0, 0, 1]}\n"
    text = HEAD + f"bodies:\n  a: {BALL}\njoints:\n  j: {pin % 0}  k: {pin % 1}"
    lines = list(report(read(text + "drives:\n  j: {motion: rate, value: 1}\n  k: {motion: rate, value: 1}\n")))
    assert "redundant: 1 of the 2 equations of the drive of j, the drive of k follow from the others" in lines


def test_a_body_that_nothing_holds_is_information():
    lines = list(report(read(HEAD + f"gravity: [0, 0, 0]\nbodies: {{a: {BALL}}}")))
    assert lines[-1] == "information: nothing holds a, which moves on freely"
