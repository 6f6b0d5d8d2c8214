"""Members that are defined in Python: they carry loads, and their columns are in the history."""
import unittest

import quoin
from support import Folder


def two_towers():
    """Returns two rigid piers at a distance of 2 m on a fixed base."""
    scene = quoin.Scene(title="two towers")
    scene.solver = dict(damping="viscous", mass_damping=10.0, stiffness_damping=1e-5)
    scene.materials.stone = quoin.BlockMaterial(density=2000.0, young_modulus=1e10, poisson_ratio=0.2)
    scene.joints.dry = quoin.Joint(law="coulomb_slip", initial_state="dry", normal_stiffness=1e9, shear_stiffness=1e9,
                                   friction_angle=35.0)
    scene.joints.bond = quoin.Joint(law="bond_slip", normal_stiffness=1e10, shear_stiffness=5e9, bond_strength=0.5e6,
                                    peel_strength=0.5e6, fracture_energy=100.0)
    scene.joint_rule.append(quoin.JointRule(family="dry"))
    scene.block.append(quoin.Block(name="base", material="stone", fixed=True, box=dict(lower=[-1, -1, -1], size=[6, 1, 4])))
    for name, x in (("left", 0.0), ("right", 3.0)):
        scene.block.append(quoin.Block(name=name, material="stone", box=dict(lower=[x, 0, 0], size=[1, 2, 2])))
    scene.output = dict(frames=1, energy=True, plots=False)
    scene.stage.append(quoin.Stage(name="push", gravity=[2.0, -9.81, 0.0], ramp_time=0.2, duration=0.4))
    return scene


class Members(Folder):
    def test_all_kinds_run(self):
        scene = two_towers()
        scene.tie.append(quoin.Tie(**{"from": dict(block="left", point=[0.5, 1.9, 0.2]),
                                      "to": dict(block="right", point=[3.5, 1.9, 0.2])},
                                   name="rod", area=1e-4, young_modulus=200e9, yield_stress=235e6))
        scene.spring.append(quoin.Spring(name="side", block="right", normal=[1, 0, 0], normal_stiffness=1e6))
        scene.strip.append(quoin.Strip(name="sheet", joint="bond", points=[[0.5, 0.5, 2], [0.5, 1.5, 2]], width=0.05,
                                       thickness=1e-3, young_modulus=80e9, spacing=0.1))
        scene.floor.append(quoin.Floor(name="deck", corner=[1, 1.5, 0.5], along=[2, 0, 0], across=[0, 0, 1], spacing=0.5,
                                       axial_stiffness=[1e7, 1e7], shear_stiffness=1e6, mass=100.0, span="along",
                                       connector=dict(axial_stiffness=1e7, shear_stiffness=1e7, axial_strength=1e4)))
        beam = quoin.Beam(name="lintel", points=[[0.5, 2, 1.5], [3.5, 2, 1.5]], spacing=0.25, area=0.01,
                          inertia=[8e-6, 8e-6], young_modulus=10e9, density=500.0, bedding="resting")
        scene.beam.append(beam)
        scene.dowel.append(quoin.Dowel(name="pin", point=[0.5, 0, 1], direction=[0, 1, 0], axial_stiffness=1e8,
                                       shear_stiffness=1e7, yield_force=1e5, yield_shear=1e5))
        scene.fill.append(quoin.Fill(name="soil", block="left", towards=[-1, 0, 0], surface=[0, 1, 0], unit_weight=18e3,
                                     friction_angle=30.0, stiffness=1e7))
        scene.check()
        run = quoin.run(scene, out=self.path("out"))
        names = run.history.dtype.names
        for column in ("tie_rod_N", "spring_side_x_N", "strip_sheet_debonded_m", "floor_deck_shear_N_per_m",
                       "floor_deck_anchor_N_per_m", "floor_deck_pulled_out_m", "beam_lintel_N", "beam_lintel_Nm",
                       "dowel_pin_N", "dowel_pin_shear_N", "fill_soil_x_N"):
            self.assertIn(column, names)
        last = run.history[-1]
        self.assertGreater(last["spring_side_x_N"] ** 2, 0.0)
        # Twelve pieces of 0.25 m on two walls, free over 2 m: a beam with fixed ends has w L^2/12.
        w = 0.01 * 500.0 * 9.81
        self.assertGreater(last["beam_lintel_Nm"], 0.8 * w * 4 / 12)
        self.assertLess(last["beam_lintel_Nm"], 1.2 * w * 4 / 8)
        # Between active and passive pressure of a metre of soil.
        self.assertGreater(last["fill_soil_x_N"], 18e3 / 3)
        self.assertLess(last["fill_soil_x_N"], 18e3 * 3)
        scene.write(self.path("scene.toml"))
        self.assertEqual(quoin.Scene.load(self.path("scene.toml")), scene)

    def test_a_moving_load_is_worst_where_it_turns_a_pier_over(self):
        scene = two_towers()
        scene.stage.append(quoin.Stage(name="crossing", gravity=[0, -9.81, 0], duration=0.5, moving_load=dict(
            {"from": [-1.75, 4.0, 1.0], "to": [-1.25, 4.0, 1.0]}, force=[20e3, -20e3, 0.0], positions=3)))
        limit = quoin.limit(scene, moving=True, associated=True)
        # The load acts at 45 deg on the left pier's top and rotates it about its edge at x = 1, against its weight of 78.5 kN.
        places = limit.summary["moving"]["positions"]
        for place in places:
            x, y, _ = place["at_m"]
            self.assertAlmostEqual(place["multiplier"], 2000 * 9.81 * 4 * 0.5 / (20e3 * (y - 1 + x)), delta=1e-3)
        self.assertEqual(limit.multiplier, min(place["multiplier"] for place in places))

    def test_a_floor_in_the_air_is_refused(self):
        scene = two_towers()
        scene.floor.append(quoin.Floor(corner=[1, 9, 0.5], along=[2, 0, 0], across=[0, 0, 1], spacing=0.5,
                                       axial_stiffness=[1e7, 1e7], shear_stiffness=1e6, mass=100.0,
                                       connector=dict(axial_stiffness=1e7, shear_stiffness=1e7)))
        with self.assertRaisesRegex(quoin.BadInput, "meets no wall"):
            quoin.Simulation(scene)


if __name__ == "__main__":
    unittest.main()
