"""Generators of masonry: what they fill, that nothing overlaps, that it stands."""
import math
import unittest

import numpy as np
import quoin
from support import Folder

MASONRY = dict(material="stone")


def volume_of(block):
    """Of a box, or of the hull of its vertices: pyramids over its faces, from the middle."""
    if "box" in block:
        return math.prod(block.box.size)
    points = np.array(block.vertices)
    centre, total = points.mean(axis=0), 0.0
    for face in hull_faces(points):
        for a, b in zip(face[1:], face[2:]):
            total += abs(np.dot(face[0] - centre, np.cross(a - face[0], b - face[0]))) / 6
    return total


def hull_faces(points):
    """Planes through three points that have all others on one side, with their points in order. For few points."""
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
        """Under its weight nothing moves by more than `sag`, m; blocks that overlap are refused when the model is made."""
        sim = quoin.Simulation(scene_of(blocks))
        sim.run()
        history = sim.history
        self.assertLess(history["largest_displacement_m"].max(), sag)
        self.assertGreater(history["largest_displacement_m"].max(), 1e-8)  # it does weigh

    def test_bonds_fill_their_wall(self):
        # 1.1 m, 4 courses of 0.0625 m; one unit of 0.22 m or one width of 0.11 m thick.
        for bond in quoin.shapes.BONDS:
            with self.subTest(bond):
                blocks = quoin.shapes.wall(bond, 4, 1.1, [0.22, 0.0625, 0.11], **MASONRY)
                thickness = 0.11 if bond in ("running", "third", "stack") else 0.22
                self.assert_fills(blocks, 1.1 * 4 * 0.0625 * thickness)

    def test_bonds_bond(self):
        # No joint across the wall stands above another in the course below, but in stack bond and at the ends.
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
        # A wedge of a ring with straight chords: (ro2 - ri2) / 2 sin(step) a radian of it.
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
