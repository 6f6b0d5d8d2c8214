"""host/scenes/cube_wall_*.toml in LAMMPS:  python3 cube_wall.py SCENE.toml --time-step SECONDS [options]

A cube is a rigid body of eight atoms at its corners, where its contact points are."""
import os
import sys
import tempfile
import time
import timeit

import numpy as np
from lammps import lammps

here = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path[:0] = [os.path.join(here, p) for p in ("../shared", "../../python")]  # an installed quoin is found by itself
import cube_scene
from atom_joints import AtomJoints

CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2


class Cubes:
    """Force, moment, velocity and rotation rate of cubes from values at their eight corners: (cubes, 3) each."""

    def __init__(self, size):
        self.arm = CORNERS * size
        # A rotation w moves a corner at r by w x r. The sum of r x (w x r) over the corners is `turn` w along each axis.
        self.turn = np.sum(np.sum(self.arm**2, 1)[:, None] - self.arm**2, 0)

    def sums(self, at_corners):
        """Returns the sum of the values at the corners, and the sum of r x value."""
        at_corners = at_corners.reshape(-1, 8, 3)
        return at_corners.sum(1), np.cross(self.arm, at_corners).sum(1)

    def motion(self, velocity):
        linear, turning = self.sums(velocity)
        return linear / 8, turning / self.turn

    def corner_forces(self, force, moment):
        return (force[:, None] / 8 + np.cross((moment / self.turn)[:, None], self.arm)).reshape(-1, 3)


class Test(AtomJoints):
    """Adds to the law's forces local damping of rigid bodies and a driven body, which LAMMPS does not have."""

    def __init__(self, options):
        self.wall = wall = cube_scene.CubeWall(options)
        self.cubes = Cubes(wall.size)
        corner = wall.centre[:, None] + self.cubes.arm
        self.lmp = lmp = lammps(cmdargs=["-screen", "none", "-log", "none"])
        low, high = corner.min((0, 1)) - wall.size, corner.max((0, 1)) + wall.size
        box = " ".join(f"{a} {b}" for a, b in zip(low, high))
        lmp.commands_list(["units si", "atom_style bond", "atom_modify map array sort 0 0", "boundary f f f",
                           f"region box block {box}", "create_box 1 box", f"mass 1 {wall.mass / 8!r}",
                           "pair_style zero 0.001", "neighbor 0.001 nsq", "neigh_modify once yes",
                           "comm_modify cutoff 0.01", f"timestep {options.time_step!r}"])
        count = corner.size // 3
        lmp.create_atoms(count, list(range(1, count + 1)), [1] * count, corner.ravel().tolist())
        lmp.numpy.extract_atom("molecule")[:count] = np.arange(count) // 8 + 1
        lmp.command("pair_coeff * *")
        self.make_bodies()
        lmp.command("fix law all external pf/callback 1 1")

        def atom(body):
            """Returns the atom at the corner of a body nearest to each point."""
            return body * 8 + np.abs(corner[body] - wall.position[:, None]).sum(2).argmin(1)

        super().__init__(wall.material, atom(wall.body_a), atom(wall.body_b), wall.normal, wall.area, lmp)
        self.attach("law")

    def make_bodies(self):
        """Defines the rigid bodies. No fix moves the bottom course. The top course moves by forces along x and y only."""
        wall, first = self.wall, len(self.wall.bottom)
        rigid = range(first, len(wall.centre))
        self.body_file = tempfile.NamedTemporaryFile("w", suffix=".rigid")  # read when the run begins
        inertia = " ".join(repr(float(i)) for i in wall.inertia)
        self.body_file.write(f"{len(rigid)}\n")
        for i in rigid:
            centre = " ".join(repr(float(x)) for x in wall.centre[i])
            self.body_file.write(f"{i + 1} {wall.mass!r} {centre} {inertia} 0 0 0 0 0 0 0 0 0 0 0 0\n")
        self.body_file.flush()
        top = f"{wall.top[0] - first + 1}*{len(rigid)}"
        self.lmp.commands_list([f"group moving molecule {first + 1}:{len(wall.centre)}",
                                f"fix bodies moving rigid molecule infile {self.body_file.name} force {top} on on off "
                                f"torque {top} off off off"])

    def callback(self, _, step, atom_count, tag, x, f):
        """Returns damping forces at the positions x(t); velocities are those at t - dt/2, as in Quoin's host."""
        wall, top = self.wall, self.wall.top
        displacement = x - self.reference
        moved = displacement.reshape(-1, 8, 3)[top, :, 0].mean()
        wall.swap_when_due(self, moved)
        at_corners = self.forces(displacement)
        force, moment = self.cubes.sums(at_corners)
        wall.record(moved, -force[top, 0].sum())

        velocity, spin = self.cubes.motion(self.lmp.numpy.extract_atom("v")[:len(f)])
        damping = -wall.damping * np.abs(force) * np.where(velocity < 0, -1.0, 1.0)
        # The first force acts for half a step only.
        speed_up = 2 * wall.speed(0) if step == 0 else wall.speed(step) - wall.speed(step - 1)
        damping[top, 0] = self.wall.mass * speed_up / wall.options.time_step - force[top, 0]
        turning = -wall.damping * np.abs(moment) * np.where(spin < 0, -1.0, 1.0)
        f[:] = at_corners + self.cubes.corner_forces(damping, turning)

    def run(self):
        path, steps = 0.0, 0  # displacement of the top course, m, after `steps` steps
        while path < self.wall.end:
            path += self.wall.speed(steps) * self.wall.options.time_step
            steps += 1
        start = time.perf_counter()
        self.lmp.command(f"run {steps}")
        self.wall.write(time.perf_counter() - start, self)

    def print_cost(self):
        """Measures the cost of the adapter's parts, ns for each point and step."""
        x, f = (self.lmp.numpy.extract_atom(name)[:len(self.reference)] for name in "xf")
        everything, law = (min(timeit.repeat(part, number=100, repeat=5)) / 100 / len(self.area) * 1e9
                           for part in (lambda: AtomJoints.callback(self, None, 0, len(x), None, x, f), self.step))
        print(f"adapter, ns a point and step: arrays {everything - law:.0f}, law {law:.1f}; nothing is copied")


test = Test(cube_scene.parser("cube_wall.py").parse_args())
test.run()
test.print_cost()
