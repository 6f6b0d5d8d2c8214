"""Generators of masonry: volumes, no overlaps, stability."""
import math
import unittest
from collections import Counter

import numpy as np
import quoin
from support import Folder

MASONRY = dict(material="stone")


def volume_of(block):
    """Returns the volume of a box, or of the hull of its vertices as pyramids from the centre to its faces."""
    if "box" in block:
        return math.prod(block.box.size)
    points = np.array(block.vertices)
    centre, total = points.mean(axis=0), 0.0
    for face in hull_faces(points):
        for a, b in zip(face[1:], face[2:]):
            total += abs(np.dot(face[0] - centre, np.cross(a - face[0], b - face[0]))) / 6
    return total


def hull_faces(points):
    """Returns the faces of the hull of a few points: planes through three points with all others on one side."""
    faces, seen = [], set()
    for i in range(len(points)):
        for j in range(i + 1, len(points)):
            for k in range(j + 1, len(points)):
                normal = np.cross(points[j] - points[i], points[k] - points[i])
                size = np.linalg.norm(normal)
                if size < 1e-12:
                    continue
                distance = (points - points[i]) @ (normal / size)
                if distance.max() > 1e-9 and distance.min() < -1e-9:
                    continue
                on = np.flatnonzero(np.abs(distance) <= 1e-9)
                if tuple(on) in seen:
                    continue
                seen.add(tuple(on))
                middle = points[on].mean(axis=0)
                e1 = points[on[0]] - middle
                e2 = np.cross(normal / size, e1)
                order = np.argsort(np.arctan2((points[on] - middle) @ e2, (points[on] - middle) @ e1))
                faces.append(points[on][order])
    return faces


def scene_of(blocks, **stage):
    scene = quoin.Scene(title="generated")
    scene.solver = dict(damping="local", local_damping=0.8)
    scene.materials.stone = quoin.BlockMaterial(density=2000.0, young_modulus=1e10, poisson_ratio=0.2)
    scene.joints.dry = quoin.Joint(law="coulomb_slip", initial_state="dry", normal_stiffness=1e10, shear_stiffness=1e10,
                                   friction_angle=35.0)
    scene.block = blocks
    scene.stage.append(quoin.Stage(**{"gravity": [0, -9.81, 0], "ramp_time": 0.05, "duration": 0.3, **stage}))
    scene.output = dict(frames=0)
    return scene


