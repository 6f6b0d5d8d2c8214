"""Earthquakes from Python: damping ratios, three components, monitors, base shear, groups of supports, energies."""
import csv
import math
import unittest

import numpy as np
import quoin
from support import Folder

DENSITY, KN, KS, G = 1800.0, 1e9, 4e8, 9.81
DEFORMABLE = dict(rigid=False, divisions=[2, 2, 2])


def stacked(cubes, deformable=False, stage=None, **ground):
    """Returns cubes of 1 m on each other on a wide ground, under weight from the start, then with ground motion."""
    scene = quoin.Scene(title="stack")
    scene.materials["stone"] = quoin.BlockMaterial(density=DENSITY, young_modulus=3e9, poisson_ratio=0.2)
    scene.joints["joint"] = quoin.Joint(law="elastic", normal_stiffness=KN, shear_stiffness=KS)
    scene.contact = dict(cubic_points=False)
    scene.block.append(quoin.Block(name="ground", material="stone", fixed=True,
                                   box=dict(lower=[-1, -0.2, -1], size=[3, 0.2, 3])))
    for i in range(cubes):
        extra = DEFORMABLE if deformable else {}
        scene.block.append(quoin.Block(name=f"cube{i}", material="stone", box=dict(lower=[0, i, 0], size=[1, 1, 1]),
                                       **extra))
    scene.stage = [quoin.Stage(name="weight", gravity=[0, -G, 0], ramp_time=0.1, duration=0.3),
                   quoin.Stage(name="shake", **(stage or {}), ground_motion=ground)]
    scene.output = dict(frames=0, energy=True, plots=False, monitor=f"cube{cubes - 1}")
    return scene


def duhamel(time, acceleration, period, damping):
    """Returns the largest displacement by the convolution of the record with the free decay after a unit of velocity, until
    one period after the record."""
    dt, omega = time[1] - time[0], 2 * math.pi / period
    damped = omega * math.sqrt(1 - damping ** 2)
    t = np.arange(0, time[-1] + period, dt)
    decay = np.exp(-damping * omega * t) * np.sin(damped * t) / damped
    return np.abs(np.convolve(acceleration, decay)[:len(t)]).max() * dt


def sway(normal, along):
    """Returns frequency (Hz) and damping ratio of the lower mode of a cube on springs at its lower corners, for given ratios
    of viscosity and stiffness, s. Springs act on u0 = u + theta/2 along the base and on theta/2 at the corners."""
    mass, inertia = DENSITY, DENSITY / 6
    k = np.array([[KS, 0.5 * KS], [0.5 * KS, 0.25 * (KS + KN)]])
    c = np.array([[along * KS, 0.5 * along * KS], [0.5 * along * KS, 0.25 * (along * KS + normal * KN)]])
    root = np.diag([mass, inertia]) ** 0.5
    squares, shapes = np.linalg.eigh(np.linalg.inv(root) @ k @ np.linalg.inv(root))
    shape = np.linalg.inv(root) @ shapes[:, 0]
    omega = math.sqrt(squares[0])
    return omega / (2 * math.pi), shape @ c @ shape / (2 * omega)