class Shapes(Folder):
    def assert_fills(self, blocks, volume):
        self.assertAlmostEqual(sum(map(volume_of, blocks)), volume, delta=1e-9 * volume)
        self.assertEqual(len({b.name for b in blocks}), len(blocks))

    def assert_stands(self, blocks, sag):
        """Under weight no block moves by more than `sag`, m. Overlapping blocks are refused when the model is built."""
        sim = quoin.Simulation(scene_of(blocks))
        sim.run()
        history = sim.history
        self.assertLess(history["largest_displacement_m"].max(), sag)
        self.assertGreater(history["largest_displacement_m"].max(), 1e-8)  # weight acts

    def test_bonds_fill_their_wall(self):
        # Length 1.1 m, 4 courses of 0.0625 m, thickness 0.22 m (a unit's length) or 0.11 m (its width).
        for bond in quoin.shapes.BONDS:
            with self.subTest(bond):
                blocks = quoin.shapes.wall(bond, 4, 1.1, [0.22, 0.0625, 0.11], **MASONRY)
                thickness = 0.11 if bond in ("running", "third", "stack") else 0.22
                self.assert_fills(blocks, 1.1 * 4 * 0.0625 * thickness)

    def test_bonds_bond(self):
        # No head joint is above another one in the course below, except in stack bond and at the ends.
        def joints(blocks, course):
            return {round(b.box.lower[0], 6) for b in blocks if b.name.startswith(f"wall/{course}/")} - {0.0}
        for bond in quoin.shapes.BONDS:
            blocks = quoin.shapes.wall(bond, 4, 2.2, [0.22, 0.0625, 0.11], **MASONRY)
            for course in range(3):
                common = joints(blocks, course) & joints(blocks, course + 1)
                self.assertEqual(bool(common), bond == "stack", (bond, course, common))

    def test_a_wall_of_english_bond_stands(self):
        base = [quoin.Block(name="base", material="stone", fixed=True, box=dict(lower=[-0.1, -0.1, -0.1], size=[0.9, 0.1, 0.5]))]
        self.assert_stands(base + quoin.shapes.wall("english", 5, 0.66, [0.22, 0.0625, 0.11], **MASONRY), 1e-4)

    def test_vaults_fill_their_rings(self):
        # Area of a sector with straight chords: (ro2 - ri2) / 2 sin(step).
        step = math.pi / 12
        free = [b for b in quoin.shapes.barrel_vault(2.0, 0.3, 3.0, 12, 3, **MASONRY) if not b.keys() & {"fixed"}]
        self.assert_fills(free, 12 * (2.15**2 - 1.85**2) / 2 * math.sin(step) * 3.0)
        curved = quoin.shapes.curved_wall(3.0, 0.4, 2.0, 4, 24, **MASONRY)
        self.assert_fills(curved, 24 * (3.2**2 - 2.8**2) / 2 * math.sin(math.radians(15)) * 2.0)

    def test_a_barrel_vault_stands(self):
        self.assert_stands(quoin.shapes.barrel_vault(2.0, 0.4, 2.0, 9, 2, **MASONRY), 1e-3)

    def test_a_dome_stands(self):
        blocks = quoin.shapes.dome(3.0, 0.4, 4, 12, oculus=70.0, **MASONRY)
        self.assertEqual(len(blocks), 5 * 12)
        self.assert_stands(blocks, 1e-3)
        closed = quoin.shapes.dome(3.0, 0.4, 4, 12, oculus=90.0, **MASONRY)
        self.assertEqual(len(closed), 5 * 12 + 1)
        self.assert_stands(closed, 1e-3)

    def test_a_bridge_stands(self):
        blocks = quoin.shapes.arch_bridge(2, 3.0, 0.9, 0.35, 1.0, 9, 0.9, 1.0, **MASONRY)
        self.assertEqual(sum(b.name.startswith("bridge/arch_") for b in blocks), 18)
        self.assert_stands(blocks, 1e-3)

    def test_a_bridge_of_semicircles_has_no_skewbacks(self):
        blocks = quoin.shapes.arch_bridge(2, 2.0, 1.0, 0.35, 1.0, 9, 0.9, 1.0, **MASONRY)
        self.assertFalse([b.name for b in blocks if "skewback" in b.name])
        self.assert_stands(blocks, 1e-3)

    def ground(self, lower, size):
        return [quoin.Block(name="ground", material="stone", fixed=True, box=dict(lower=lower, size=size))]

    def test_a_two_leaf_wall_is_tied(self):
        unit, gap = [0.22, 0.065, 0.105], 0.05
        blocks = quoin.shapes.two_leaf_wall(6, 1.32, unit, gap=gap, tie_every=3, tie_spacing=2, **MASONRY)
        headers = [b for b in blocks if b.box.size[2] > 0.2]
        # Two courses with ties: every second of six units, and of five units with a half at each end.
        self.assertEqual(len(headers), 6)
        self.assert_fills(blocks, 1.32 * 6 * 0.065 * 2 * 0.105 + 6 * 0.105 * 0.065 * gap)
        self.assert_stands(self.ground([-0.1, -0.1, -0.1], [1.6, 0.1, 0.5]) + blocks, 1e-4)
        closed = quoin.shapes.two_leaf_wall(6, 1.32, unit, **MASONRY)
        self.assert_fills(closed, 1.32 * 6 * 0.065 * 2 * 0.105)

    def test_rubble_fills_its_box_and_stands(self):
        if not hasattr(quoin._quoin, "voronoi"):
            self.skipTest("the package is built without Voro++ (voro++-dev)")
        size, stone = [1.5, 1.0, 0.4], [0.3, 0.2, 0.25]
        blocks = quoin.shapes.rubble(size, stone, seed=3, **MASONRY)
        self.assertEqual(len(blocks), 40)
        self.assert_fills(blocks, 0.6)
        volumes = np.array([volume_of(b) for b in blocks])
        self.assertGreater(volumes.std() / volumes.mean(), 0.1)  # irregular
        self.assertEqual(quoin.shapes.rubble(size, stone, seed=3, **MASONRY), blocks)
        self.assertNotEqual(quoin.shapes.rubble(size, stone, seed=4, **MASONRY), blocks)
        even = [volume_of(b) for b in quoin.shapes.rubble(size, stone, seed=3, relax=30, **MASONRY)]
        self.assertLess(np.std(even), 0.6 * volumes.std())
        self.assert_stands(self.ground([-0.2, -0.1, -0.2], [1.9, 0.1, 0.8]) + blocks, 1e-3)
        for seed in (4, 10, 21):  # thin splinters are accepted, too (of seeds 1 to 29 all but 22)
            wild = quoin.shapes.rubble(size, stone, seed=seed, relax=0, **MASONRY)
            self.assertEqual(quoin.Simulation(scene_of(wild)).blocks, 40)

    def test_stones_have_no_short_edges_and_share_their_faces(self):
        if not hasattr(quoin._quoin, "voronoi"):
            self.skipTest("the package is built without Voro++ (voro++-dev)")
        size, stone = np.array([1.0, 0.6, 0.4]), np.array([0.2, 0.12, 0.2])
        for seed, relax in ((1, 3), (2, 0), (3, 10)):
            with self.subTest(seed=seed, relax=relax):
                edges = {}
                for shortest in (0.0, 0.15):
                    blocks = quoin.shapes.rubble(size, stone, seed=seed, relax=relax, shortest_edge=shortest, **MASONRY)
                    self.assert_fills(blocks, np.prod(size))
                    faces = [face for b in blocks for face in hull_faces(np.array(b.vertices))]
                    edges[shortest] = min(np.linalg.norm((face - np.roll(face, 1, axis=0)) / stone, axis=1).min()
                                          for face in faces)
                self.assertLess(edges[0.0], 0.03)  # there are short edges without merging
                self.assertGreaterEqual(edges[0.15], 0.15)
                corners = Counter(frozenset(map(tuple, np.round(face, 7) + 0.0)) for face in faces)
                for face, times in corners.items():
                    points = np.array(list(face))
                    is_side = any((points[:, k] == at).all() for k in range(3) for at in (0.0, size[k]))
                    self.assertEqual(times, 1 if is_side else 2)
                self.assertEqual(quoin.Simulation(scene_of(blocks)).blocks, len(blocks))

    def test_deformable_rubble_has_the_time_step_of_its_stones(self):
        if not hasattr(quoin._quoin, "voronoi"):
            self.skipTest("the package is built without Voro++ (voro++-dev)")
        steps = {}
        for shortest in (0.0, 0.15):
            blocks = quoin.shapes.rubble([1.0, 0.6, 0.4], [0.2, 0.12, 0.2], seed=1, relax=3, shortest_edge=shortest, rigid=False,
                                         zone_edge=0.15, **MASONRY)
            sim = quoin.Simulation(scene_of(blocks))
            steps[shortest] = sim.time_step
        # A wave of sqrt(E/rho) = 2236 m/s needs 8e-6 s for an edge of 0.15 * 0.12 m; heights of zones are smaller.
        self.assertGreater(steps[0.15], 10 * steps[0.0])
        self.assertGreater(steps[0.15], 1.5e-6)

    def test_a_cross_vault_fills_its_webs_and_stands(self):
        span, thickness, courses = 4.0, 0.4, 11
        low, outer = math.radians(20.0), (span + thickness) / 2
        step = (math.pi - 2 * low) / courses
        blocks = quoin.shapes.cross_vault(span, thickness, courses, **MASONRY)
        self.assertEqual(len(blocks), 4 * (courses + 2))

        def web():  # volume: for each course, its section times the length from the groin, |x|, to the outer side
            for course in range(courses):
                a, b = low + course * step, low + (course + 1) * step
                section = [(r * math.cos(t), r * math.sin(t)) for r, t in
                           ((outer - thickness, a), (outer, a), (outer, b), (outer - thickness, b))]
                if course == courses // 2:  # half of the course, twice
                    section = [section[0], section[1], (0.0, section[1][1]), (0.0, section[0][1])]
                area = moment = 0.0
                for (x0, y0), (x1, y1) in zip(section, section[1:] + section[:1]):
                    area += (x0 * y1 - x1 * y0) / 2
                    moment += (x0 + x1) * (x0 * y1 - x1 * y0) / 6
                yield (2 if course == courses // 2 else 1) * (abs(area) * outer - abs(moment))
        self.assert_fills([b for b in blocks if "fixed" not in b], 4 * sum(web()))
        self.assert_stands(blocks, 1e-3)
        with self.assertRaisesRegex(ValueError, "courses = 8: allowed: an odd number"):
            quoin.shapes.cross_vault(span, thickness, 8, **MASONRY)

    def test_fill_loads_arches_with_its_weight(self):
        spans, span, rise, thickness, width, voussoirs = 2, 3.0, 0.9, 0.35, 1.0, 9
        blocks = quoin.shapes.arch_bridge(spans, span, rise, thickness, width, voussoirs, 0.9, 1.0, **MASONRY)
        top, weight = 1.0 + rise + thickness + 0.3, 18e3
        forces = quoin.shapes.fill_load(blocks, top, weight)
        # Exact area between the horizontal top and the extrados, a polygon with corners on a circle, over each arch, plus the
        # area over the middle of the pier, between the springings of the extrados.
        radius = (span**2 / 4 + rise**2) / (2 * rise)
        half, outer = math.asin(span / 2 / radius), radius + thickness
        under = voussoirs * outer**2 / 2 * math.sin(2 * half / voussoirs) - outer**2 / 2 * math.sin(2 * half)
        foot = 1.0 + thickness * math.cos(half)
        arch = (top - foot) * 2 * outer * math.sin(half) - under
        pier = (top - foot) * (0.9 - 2 * thickness * math.sin(half))
        self.assertAlmostEqual(-sum(f.force[1] for f in forces) / (weight * width * (2 * arch + pier)), 1.0, delta=1e-6)
        self.assertEqual({f.block for f in forces if "arch" not in f.block}, {"bridge/pier_0/skewback"})
        turning = sum(f.point[0] * f.force[1] for f in forces) / sum(f.force[1] for f in forces)
        self.assertAlmostEqual(turning, span + 0.45, delta=1e-6)  # symmetric

        def thrust(loaded):
            scene = scene_of(blocks, force=forces if loaded else [])
            sim = quoin.Simulation(scene)
            sim.run()
            self.assertLess(sim.history["largest_displacement_m"].max(), 1e-3)
            vertical = 0.0  # force on fixed blocks, N; the normal is from a to b
            contacts = sim.contacts("dry")
            traction = np.array([sim.sigma("dry"), sim.tau_s("dry"), sim.tau_t("dry")]) * np.array(sim.area("dry"))
            force = sum(traction[k][:, None] * contacts[axis] for k, axis in enumerate(("normal", "s", "t")))
            fixed = {i for i, b in enumerate(blocks) if "fixed" in b}
            for f, a, b in zip(force, contacts["block_a"], contacts["block_b"]):
                if (a in fixed) != (b in fixed):
                    vertical -= f[1] if a in fixed else -f[1]
            return vertical
        # The reactions grow by the weight of the fill. Tolerance 1 %, for remaining vibration.
        self.assertAlmostEqual((thrust(True) - thrust(False)) / (weight * width * (2 * arch + pier)), 1.0, delta=0.01)
        with self.assertRaisesRegex(quoin.BadInput, "reaches .* above it"):
            quoin.shapes.fill_load(blocks, 1.5, weight)

    def test_a_box_without_a_lower_corner_begins_at_the_origin(self):
        """As in scenes: the same parts, and the same load of a fill, as with lower = [0, 0, 0]."""
        boxes = [quoin.Block(name="wall", material="stone", box=box)
                 for box in (dict(size=[2, 1, 0.3]), dict(lower=[0, 0, 0], size=[2, 1, 0.3]))]
        without, given = ([b.box for b in quoin.shapes.opening([block], 0.5, 1.0, 0.2, 0.8)] for block in boxes)
        self.assertEqual(without, given)
        self.assertEqual(*(quoin.shapes.fill_load([block], 1.5, 20e3) for block in boxes))

    def test_a_lintel_carries_what_is_over_an_opening(self):
        wall = quoin.shapes.wall("running", 7, 2.2, [0.44, 0.2, 0.22], **MASONRY)
        blocks = quoin.shapes.opening(wall, 0.66, 1.54, 0.2, 0.8, bearing=0.22, lintel_height=0.2, lintel_material="stone")
        self.assert_fills(blocks, 2.2 * 1.4 * 0.22 - 0.88 * 0.6 * 0.22)
        lintel = blocks[-1]
        np.testing.assert_allclose(lintel.box.size, [1.32, 0.2, 0.22])
        self.assertFalse(lintel.rigid)
        stands = self.ground([-0.1, -0.1, -0.1], [2.4, 0.1, 0.42])
        self.assert_stands(stands + blocks, 1e-3)
        sim = quoin.Simulation(scene_of(stands + blocks))
        sim.run()
        contacts = sim.contacts("dry")
        number = len(stands + blocks) - 1
        below = (contacts["position"][:, 1] < 0.8 + 1e-6) & ((contacts["block_a"] == number) | (contacts["block_b"] == number))
        carried = -np.sum((np.array(sim.sigma("dry")) * np.array(sim.area("dry")))[below])
        own = 2000.0 * 9.81 * 1.32 * 0.2 * 0.22
        over = 2000.0 * 9.81 * 1.32 * 0.4 * 0.22  # weight of the column above it, N
        self.assertGreater(carried, own)
        self.assertLess(carried, own + 1.5 * over)
        without = quoin.shapes.opening(wall, 0.66, 1.54, 0.2, 0.8, **MASONRY)
        self.assert_fills(without, 2.2 * 1.4 * 0.22 - 0.88 * 0.6 * 0.22)

    def test_a_ring_beam_lies_on_its_walls(self):
        unit = [0.44, 0.2, 0.22]
        walls = [b for name, z in (("front", 0.0), ("back", 1.1))
                 for b in quoin.shapes.wall("running", 3, 1.76, unit, name=name, origin=[0, 0, z], **MASONRY)]
        ring = quoin.shapes.ring_beam([0, 0.6, 0], 1.76, 1.32, [0.2, 0.22], **MASONRY)
        self.assert_fills(ring, 0.2 * 0.22 * (2 * 1.76 + 2 * (1.32 - 0.44)))
        scene = scene_of(self.ground([-0.1, -0.1, -0.1], [2.0, 0.1, 1.6]) + walls + ring)
        scene.joints.cast = quoin.Joint(law="elastic", normal_stiffness=1e11, shear_stiffness=1e11)
        scene.default_joint = "dry"
        scene.joint_rule.append(quoin.JointRule(family="cast", between=["ring/", "ring/"]))
        sim = quoin.Simulation(scene)
        self.assertGreater(len(sim.area("cast")), 12)
        sim.run()  # the two transverse blocks are carried by the others
        self.assertLess(sim.history["largest_displacement_m"].max(), 1e-3)

    def test_a_tie_stretches_as_steel_does(self):
        walls = [b for name, z in (("front", 0.0), ("back", 1.5))
                 for b in quoin.shapes.wall("stack", 1, 0.5, [0.5, 0.5, 0.2], name=name, origin=[0, 0, z], **MASONRY)]
        blocks = quoin.shapes.tie(walls, [0.25, 0.25, 0.0], [0.25, 0.25, 1.7], 0.05, [0.2, 0.04], material="steel")
        hole = 0.2 * 0.07**2
        self.assert_fills(blocks, 2 * (0.5 * 0.5 * 0.2 - hole) + 1.7 * 0.05**2 + 2 * 0.2**2 * 0.04)
        parts = {b.unit for b in blocks if "unit" in b}
        self.assertEqual(parts, {"front/0/0", "back/0/0"})
        # One plate is fixed, the other has a force: F L / (E A) plus the two joints of the bar.
        tie = [b for b in blocks if b.name.startswith("tie/")]
        bar, held, pulled = tie
        for plate in (held, pulled):
            plate.rigid = True
            del plate["zone_edge"]
        held.fixed = True
        scene = scene_of(tie, gravity=[0.0, 0.0, 0.0], duration=0.08,
                         force=[dict(block=pulled.name, point=[0.25, 0.25, 1.72], force=[0.0, 0.0, 1e5])])
        scene.materials.steel = quoin.BlockMaterial(density=7800.0, young_modulus=200e9, poisson_ratio=0.0)
        scene.joints.dry = quoin.Joint(law="elastic", normal_stiffness=1e12, shear_stiffness=1e12)
        scene.output.monitor = pulled.name
        sim = quoin.Simulation(scene)
        sim.run()
        area = 0.05**2
        expected = 1e5 * (1.7 / (200e9 * area) + 2 / (1e12 * area))
        # The plates are rigid, the strain of the bar is uniform: exact but for remaining vibration.
        self.assertAlmostEqual(np.array(sim.displacement(2))[:, 2].mean() / expected, 1.0, delta=0.01)

    def test_cuts_are_told_where_nothing_is_cut(self):
        wall = quoin.shapes.wall("running", 2, 0.88, [0.44, 0.2, 0.22], **MASONRY)
        with self.assertRaisesRegex(ValueError, "nothing of the blocks lies in what is cut"):
            quoin.shapes.cut(wall, [5, 5, 5], [1, 1, 1])
        with self.assertRaisesRegex(ValueError, "'dome/0/0' may reach into"):
            quoin.shapes.cut(quoin.shapes.dome(3.0, 0.4, 4, 12, **MASONRY)[12:], [-5, -5, -5], [10, 10, 10])
        gone = quoin.shapes.cut(wall, [-1, -1, -1], [3, 1.2, 3])
        self.assertEqual({b.name.split("/")[1] for b in gone}, {"1"})

    def test_what_makes_no_shape_is_refused_by_its_name(self):
        for words, call in (("bond = 'monk'", lambda: quoin.shapes.wall("monk", 4, 1.0, [0.2, 0.1, 0.1], **MASONRY)),
                            ("courses = 0", lambda: quoin.shapes.wall("stack", 0, 1.0, [0.2, 0.1, 0.1], **MASONRY)),
                            ("radius = nan", lambda: quoin.shapes.dome(math.nan, 0.1, 3, 8, **MASONRY)),
                            ("thickness = 9", lambda: quoin.shapes.dome(3.0, 9, 3, 8, **MASONRY)),
                            ("pier_width", lambda: quoin.shapes.arch_bridge(2, 3.0, 1.5, 0.4, 1.0, 9, 0.1, 1.0, **MASONRY))):
            with self.assertRaisesRegex(ValueError, words):
                call()


if __name__ == "__main__":
    unittest.main(verbosity=2)