class ResponseSpectra(Folder):
    DT = 1e-4
    TIME = np.arange(0, 2 + DT / 2, DT)
    RECORD = 3 * np.sin(2 * math.pi * TIME / 0.4)

    def test_a_harmonic_record_has_the_spectrum_of_duhamels_integral(self):
        """The sum of the convolution is that of a trapezium, exact to (w dt)^2/12 = 4e-6; five periods of forcing at
        resonance, 0.4 s, and beside it."""
        for damping in (0.0, 0.05, 0.3):
            periods, sa, sv, sd = quoin.response_spectrum(self.DT, self.RECORD, [0.1, 0.4, 0.7, 3.0], damping)
            for k, period in enumerate(periods):
                expected = duhamel(self.TIME, self.RECORD, period, damping)
                self.assertAlmostEqual(sd[k] / expected, 1, delta=1e-3, msg=f"{period} s, {damping}")
                self.assertAlmostEqual(sv[k], 2 * math.pi / period * sd[k], delta=1e-12 * sv[k])
                self.assertAlmostEqual(sa[k], 2 * math.pi / period * sv[k], delta=1e-12 * sa[k])

    def test_it_is_that_of_the_command(self):
        every = slice(None, None, 50)
        with open(self.path("record.csv"), "w", encoding="utf-8") as file:
            file.write("time_s,x_m/s2\n" + "".join(f"{t},{a}\n" for t, a in zip(self.TIME[every].tolist(),
                                                                             self.RECORD[every].tolist())))
        done = self.command("spectrum", self.path("record.csv"), "--out", self.path("spectrum"))
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.path("spectrum/spectrum.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        found = quoin.response_spectrum(self.TIME[every], self.RECORD[every])
        self.assertEqual(len(found.periods), 200)
        for values, column in ((found.periods, "period_s"), (found.Sd, "displacement_m"),
                               (found.Sv, "pseudo_velocity_m_s"), (found.Sa, "pseudo_acceleration_m_s2")):
            np.testing.assert_allclose(values, [float(row[column]) for row in rows], rtol=1e-5)

    def test_bad_input_is_refused(self):
        for time, values, more, text in ((0.0, [1, 2], {}, "times do not increase"), ([0, 1], [1, 2, 3], {}, "shapes"),
                                         (0.1, [1, math.nan], {}, "not finite"), (0.1, [1, 2], {"damping": 1.0}, "damping"),
                                         (0.1, [1, 2], {"periods": [-1.0]}, "period"), (0.1, [1], {}, "2 samples")):
            with self.assertRaisesRegex(quoin.BadInput, text):
                quoin.response_spectrum(time, values, **more)


class Earthquakes(Folder):
    def run_scene(self, scene):
        return quoin.run(scene, out=self.path("out"), threads=1)

    def monitors(self):
        with open(self.path("out/monitors.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        columns = {key: np.array([float(row[key] or "nan") for row in rows]) for key in rows[0]}
        read = quoin.open(self.path("out")).monitors
        self.assertEqual(read.dtype.names, tuple(columns))
        for key, column in columns.items():
            np.testing.assert_array_equal(read[key], column)
        return columns

    def test_damping_ratios_are_those_of_a_cube_on_its_joint(self):
        """Weight reduces the rocking stiffness by m g h: a share of 1e-4."""
        results = self.run_scene(stacked(1, stage=dict(duration=0.2), direction=[1, 0, 0], time=[0, 0.2], acceleration=[0, 1]))
        modes = results.summary["damping_of_modes"]["shake"]
        used = results.summary["impact_damping_in_use"]
        # The edge of an impact is 0.5 m beside and 0.5 m below the centre.
        landing = math.sqrt(0.5 * (1 / DENSITY + 0.25 / (DENSITY / 6)))
        normal, along = 2 * used / (landing * math.sqrt(KN)), used / (landing * math.sqrt(KS))
        frequency, ratio = sway(normal, along)
        self.assertEqual(len(modes), 3)
        for mode in modes[:2]:  # along x and z
            self.assertAlmostEqual(mode["frequency_Hz"], frequency, delta=1e-3 * frequency)
            self.assertAlmostEqual(mode["damping_ratio"], ratio, delta=1e-3 * ratio)
        upright = math.sqrt(KN / DENSITY)
        self.assertAlmostEqual(modes[2]["damping_ratio"], 0.5 * normal * upright, delta=1e-3 * normal * upright)

    def test_three_components_of_rigid_and_deformable_blocks(self):
        """Under a constant acceleration the base shear is m a; energies balance to 1 % of the work of the ground."""
        for deformable in (False, True):
            with self.subTest(deformable=deformable):
                # A direction with three different components: 1.5, 0.3 and -0.6 m/s2 for 0.5 s.
                scene = stacked(2, deformable, stage=dict(duration=0.5), direction=[1, 0.2, -0.4],
                                time=[0, 0.5], acceleration=[1.5 * math.sqrt(1.2)] * 2)
                scene.monitor = [quoin.Monitor(name="low", block="cube0", point=[0, 1, 0]),
                                 quoin.Monitor(name="top", block="cube1", point=[0, 2, 0], below="low")]
                results = self.run_scene(scene)
                history = results.history[results.history["stage"] == 2]
                # Vibrations of the joints have decayed after 0.1 s.
                late = history[history["time_s"] > history["time_s"][0] + 0.2]
                mass = 2 * DENSITY
                for column, expected in (("base_shear_x_N", 1.5 * mass), ("base_shear_z_N", -0.6 * mass)):
                    self.assertAlmostEqual(abs(late[column].mean()), abs(expected), delta=0.01 * abs(expected))
                self.assertLess(late["base_shear_x_N"].mean() * late["base_shear_z_N"].mean(), 0)
                self.assertAlmostEqual(abs(late["base_vertical_N"].mean()), mass * (G + 0.3), delta=0.01 * mass * G)
                # The centre of the two cubes is 1 m above the base.
                self.assertAlmostEqual(abs(late["overturning_moment_z_Nm"].mean()), 1.5 * mass, delta=0.01 * 1.5 * mass)
                work = history["external_work_J"][-1] - history["external_work_J"][0]
                self.assertLess(np.abs(history["energy_balance_error_J"]).max(), 0.01 * work)

                columns = self.monitors()
                for axis in "xz":
                    drift = columns[f"top_d{axis}_m"] - columns[f"low_d{axis}_m"]
                    np.testing.assert_allclose(columns[f"top_drift_{axis}"], drift, atol=1e-12)  # over 1 m
                relative = columns["top_dx_m"] - columns["ground_dx_m"]
                np.testing.assert_allclose(columns["top_relative_dx_m"], relative, atol=1e-9)
                self.assertGreater(np.abs(columns["top_drift_x"]).max(), 1e-6)

    def test_groups_of_supports(self):
        """A block of the ground that settles by 2 mm moves its cube, and not the other."""
        scene = stacked(1, stage=dict(duration=0.3))
        for name, x, fixed in (("pier", 4.0, True), ("on_pier", 4.5, False)):
            scene.block.append(quoin.Block(name=name, material="stone", fixed=fixed, box=dict(
                lower=[x, -0.2 if fixed else 0.0, 0], size=[2 if fixed else 1, 0.2 if fixed else 1, 1])))
        scene.stage[1].ground_motion = dict(support=[dict(blocks=["pier"], direction=[0, -1, 0],
                                                          time=[0, 0.1, 0.2], displacement=[0, 0.001, 0.002])])
        scene.monitor.append(quoin.Monitor(name="still", block="cube0"))
        scene.monitor.append(quoin.Monitor(name="sinks", block="on_pier"))
        self.run_scene(scene)
        columns = self.monitors()
        shaken = columns["time_s"] > 0.3
        start = {key: columns[key][~shaken][-1] for key in ("still_dy_m", "sinks_dy_m")}
        self.assertAlmostEqual(columns["sinks_dy_m"][-1] - start["sinks_dy_m"], -0.002, delta=2e-6)
        self.assertAlmostEqual(columns["still_dy_m"][-1] - start["still_dy_m"], 0.0, delta=2e-6)


if __name__ == "__main__":
    unittest.main()
